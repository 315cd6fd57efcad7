"""Real measured friction tables in the columns of the diagnosis.

Every function takes the folder that holds the measurements (with ``stribeck_motor_oil_glass``, ``rate_state_sepiolite``
and ``real`` inside) and returns the points, the test table and a description of the mapping. Nothing is fitted here.

Loads that the source did not record are held constant at a value that every law can take (no zero speed, no zero
pressure). A constant load carries no information: an answer that names it as the driver is wrong. With
``fill_missing=False`` these columns are left out instead.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

Table = tuple[pd.DataFrame, pd.DataFrame, str]

COLUMNS = ["test_id", "t", "v_rel", "T", "sigma_n", "sd", "psi", "mu"]
NOT_RECORDED = {"t": 0.0, "v_rel": 1.0, "T": 25.0, "sigma_n": 1.0, "sd": 0.0, "psi": 0.0}


def _finish(points: pd.DataFrame, tests: pd.DataFrame, description: str, fill_missing: bool) -> Table:
    """Order the columns, fill loads that were not recorded and keep the tests that have points."""
    points = points.copy()
    missing = [name for name in NOT_RECORDED if name not in points]
    if fill_missing:
        for name in missing:
            points[name] = NOT_RECORDED[name]
        how = ", ".join(f"{name} = {NOT_RECORDED[name]:g}" for name in missing)
        description += f" Not recorded, held constant: {how}." if missing else ""
    else:
        description += f" Not recorded, left out: {', '.join(missing)}." if missing else ""
    points["test_id"] = points["test_id"].astype(str)
    tests = tests.assign(test_id=tests["test_id"].astype(str))
    tests = tests[tests["test_id"].isin(points["test_id"])].reset_index(drop=True)
    return points[[name for name in COLUMNS if name in points]].reset_index(drop=True), tests, description


def motor_oil(
    folder: Path | str, min_load: float = 1.5, series: bool = False, fill_missing: bool = True
) -> Table:
    """Steel on glass in motor oil: 16 loads at 3 speeds.

    Parameters
    ----------
    folder
        Folder of the measurements.
    min_load
        Smallest nominal load in N. Below 1.5 N the bearing drag that was subtracted is larger than the friction.
    series
        Take the time series (about 300 points a test) instead of one mean a test.
    fill_missing
        Hold loads that were not recorded constant; otherwise leave them out.

    Returns
    -------
    tuple
        Points, test table, description.
    """
    source = Path(folder) / "stribeck_motor_oil_glass"
    summary = pd.read_csv(source / "summary.csv")
    summary = summary[summary["load_nominal_N"] >= min_load]
    tests = pd.DataFrame({"test_id": summary["test"].astype(str)})
    if series:
        raw = pd.read_csv(source / "timeseries.csv")
        raw = raw[raw["test"].isin(summary["test"])].sort_values(["test", "t_since_contact_s"], kind="stable")
        step = raw.groupby("test")["t_since_contact_s"].diff().fillna(0.0)
        points = pd.DataFrame(
            {
                "test_id": raw["test"],
                "t": raw["t_since_contact_s"],
                "v_rel": raw["v_mm_s"],
                "sigma_n": raw["sigma_n_MPa"],
                "sd": (raw["v_mm_s"] * step).groupby(raw["test"]).cumsum(),
                "mu": raw["mu"],
            }
        )
    else:
        columns = {"test": "test_id", "v_mm_s": "v_rel", "sigma_n_MPa": "sigma_n"}
        points = summary.rename(columns=columns)[["test_id", "v_rel", "sigma_n", "mu"]]
    description = (
        f"A test is one load at one speed (nominal load >= {min_load:g} N); "
        + ("time series, distance = sum of speed times time step. " if series else "one mean a test. ")
        + "mm/s and MPa as in the source. No test was repeated."
    )
    return _finish(points, tests, description, fill_missing)


def sepiolite(folder: Path | str, pieces: int = 1, fill_missing: bool = True) -> Table:
    """Sepiolite gouge, one speed step from 0.2 to 2 micrometre a second at 30 MPa.

    Parameters
    ----------
    folder
        Folder of the measurements.
    pieces
        Cut the record into this many consecutive pieces called tests. Pieces are not repeats; only a variant to try.
    fill_missing
        Hold loads that were not recorded constant; otherwise leave them out.

    Returns
    -------
    tuple
        Points, test table, description.
    """
    raw = pd.read_csv(Path(folder) / "rate_state_sepiolite" / "sepiolite.csv")
    piece = np.minimum(np.arange(len(raw)) * pieces // len(raw), pieces - 1)
    points = pd.DataFrame(
        {
            "test_id": [f"sepiolite_{number}" for number in piece],
            "t": raw["t_s"] - raw["t_s"].iloc[0],
            "v_rel": raw["v_um_s"] / 1000,
            "sigma_n": raw["sigma_n_MPa"],
            "sd": raw["sliding_distance_um"] / 1000,
            "mu": raw["mu"],
        }
    )
    tests = pd.DataFrame({"test_id": points["test_id"].unique()})
    description = (
        f"ONE test{'' if pieces == 1 else f', cut into {pieces} consecutive pieces'}; micrometres made millimetres; "
        "distance counted from the start of the experiment (5.75 mm at the first point)."
    )
    return _finish(points, tests, description, fill_missing)


def _real(folder: Path | str, name: str) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Read the points and the test table of one of the tables under ``real``."""
    source = Path(folder) / "real" / name
    return pd.read_csv(source / "points.csv"), pd.read_csv(source / "tests.csv")


def _miba(folder: Path | str, name: str, system: str | None, blocks: bool, fill_missing: bool) -> Table:
    points, tests = _real(folder, name)
    if system is not None:
        tests = tests[tests["system"] == system].drop(columns="system")
        points = points[points["test_id"].isin(tests["test_id"])]
    if blocks:
        number = points["test_id"].str[1:].astype(int)
        block = points["test_id"].str[0] + "_" + (number // 6).astype(str).str.zfill(3)
        points = points.assign(t=(number % 6).astype(float), test_id=block)
        if system is None:
            tests = pd.DataFrame(
                {"test_id": block.unique(), "system": block.drop_duplicates().str[0].to_numpy()}
            )
        else:
            tests = pd.DataFrame({"test_id": block.unique()})
    description = (
        f"{'All fourteen friction systems' if system is None else f'Friction system {system}'}; "
        + (
            "a test is a block of six readings at one pressure and speed, t counts the readings"
            if blocks
            else "one reading a test"
        )
        + ". sigma_n in the unknown unit of the source, v_rel in mm/s, T the temperature T_0 of the source."
    )
    return _finish(points, tests, description, fill_missing)


def miba_dynamic(
    folder: Path | str, system: str | None = None, blocks: bool = False, fill_missing: bool = True
) -> Table:
    """Dynamic friction of fourteen friction systems at six pressures and four speeds, six readings each.

    Parameters
    ----------
    folder
        Folder of the measurements.
    system
        One letter a ... n; None takes all systems with ``system`` in the test table.
    blocks
        Six consecutive readings (same pressure and speed, warming up) form one test.
    fill_missing
        Hold loads that were not recorded constant; otherwise leave them out.

    Returns
    -------
    tuple
        Points, test table, description.
    """
    return _miba(folder, "miba_dynamic", system, blocks, fill_missing)


def miba_static(
    folder: Path | str, system: str | None = None, blocks: bool = False, fill_missing: bool = True
) -> Table:
    """Give static friction of the same systems: pressure and temperature only. Parameters as in ``miba_dynamic``."""
    return _miba(folder, "miba_static", system, blocks, fill_missing)


def _pla(folder: Path | str, name: str, with_order: bool, skip_turns: int, fill_missing: bool) -> Table:
    points, tests = _real(folder, name)
    if not with_order:
        tests = tests[["test_id"]]
    if skip_turns:
        points = points[points.groupby("test_id").cumcount() >= skip_turns]
    description = (
        "A test is one load; points are means of one turn; 10 mm/s; 20 mm a turn assumed. Loads were run one after the "
        f"other, so order and load are the same thing. First turns left out: {skip_turns}."
    )
    return _finish(points, tests, description, fill_missing)


def pla_dragonskin(
    folder: Path | str, with_order: bool = True, skip_turns: int = 0, fill_missing: bool = True
) -> Table:
    """Give printed PLA on silicone Dragon Skin at 70 rising loads.

    Parameters
    ----------
    folder
        Folder of the measurements.
    with_order
        Give the order of the tests; it follows the load.
    skip_turns
        Turns left out at the start of every test.
    fill_missing
        Hold loads that were not recorded constant; otherwise leave them out.

    Returns
    -------
    tuple
        Points, test table, description.
    """
    return _pla(folder, "pla_dragonskin", with_order, skip_turns, fill_missing)


def pla_sil950(
    folder: Path | str, with_order: bool = True, skip_turns: int = 0, fill_missing: bool = True
) -> Table:
    """Give printed PLA on silicone Sil 950 at 59 rising loads. Parameters as in ``pla_dragonskin``."""
    return _pla(folder, "pla_sil950", with_order, skip_turns, fill_missing)


def pneumatic_seal(
    folder: Path | str, ring: str | None = None, strokes: slice | None = None, fill_missing: bool = True
) -> Table:
    """Seal rings of a printed pneumatic cylinder: 7 rings, 4 pressures, 10 strokes each.

    Parameters
    ----------
    folder
        Folder of the measurements.
    ring
        One ring only (then ``batch`` is left out); None takes all.
    strokes
        Strokes of each ring and pressure to keep, for example ``slice(5, None)`` for the last five.
    fill_missing
        Hold loads that were not recorded constant; otherwise leave them out.

    Returns
    -------
    tuple
        Points, test table, description.
    """
    points, tests = _real(folder, "pneumatic_seal")
    tests = tests.drop(columns="sigma_set")
    if ring is not None:
        tests = tests[tests["batch"] == ring].drop(columns="batch")
    if strokes is not None:
        tests = tests[tests["order"].isin(range(10)[strokes])]
    points = points[points["test_id"].isin(tests["test_id"])]
    description = (
        "A test is one stroke out; the ten strokes of a ring at a pressure are true repeats; batch is the ring; order "
        "counts the strokes at one pressure. mu is the friction force over pressure times area."
    )
    return _finish(points, tests, description, fill_missing)


def al10cu_composites(folder: Path | str, skip_start: float = 0.0, fill_missing: bool = True) -> Table:
    """Aluminium alloy and three composites on a disc, dry: three runs a material.

    Parameters
    ----------
    folder
        Folder of the measurements.
    skip_start
        Seconds left out at the start of every run.
    fill_missing
        Hold loads that were not recorded constant; otherwise leave them out.

    Returns
    -------
    tuple
        Points, test table, description.
    """
    points, tests = _real(folder, "al10cu_composites")
    points = points[points["t"] >= skip_start]
    description = (
        "A test is one run of 7 minutes at 50 N and 333 mm/s; batch is the share of Al2O3; the three runs of a material "
        "are true repeats. The area of the pin is not known."
    )
    return _finish(points, tests, description, fill_missing)


TABLES: dict[str, Callable[..., Table]] = {
    "motor_oil": motor_oil,
    "sepiolite": sepiolite,
    "miba_dynamic": miba_dynamic,
    "miba_static": miba_static,
    "pla_dragonskin": pla_dragonskin,
    "pla_sil950": pla_sil950,
    "pneumatic_seal": pneumatic_seal,
    "al10cu_composites": al10cu_composites,
}
