"""Every format gives back what was written, in the units that were written."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from friction_models.common import InputError
from sct_twin.readers import read_file
from sct_twin.readers.table import Signal, split_unit, table_of_signals

from .reader_files import SUFFIX, WRITERS, write_catman

UNITS = {"t": "s", "F_n": "kN", "Weg": "mm"}
NEEDS = {"MDF": "asammdf", "TDMS": "nptdms", "Excel": "openpyxl"}
#: Largest error of F_n (a range of about 9 kN) that the way of storing it allows.
PRECISION = {"catman 4 bytes": 1e-6, "catman 2 bytes": 1.5e-4}


@pytest.fixture
def frame() -> pd.DataFrame:
    rng = np.random.default_rng(2)
    t = np.arange(400) / 1000.0
    return pd.DataFrame({"t": t, "F_n": 4.0 * rng.standard_normal(400).clip(-1, 1), "Weg": 7.0 + 50.0 * t})


def needs(kind: str) -> None:
    if kind in NEEDS:
        pytest.importorskip(NEEDS[kind], reason=f"{NEEDS[kind]} is not installed (extra [daq])")


@pytest.mark.parametrize("kind", WRITERS)
def test_what_was_written_is_read(tmp_path: Path, frame: pd.DataFrame, kind: str) -> None:
    needs(kind)
    path = tmp_path / f"größe 1{SUFFIX[kind]}"
    WRITERS[kind](path, frame, UNITS)
    table = read_file(path)
    clock = "time" if kind == "MDF" else "t"
    assert set(table.frame.columns) == {clock, "F_n", "Weg"}
    assert table.units == {clock: "s", "F_n": "kN", "Weg": "mm"}
    tolerance = PRECISION.get(kind, 1e-12)
    assert table.frame[clock].to_numpy() == pytest.approx(frame["t"].to_numpy(), abs=tolerance)
    for name in ("F_n", "Weg"):
        assert np.abs(table.frame[name].to_numpy() - frame[name].to_numpy()).max() <= max(
            tolerance, PRECISION.get(kind, 0.0) * 10
        )


def test_utf16_and_round_brackets(tmp_path: Path, frame: pd.DataFrame) -> None:
    path = tmp_path / "labview.txt"
    named = frame.rename(columns={"t": "t (s)", "F_n": "F_n (kN)", "Weg": "Weg [mm]"})
    path.write_text(named.to_csv(index=False, sep="\t", lineterminator="\n"), encoding="utf-16")
    table = read_file(path)
    assert table.units == UNITS
    assert table.frame["F_n"].to_numpy() == pytest.approx(frame["F_n"].to_numpy())


def test_catman_makes_time_from_its_step(tmp_path: Path, frame: pd.DataFrame) -> None:
    path = tmp_path / "no time.bin"
    write_catman(path, frame[["F_n", "Weg"]], UNITS)
    table = read_file(path)
    # The step in the channel header is 1 ms.
    assert table.frame["t"].to_numpy() == pytest.approx(frame["t"].to_numpy())
    assert table.units["t"] == "s"


_APREAD = """
import json, sys, types
from unittest.mock import MagicMock
# Plotting and a progress bar are all that these are for.
plots = types.ModuleType("matplotlib"); plots.pyplot = MagicMock()
bar = types.ModuleType("tqdm"); bar.tqdm = lambda items, **_: items
sys.modules |= {"matplotlib": plots, "matplotlib.pyplot": plots.pyplot, "tqdm": bar}
sys.path.insert(0, sys.argv[1])
from apread import APReader
file = APReader(sys.argv[2])
print("RESULT" + json.dumps({c.Name: [c.unit, [float(v) for v in c.data]] for c in file.Channels}))
"""


@pytest.mark.parametrize("form", [0, 1, 2])
def test_catman_as_an_independent_reader_sees_it(tmp_path: Path, frame: pd.DataFrame, form: int) -> None:
    folder = os.environ.get("TRIBOFMU_APREAD", str(Path(__file__).parents[2] / "build" / "apread"))
    if not (Path(folder) / "apread").is_dir():
        pytest.skip(
            "apread is not installed aside: pip install --no-deps --target build/apread apread==1.1.3"
        )
    path = tmp_path / "x.bin"
    write_catman(path, frame.rename(columns={"t": "Time"}), {**UNITS, "Time": "s"}, form)
    run = subprocess.run(
        [sys.executable, "-c", _APREAD, folder, str(path)],
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        timeout=120,
    )
    answer = next((line for line in run.stdout.splitlines() if line.startswith("RESULT")), None)
    assert answer is not None, run.stderr
    table = read_file(path)
    other = json.loads(answer.removeprefix("RESULT"))
    assert set(other) == set(table.frame.columns)
    for name, (unit, values) in other.items():
        assert table.units[name] == unit
        assert table.frame[name].to_numpy() == pytest.approx(np.array(values), rel=1e-12, abs=1e-12)


def test_channels_of_several_rates_share_the_fastest_time() -> None:
    fast, slow = np.arange(101) / 100.0, np.arange(11) / 10.0
    signals = [
        Signal("F_n", "N", 2.0 * fast, fast),
        Signal("T_plate", "degC", 20.0 + slow, slow),
        Signal("loose", "V", np.zeros(7)),
        Signal("F_n", "N", 3.0 * fast, fast, "second"),
    ]
    table = table_of_signals(signals, "x", "MDF")
    assert table.frame["T_plate"].to_numpy() == pytest.approx(20.0 + fast)
    assert list(table.frame.columns) == ["t", "F_n", "T_plate", "second/F_n"]
    assert any("'loose' has 7 rows" in note for note in table.notes)
    assert any("11 rows interpolated to 101" in note for note in table.notes)


def test_matlab_structs_and_matrices(tmp_path: Path) -> None:
    from scipy.io import savemat

    t = np.arange(60) / 10.0
    path = tmp_path / "s.mat"
    savemat(path, {"F": {"data": 3.0 * t, "unit": "kN"}, "rig": {"time": t, "s": 2.0 * t}, "note": "x"})
    table = read_file(path)
    assert table.units["F"] == "kN"
    assert table.frame["F"].to_numpy() == pytest.approx(3.0 * t)
    assert table.frame["s"].to_numpy() == pytest.approx(2.0 * t)
    names = np.array(["Zeit [s]", "F_n"], dtype=object)
    savemat(path, {"M": np.c_[t, 5.0 * t], "names": names, "units": np.array(["", "N"], dtype=object)})
    table = read_file(path)
    assert table.units == {"Zeit": "s", "F_n": "N"}
    assert table.frame["F_n"].to_numpy() == pytest.approx(5.0 * t)


@pytest.mark.parametrize(
    ("name", "expected"),
    [("F [kN]", ("F", "kN")), ("F (kN)", ("F", "kN")), ("F", ("F", "")), ("[kN]", ("[kN]", ""))],
)
def test_units_in_headings(name: str, expected: tuple[str, str]) -> None:
    assert split_unit(name) == expected


def test_a_missing_library_names_the_extra(tmp_path: Path) -> None:
    from sct_twin.readers.formats import library

    with pytest.raises(InputError, match=r"MDF files need nothing.*pip install 'tribofmu\[daq\]'"):
        library("no_such_module_at_all", "nothing", tmp_path / "x.mf4", "MDF")
