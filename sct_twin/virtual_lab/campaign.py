"""A synthetic campaign of sliding compression tests: raw records, and the truth in separate files."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import cast

import numpy as np
import pandas as pd

from friction_models.common import InputError, atomic_folder, atomic_path, check_folder, write_text
from friction_models.common.cached_results import fingerprint
from friction_models.common.folders import CAMPAIGN, UNFINISHED
from friction_models.common.locks import locked
from friction_models.common.processes.pool import Progress, map_unordered

from ..ingest.raw_campaign import RawCampaign, write_tables
from .experiment import Specimen, contact_reading, run_test
from .hidden_effects import FORCE_ZERO, HIDDEN, hidden_names, with_offset
from .law import TrueLaw, write_truth
from .lubricants import lubricant_named
from .plans import UNITS, PlanRow, make_plan, parse_plan, read_plan
from .rig.drive import RATE
from .rig.file_formats import file_format as file_format_named
from .rig.instruments import Faults, Instruments
from .rig.specimen import DIAMETER, HEIGHT, Rig, SpecimenTable, perturbations
from .specimen_runs import solver_fingerprint, specimen_tables


@dataclass(eq=False)
class Campaign:
    """A virtual campaign of sliding compression tests, computed from a known friction law.

    Parameters
    ----------
    plan : str, path-like or DataFrame
        ``family-count[+heldout]``: ``factorial-81+30``, ``reduced-27+10``, ``tiny-6+3``; or your own rows
        (a table or the path of a ``.csv``), see `plans.complete_plan`.
    hidden : str or sequence of str, optional
        Hidden effects by name (``"stribeck"``, ``"stribeck+wear_out"``), among them ``force_zero``, an offset of the
        friction cell; None: the base law alone.
    seed : int
        Seed of everything that is random.
    rig, instruments : Rig, Instruments, optional
        The laboratory's reality and its sensors; plain ones by default, realistic ones with a lubricant.
    cache : path-like, optional
        Folder in which upsetting runs are kept; the user's cache folder by default.
    lubricant : str, optional
        One of `lubricants.LUBRICANTS`; None: a law that is linear in the five loads.
    repeats : int
        How often every training test of a named plan is run.
    faults : Faults, optional
        What goes wrong in the tests.
    law : TrueLaw, optional
        Law of another campaign; drawn from the seed by default.

    Raises
    ------
    InputError
        Unknown plan, lubricant or hidden effect, rows that cannot be tested, or a seed that is not a whole
        number from 0 on.

    Examples
    --------
    The plan and the law of a campaign are there before any test is run:

    >>> from sct_twin.virtual_lab import Campaign
    >>> campaign = Campaign("tiny-6+3", hidden="stribeck", seed=1)
    >>> len(campaign.tests), bool(campaign.tests["synthetic"].all())
    (9, True)
    >>> [effect.name for effect, _ in campaign.true_law.hidden]
    ['stribeck']
    """

    plan: str | os.PathLike[str] | pd.DataFrame = "reduced-27+10"
    hidden: str | Sequence[str] | None = None
    seed: int = 0
    rig: Rig | None = None
    instruments: Instruments | None = None
    cache: str | os.PathLike[str] | None = None
    lubricant: str | None = None
    repeats: int = 1
    faults: Faults | None = None
    law: TrueLaw | None = None
    #: What the campaign really is: its law, the laboratory, its sensors, and the faults with a hidden offset.
    true_law: TrueLaw = field(init=False, repr=False)
    true_rig: Rig = field(init=False, repr=False)
    sensors: Instruments = field(init=False, repr=False)
    true_faults: Faults | None = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if isinstance(self.seed, bool) or not isinstance(self.seed, int | np.integer) or self.seed < 0:
            raise InputError(f"campaign: seed {self.seed!r}; allowed: a whole number from 0 on")
        if isinstance(self.repeats, bool) or not (isinstance(self.repeats, int) and 1 <= self.repeats <= 50):
            raise InputError(f"campaign: repeats = {self.repeats!r}; allowed: 1 to 50")
        plain = self.lubricant is None
        usual = Rig()
        if self.lubricant is not None:
            usual = replace(Rig.realistic(), upsetting_mu=lubricant_named(self.lubricant).upsetting_mu)
        self.true_rig = self.rig or usual
        self.sensors = self.instruments or (Instruments() if plain else Instruments.realistic())
        names = hidden_names(self.hidden, (*HIDDEN, FORCE_ZERO))
        effects = [name for name in names if name != FORCE_ZERO]
        self.true_law = self.law or TrueLaw.draw(effects, int(self.seed), self.lubricant)
        offset = FORCE_ZERO in names
        self.true_faults = with_offset(self.faults, int(self.seed)) if offset else self.faults
        self._tests = self._table()

    @property
    def tests(self) -> pd.DataFrame:
        """Return the test table."""
        return self._tests.copy()

    def _table(self) -> pd.DataFrame:
        seed = int(self.seed)
        if isinstance(self.plan, str) and not self.plan.lower().endswith(".csv"):
            table = make_plan(self.plan, seed, self.repeats)
        elif self.repeats > 1:
            raise InputError("campaign: repeats belong to a named plan; allowed: a row a test in one's own")
        else:
            table = read_plan(self.plan, seed)
        if self.lubricant is not None:
            table["lubricant"] = self.lubricant
        if self.true_rig.scattered or self.sensors.caliper > 0.0:
            drawn = [Specimen.draw(str(t), self.true_rig, self.sensors, seed) for t in table["test_id"]]
            table["specimen_diameter"] = [specimen.diameter_measured for specimen in drawn]
            table["specimen_height"] = [specimen.height_measured for specimen in drawn]
        return table

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
        self.write(target, jobs=jobs, progress=progress)
        campaign = RawCampaign.load(target)
        campaign._temporary = temporary
        return campaign

    def write(
        self,
        out: str | os.PathLike[str],
        file_format: str = "canonical",
        jobs: int | None = None,
        progress: Progress | None = None,
    ) -> Path:
        """Carry out all tests and write their files as the logger of a rig would.

        Parameters
        ----------
        out : path-like
            Folder to write, atomically: ``raw/`` with a file a test, ``tests.csv``, ``campaign.json``, the truth,
            and ``channels.yaml`` for `ingest` unless the format is ``canonical``.
        file_format : str
            One of `file_formats.FORMATS`.
        jobs, progress
            See `run`.

        Returns
        -------
        Path
            The folder.

        Raises
        ------
        InputError
            Unknown format, or `out` holds something else than a campaign.
        """
        kind = file_format_named(file_format)
        target = Path(out)
        check_folder(target, CAMPAIGN)
        tests = self.tests
        rows = cast("list[PlanRow]", tests.to_dict("records"))
        report = progress or (lambda done, of, what: None)
        # Finished tests wait in a folder beside the target, so that an interrupted run goes on.
        waiting = check_folder(target.parent / f".{target.name}.partial", UNFINISHED)
        waiting.mkdir(parents=True, exist_ok=True)
        busy = f"{target}: another run makes a campaign here; wait for it, or use another folder"
        with locked(waiting / ".lock", busy):
            self._prepare(waiting, kind.name)
            known = {
                row["test_id"] for row in rows if (waiting / "truth" / f"{row['test_id']}.npz").is_file()
            }
            shapes = {_shape(row): float(row["bore"]) for row in rows}
            tables = specimen_tables(
                shapes,
                self.true_rig,
                None if self.cache is None else str(self.cache),
                jobs,
                lambda done, of: report(0, len(rows), f"virtual upsetting {done} of {of}"),
            )
            if known:
                report(len(known), len(rows), f"{len(known)} tests known")
            open_rows = [row for row in rows if row["test_id"] not in known]
            items = [(self, row, tables[_shape(row)], kind.name, waiting) for row in open_rows]
            for done, (index, _) in enumerate(map_unordered(_test_to_files, items, jobs)):
                test_id = open_rows[index]["test_id"]
                report(len(known) + done + 1, len(rows), f"virtual test {test_id}")
            with atomic_folder(target, CAMPAIGN) as folder:
                (waiting / "raw").rename(folder / "raw")
                ids = [row["test_id"] for row in rows]
                truth = {
                    "law": self.true_law.to_dict(),
                    "rig": asdict(self.true_rig),
                    "instruments": asdict(self.sensors),
                    "faults": None if self.true_faults is None else asdict(self.true_faults),
                }
                scatter = write_truth(waiting / "truth", folder, ids, truth)
                write_tables(folder, self._measured_after(tests, scatter), self._info(kind.name))
                if kind.name != "canonical":
                    write_text(folder / "channels.yaml", kind.channel_map(self.sensors.moving_mass))
            shutil.rmtree(waiting, ignore_errors=True)
        return target

    def _measured_after(
        self, tests: pd.DataFrame, scatter: Mapping[str, Mapping[str, float]]
    ) -> pd.DataFrame:
        """Return the test table with the contact diameters that are measured after the tests."""
        if self.sensors.contact_reading == 0.0:
            return tests.drop(columns="contact_diameter", errors="ignore")
        true = [(str(t), scatter[str(t)]["contact_diameter"]) for t in tests["test_id"]]
        read = [contact_reading(d, name, self.sensors, int(self.seed)) for name, d in true]
        return tests.assign(contact_diameter=read)

    def _prepare(self, waiting: Path, kind: str) -> None:
        """Empty the folder of finished tests if they belong to another campaign."""
        key = fingerprint(
            self._tests.to_csv(),
            self.true_law.to_dict(),
            int(self.seed),
            self.true_rig,
            self.sensors,
            self.true_faults,
            kind,
            solver_fingerprint(),
        )
        mark = waiting / "key"
        whole = mark.is_file() and (waiting / "raw").is_dir() and (waiting / "truth").is_dir()
        if not whole or mark.read_text(encoding="utf-8") != key:
            for name in ("raw", "truth"):
                shutil.rmtree(waiting / name, ignore_errors=True)
                (waiting / name).mkdir()
            write_text(mark, key)

    def _info(self, kind: str) -> dict[str, object]:
        """Return what stands in `campaign.json`; `kind` is the format of the files."""
        if isinstance(self.plan, str) and not self.plan.lower().endswith(".csv"):
            family, held_out = parse_plan(self.plan)
            name, meaning = self.plan, family.meaning
        else:
            name = "rows of a table" if isinstance(self.plan, pd.DataFrame) else Path(self.plan).name
            meaning, held_out = "rows given by the user", int((self._tests["role"] == "test").sum())
        return {
            "synthetic": True,
            "notice": "synthetic: made by the virtual laboratory, not measured",
            "plan": name,
            "plan_meaning": meaning,
            "held_out": held_out,
            "seed": int(self.seed),
            **({} if self.lubricant is None else {"lubricant": f"{self.lubricant} (virtual)"}),
            **({} if self.repeats == 1 else {"repeats": self.repeats}),
            "files": kind,
            "reality": perturbations(self.true_rig, self.sensors),
            "moving_mass_kg": self.sensors.moving_mass,
            "sampling_rate_Hz": RATE,
            "specimen": {"diameter_mm": DIAMETER, "height_mm": HEIGHT, "material": "16MnCr5"},
            "plate": {"material": "1.2379"},
            "units": UNITS,
        }


def _shape(row: PlanRow) -> float:
    tip = row["tip"]
    return 0.0 if tip is None or np.isnan(tip) else float(tip)


def _test_to_files(campaign: Campaign, row: PlanRow, table: SpecimenTable, kind: str, folder: Path) -> None:
    """Carry out one test in a pool; its truth, written last, says that it is finished."""
    law, rig, sensors, faults = campaign.true_law, campaign.true_rig, campaign.sensors, campaign.true_faults
    test = run_test(row, law, table, rig, sensors, int(campaign.seed), faults)
    test_id, form = row["test_id"], file_format_named(kind)
    with atomic_path(folder / "raw" / f"{test_id}{form.suffix}") as temporary:
        form.save(temporary, test.frame)
    content = {**test.truth, **{f"scatter/{name}": np.array(value) for name, value in test.scatter.items()}}
    with atomic_path(folder / "truth" / f"{test_id}.npz") as temporary, temporary.open("wb") as stream:
        np.savez(stream, **content)  # type: ignore[arg-type]
