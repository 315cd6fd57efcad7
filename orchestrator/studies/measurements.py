"""Measurements of a study: a data set of whole tests for each lubricant, from the virtual laboratory or the user.

Each lubricant ends in one job ``data-LUBRICANT``. Its folder holds the time series (``dataset``) and the
average-based data set (``dataset/averages``), both with the roles ``train`` and ``test``.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict

from friction_models.common import InputError, unknown_name

from ..jobs.graph import Job, JobResult
from ..jobs.job import Files, Inputs, Needs
from .models import data_files, load_data

if TYPE_CHECKING:
    from friction_models.loads import DataSet

#: The lubricants of the virtual laboratory that the studies compare.
VIRTUAL = ("polymer", "mos2")
#: Plan at full size, as the paper's, and in the quick size.
FULL_PLAN, QUICK_PLAN = "factorial-81+30", "reduced-27+10"
#: Tests a job of the laboratory: short enough that a killed one loses little.
TESTS_A_JOB = 14
#: CPU time of one virtual test and its twin [s], and of starting [s]; for estimates.
TEST_SECONDS, START_SECONDS = 1.2, 6.0
#: CPU time of the upsetting runs of one specimen shape [s], where they are not known yet.
SPECIMEN_SECONDS = 12.0
#: Share of the tests held out, as 30 of 111, where a user's table of tests has no roles.
HELD_OUT = 30 / 111
#: Fewest tests of one's own: something to train on and something to judge by.
FEWEST_TESTS = 4
DATASET = "dataset"


def data_name(lubricant: str) -> str:
    """Return the name of the job that gives the data sets of a lubricant."""
    return f"data-{lubricant}"


def data_jobs(
    data: Mapping[str, Path] | None = None,
    lubricants: Sequence[str] = VIRTUAL,
    plan: str = FULL_PLAN,
    seed: int = 0,
) -> dict[str, list[Job]]:
    """Return the jobs of each lubricant; the last one of each is called ``data-LUBRICANT``.

    `data` are one's own data sets by lubricant; without them the virtual laboratory measures, to which the rest
    applies.
    """
    if data:
        return {lubricant: [_own_data_job(lubricant, place, seed)] for lubricant, place in data.items()}
    return {lubricant: measurement_jobs(lubricant, plan, seed) for lubricant in lubricants}


def chosen_data(texts: Iterable[str] | None) -> dict[str, Path] | None:
    """Read what ``--data`` names: ``LUBRICANT=PLACE`` texts, or a single place; None for nothing.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     list(chosen_data([f"oil={place}"]))
    ['oil']
    >>> chosen_data(None) is None
    True
    """
    chosen: dict[str, Path] = {}
    for text in texts or ():
        name, equals, place = text.partition("=")
        path = Path(place if equals else text)
        lubricant = name if equals else path.resolve().stem
        if not re.fullmatch(r"[\w.+-]{1,60}", lubricant):
            raise InputError(f"--data {text!r}: allowed: a folder, or LUBRICANT=FOLDER with a plain name")
        if lubricant in chosen:
            raise InputError(f"--data: {lubricant!r} stands twice; allowed: each lubricant once")
        if not path.exists():
            raise InputError(f"--data {text!r}: no such folder or file {path}")
        chosen[lubricant] = path
    return chosen or None


def measurement_jobs(lubricant: str, plan: str = FULL_PLAN, seed: int = 0) -> list[Job]:
    """Return the jobs that measure a lubricant in the virtual laboratory and run the twin."""
    from sct_twin.virtual_lab import LUBRICANTS
    from sct_twin.virtual_lab.plans import make_plan

    if lubricant not in LUBRICANTS:
        raise unknown_name("lubricant", lubricant, LUBRICANTS)
    table = make_plan(plan, seed)
    count = len(table)
    parts = -(-count // TESTS_A_JOB)
    # Without the lubricant among the inputs: the lubricants share these jobs.
    shapes = [
        Job(f"specimens-{lubricant}-{psi:g}", f"{__name__}:upset", {"psi_set": psi}, seconds=SPECIMEN_SECONDS)
        for psi in sorted({float(psi) for psi in table["psi_set"]})
    ]
    ready = tuple(job.name for job in shapes)
    jobs = [
        Job(
            f"tests-{lubricant}-{part + 1}",
            f"{__name__}:measure",
            {"lubricant": lubricant, "plan": plan, "seed": seed, "part": part, "parts": parts},
            needs=ready,
            seconds=START_SECONDS + TEST_SECONDS * count / parts,
        )
        for part in range(parts)
    ]
    names = tuple(job.name for job in jobs)
    gather = Job(
        data_name(lubricant), f"{__name__}:gather", {"lubricant": lubricant}, needs=names, seconds=3.0
    )
    return [*shapes, *jobs, gather]


def _own_data_job(lubricant: str, place: Path, seed: int) -> Job:
    read_own(place, seed)  # what cannot be used is refused at once
    inputs = {"lubricant": lubricant, "seed": seed}
    return Job(data_name(lubricant), f"{__name__}:take", inputs, data_files(place))


def read_own(place: Path, seed: int = 0) -> DataSet:
    """Return a user's data set with the roles of its tests; one that has too few of them is refused."""
    return _with_roles(load_data(data_files(place), {}), seed, str(place))


def load_measurements(result: JobResult, averages: bool = False) -> DataSet:
    """Return the time series, or the average-based data set, of a job ``data-LUBRICANT``."""
    from friction_models.loads import DataSet

    return DataSet.load(result.file("averages" if averages else "dataset"))


class MeasuredData(TypedDict):
    """Result of a job ``data-LUBRICANT``."""

    dataset: str  # folder in it
    averages: str  # folder in it
    lubricant: str
    train: int  # number of tests
    held_out: int  # number of tests
    points: int
    synthetic: bool
    plan: str | None
    roles: str


# --- the functions of the jobs ------------------------------------------------------------------------


def upset(inputs: Inputs, files: Files, needs: Needs, folder: Path) -> dict[str, object]:
    """Compute the upsetting runs of one specimen shape into the user's cache, where the laboratory finds them.

    Only a matter of time: a laboratory that does not find them computes them itself.
    """
    from sct_twin.virtual_lab import Rig
    from sct_twin.virtual_lab.plans import BORES, tip_diameter
    from sct_twin.virtual_lab.specimen_runs import specimen_tables

    psi = float(inputs["psi_set"])
    specimen_tables({tip_diameter(psi) or 0.0: BORES[psi]}, Rig.realistic(), None, 1, lambda done, of: None)
    return {"psi_set": psi}


def measure(inputs: Inputs, files: Files, needs: Needs, folder: Path) -> dict[str, object]:
    """Carry out a part of the plan in the virtual laboratory and evaluate it by the twin.

    A test depends on the seed and its own row of the plan only, so the parts are those of the whole campaign.
    """
    from sct_twin import SctTwin
    from sct_twin.twin.campaign_result import save_dataset
    from sct_twin.virtual_lab import Campaign
    from sct_twin.virtual_lab.plans import make_plan

    plan = make_plan(inputs["plan"], inputs["seed"])
    rows = plan.iloc[inputs["part"] :: inputs["parts"]].reset_index(drop=True)
    with tempfile.TemporaryDirectory(prefix="tribofmu-study-") as temporary:
        campaign = Campaign(plan=rows, seed=inputs["seed"], lubricant=inputs["lubricant"])
        campaign.write(Path(temporary) / "campaign", jobs=1)
        result = SctTwin().run(Path(temporary) / "campaign", jobs=1)
    result.info["plan"] = inputs["plan"]
    save_dataset(result.dataset(), folder / DATASET)
    return {
        "dataset": DATASET,
        "tests": len(result.tests),
        "left_out": result.left_out.to_dict("records"),
    }


def gather(inputs: Inputs, files: Files, needs: Needs, folder: Path) -> MeasuredData:
    """Put the parts together in the order of the tests' names."""
    import pandas as pd

    from friction_models.loads import DataSet

    parts = [DataSet.load(part.folder / DATASET) for part in needs.values()]
    tests = pd.concat([part.tests for part in parts], ignore_index=True).sort_values("test_id")
    points = pd.concat([part.points for part in parts], ignore_index=True)
    points = points.sort_values("test_id", kind="stable").reset_index(drop=True)
    left_out = [entry for part in needs.values() for entry in part.values["left_out"]]
    info = {**parts[0].info, "left_out": sorted(left_out, key=lambda entry: str(entry["test_id"]))}
    info["lubricant"] = f"{inputs['lubricant']} (virtual)"
    whole = DataSet(points, tests.reset_index(drop=True), info)
    return _write(whole, str(inputs["lubricant"]), folder)


def take(inputs: Inputs, files: Files, needs: Needs, folder: Path) -> MeasuredData:
    """Take the user's data set, with roles."""
    data = _with_roles(load_data(files, needs), inputs["seed"], str(files["points"]))
    return _write(data, str(inputs["lubricant"]), folder)


def _with_roles(data: DataSet, seed: int, where: str) -> DataSet:
    """Return the data set with the tests' roles; where none are recorded, whole tests are held out by the seed."""
    import numpy as np
    import pandas as pd

    from friction_models.loads import DataSet, require_every_load
    from friction_models.loads.dataset import roles_of
    from friction_models.loads.splits import hold_out

    require_every_load(data.points.columns, where)
    ids = data.points["test_id"].unique()
    if len(ids) < FEWEST_TESTS:
        raise InputError(f"{where}: {len(ids)} tests; allowed: at least {FEWEST_TESTS} for a study")
    if data.tests is not None and "role" in data.tests.columns:
        tests = data.tests.assign(role=roles_of(data.tests["role"]))
        known = tests.loc[tests["test_id"].isin(ids), "role"]
        for role in ("train", "test"):
            if not (known == role).any():
                raise InputError(f"{where}: no test has the role {role!r}; allowed: tests of both roles")
        return replace(data, tests=tests)
    _, out = hold_out(ids.astype(str), len(ids), HELD_OUT, seed)
    held = ids.astype(str)[out]
    tests = pd.DataFrame({"test_id": ids}) if data.tests is None else data.tests.copy()
    tests["role"] = np.where(tests["test_id"].isin(held), "test", "train")
    return DataSet(data.points, tests, {**data.info, "held_out": f"{len(held)} tests drawn by the seed"})


def _write(data: DataSet, lubricant: str, folder: Path) -> MeasuredData:
    import pandas as pd

    from sct_twin.twin.campaign_result import AVERAGES, TwinResult

    assert data.tests is not None
    used = data.tests[data.tests["test_id"].isin(data.points["test_id"].unique())]
    result = TwinResult(data.points, used.reset_index(drop=True), data.info, pd.DataFrame())
    result.save(folder / DATASET)
    roles = used["role"].value_counts()
    return {
        "dataset": DATASET,
        "averages": f"{DATASET}/{AVERAGES}",
        "lubricant": lubricant,
        "train": int(roles.get("train", 0)),
        "held_out": int(roles.get("test", 0)),
        "points": len(data.points),
        "synthetic": data.synthetic,
        "plan": data.info.get("plan"),
        "roles": str(data.info.get("held_out", "as recorded")),
    }
