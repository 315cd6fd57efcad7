"""A synthetic campaign: plan, law, tests; raw records for everybody, the truth in files of its own."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from forming.upsetting import PunchGeometry, UpsettingResult
from friction_models.loads import FloatArray, InputError, atomic_folder, atomic_path, write_json, write_text

from ..pool import Progress, map_unordered
from ..raw_campaign import RawCampaign, check_target, write_tables
from ..result import fingerprint
from .experiment import Instruments, run_test
from .law import TrueLaw
from .plans import SIGMA_LEVELS, make_plan, parse_plan
from .specimen import TEMPERATURES, Rig, SpecimenTable, compute_run, solver_fingerprint

TRUTH_JSON, TRUTH_NPZ = "truth.json", "truth.npz"
#: Specimens are upset a little beyond the largest force, for those that are softer.
FORCE_MARGIN = 1.2


@dataclass
class Campaign:
    """A campaign of sliding compression tests that never took place.

    Parameters
    ----------
    plan : str
        ``family-count[+heldout]``: ``factorial-81+30``, ``reduced-27+10``, ``tiny-6+3``.
    hidden : str or sequence of str, optional
        Hidden effects by name (``"stribeck"``, ``"stribeck+wear_out"``); None: the linear law alone.
    seed : int
        Everything random follows from it.
    rig, instruments : Rig, Instruments
        The laboratory's reality and its sensors.
    cache : path-like, optional
        Folder in which upsetting runs are kept; the user's cache folder by default.

    Raises
    ------
    InputError
        Unknown plan or hidden effect, or a seed that is not a whole number from 0 on.
    """

    plan: str = "reduced-27+10"
    hidden: str | Sequence[str] | None = None
    seed: int = 0
    rig: Rig = field(default_factory=Rig)
    instruments: Instruments = field(default_factory=Instruments)
    cache: str | os.PathLike[str] | None = None

    def __post_init__(self) -> None:
        parse_plan(self.plan)
        if isinstance(self.seed, bool) or not isinstance(self.seed, int | np.integer) or self.seed < 0:
            raise InputError(f"campaign: seed {self.seed!r}; allowed: a whole number from 0 on")
        self.law = TrueLaw.draw(self.hidden, int(self.seed))

    @property
    def tests(self) -> pd.DataFrame:
        """Return the test table."""
        return make_plan(self.plan, int(self.seed))

    def run(
        self,
        out: str | os.PathLike[str] | None = None,
        jobs: int | None = None,
        progress: Progress | None = None,
    ) -> RawCampaign:
        """Carry out all tests and write the campaign folder; an interrupted run goes on where it was.

        Parameters
        ----------
        out : path-like, optional
            Folder to write, atomically; a temporary folder that lives as long as the result by default.
        jobs : int, optional
            Processes; all cores by default.
        progress : callable, optional
            Called with (done, total, what).

        Returns
        -------
        RawCampaign
            Raw records and test table, labelled synthetic.

        Raises
        ------
        InputError
            `out` holds something else than a campaign.
        """
        temporary = tempfile.TemporaryDirectory(prefix="tribofmu-lab-") if out is None else None
        target = Path(temporary.name) / "campaign" if temporary is not None else Path(out or "")
        check_target(target)
        tests = self.tests
        rows = tests.to_dict("records")
        report = progress or (lambda done, of, what: None)
        partial = self._partial(target)
        known = {row["test_id"] for row in rows if (partial / "truth" / f"{row['test_id']}.npz").is_file()}
        tables = self._tables(tests, jobs, report, len(rows))
        if known:
            report(len(known), len(rows), f"{len(known)} tests known")
        open_rows = [row for row in rows if row["test_id"] not in known]
        items = [
            (
                row,
                self.law.to_dict(),
                tables[_shape(row)],
                self.rig,
                self.instruments,
                int(self.seed),
                str(partial),
            )
            for row in open_rows
        ]
        for done, (index, _) in enumerate(map_unordered(_test_to_files, items, jobs)):
            test_id = open_rows[index]["test_id"]
            report(len(known) + done + 1, len(rows), f"virtual test {test_id}")
        with atomic_folder(target) as folder:
            (partial / "raw").rename(folder / "raw")
            self._write_truth(partial / "truth", folder, [str(row["test_id"]) for row in rows])
            write_tables(folder, tests, self._info())
        shutil.rmtree(partial, ignore_errors=True)
        campaign = RawCampaign.load(target)
        campaign._temporary = temporary
        return campaign

    def _partial(self, target: Path) -> Path:
        """Return the folder beside `target` in which finished tests wait; emptied if it is another campaign's."""
        partial = target.parent / f".{target.name}.partial"
        key = fingerprint(
            self.plan, self.law.to_dict(), int(self.seed), self.rig, self.instruments, solver_fingerprint()
        )
        mark = partial / "key"
        whole = mark.is_file() and (partial / "raw").is_dir() and (partial / "truth").is_dir()
        if not whole or mark.read_text(encoding="utf-8") != key:
            shutil.rmtree(partial, ignore_errors=True)
            (partial / "raw").mkdir(parents=True)
            (partial / "truth").mkdir()
            write_text(mark, key)
        return partial

    def _write_truth(self, source: Path, folder: Path, ids: list[str]) -> None:
        truth: dict[str, FloatArray] = {}
        scatter: dict[str, dict[str, float]] = {}
        for test_id in ids:
            with np.load(source / f"{test_id}.npz", allow_pickle=False) as stored:
                scatter[test_id] = {n[8:]: float(stored[n]) for n in stored.files if n.startswith("scatter/")}
                truth |= {f"{test_id}/{n}": stored[n] for n in stored.files if not n.startswith("scatter/")}
        np.savez_compressed(folder / TRUTH_NPZ, **truth)  # type: ignore[arg-type]
        write_json(
            folder / TRUTH_JSON,
            {
                "synthetic": True,
                "law": self.law.to_dict(),
                "rig": asdict(self.rig),
                "instruments": asdict(self.instruments),
                "tests": scatter,
            },
        )

    def _tables(
        self, tests: pd.DataFrame, jobs: int | None, report: Progress, total: int
    ) -> dict[float, SpecimenTable]:
        shapes = {_shape(row): float(row["bore"]) for row in tests.to_dict("records")}
        cache = None if self.cache is None else str(self.cache)
        items = [
            (
                PunchGeometry(bore_diameter=bore, tip_diameter=tip or None),
                T,
                FORCE_MARGIN * SIGMA_LEVELS[-1] * np.pi / 4.0 * bore**2,
                self.rig,
                cache,
            )
            for tip, bore in shapes.items()
            for T in TEMPERATURES
        ]
        runs: dict[int, UpsettingResult] = {}
        for index, run in map_unordered(compute_run, items, jobs):
            runs[index] = run
            report(0, total, f"virtual upsetting {len(runs)} of {len(items)}")
        m1 = self.rig.material.m1
        return {shape: SpecimenTable((runs[2 * k], runs[2 * k + 1]), m1) for k, shape in enumerate(shapes)}

    def _info(self) -> dict[str, Any]:
        family, held_out = parse_plan(self.plan)
        return {
            "synthetic": True,
            "notice": "synthetic: made by the virtual laboratory, not measured",
            "plan": self.plan,
            "plan_meaning": family.meaning,
            "held_out": held_out,
            "seed": int(self.seed),
            "moving_mass_kg": self.instruments.moving_mass,
            "sampling_rate_Hz": 1000.0,
            "specimen": {"diameter_mm": 15.0, "height_mm": 15.0, "material": "16MnCr5"},
            "plate": {"material": "1.2379"},
            "units": {
                "sigma_set": "MPa",
                "v_set": "mm/s",
                "T_tool": "degC",
                "T_specimen": "degC",
                "Ra": "um",
                "t_wait": "s",
                "sd_set": "mm",
                "bore": "mm",
                "tip": "mm",
                "F_set": "N",
            },
        }


def load_truth(folder: str | os.PathLike[str]) -> tuple[dict[str, Any], dict[str, dict[str, FloatArray]]]:
    """Read the truth of a campaign: (law and rig, arrays by test). For checks of the laboratory only.

    Raises
    ------
    InputError
        The folder holds no truth.
    """
    path = Path(folder)
    if not (path / TRUTH_JSON).is_file() or not (path / TRUTH_NPZ).is_file():
        raise InputError(
            f"{path}: no {TRUTH_JSON} and {TRUTH_NPZ}; allowed: a folder the virtual laboratory wrote"
        )
    content = json.loads((path / TRUTH_JSON).read_text(encoding="utf-8"))
    tests: dict[str, dict[str, FloatArray]] = {}
    with np.load(path / TRUTH_NPZ, allow_pickle=False) as stored:
        for key in stored.files:
            test_id, _, name = key.partition("/")
            tests.setdefault(test_id, {})[name] = stored[key]
    return content, tests


def _shape(row: dict[Any, Any]) -> float:
    tip = row["tip"]
    return 0.0 if tip is None or np.isnan(tip) else float(tip)


def _test_to_files(
    row: dict[str, Any],
    law: dict[str, Any],
    table: SpecimenTable,
    rig: Rig,
    instruments: Instruments,
    seed: int,
    folder: str,
) -> None:
    """Carry out one test in a pool; its truth, written last, says that it is finished."""
    test = run_test(row, TrueLaw.from_dict(law), table, rig, instruments, seed)
    test_id = test.record.test_id
    test.record.save(Path(folder) / "raw" / f"{test_id}.csv")
    content = {**test.truth, **{f"scatter/{name}": np.array(value) for name, value in test.scatter.items()}}
    with atomic_path(Path(folder) / "truth" / f"{test_id}.npz") as temporary, temporary.open("wb") as stream:
        np.savez(stream, **content)  # type: ignore[arg-type]
