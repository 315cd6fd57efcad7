"""Test plans: which setpoints a campaign visits, and which tests are held out."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any, TypedDict

import numpy as np
import pandas as pd

from friction_models.common import InputError, check_readable, unknown_name
from friction_models.loads import missing_column
from friction_models.loads.table import read_table

from ..ingest.raw_campaign import check_test_id
from ..records.cells import is_given
from .protocols import number, numbers, schedule

SIGMA_LEVELS = (500.0, 1750.0, 2750.0)
PSI_LEVELS = (1.069, 5.0, 20.0)
SPEED_LEVELS = (5.0, 200.0, 500.0)
TOOL_LEVELS = (20.0, 100.0, 300.0)

#: Bore of the punch's cavity [mm] by area ratio (largest contact over first contact). A wider bore lets
#: the 15 mm specimen spread further, so that the local expansion grows too: its contact mean is about
#: 1.05, 1.3, 1.5 and 1.7. The real rig's punches are not published.
BORES = {1.069: 15.51, 5.0: 20.0, 10.0: 22.5, 20.0: 25.0}
#: Area ratios between the levels that held-out tests visit besides the levels.
PSI_BETWEEN = (10.0,)


class PlanRow(TypedDict):
    """A row of a test table, as far as a virtual test needs it; units in `UNITS`, more in `protocols`."""

    test_id: str
    batch: str
    sigma_set: float
    v_set: float
    T_tool: float
    Ra: float
    t_wait: float
    sd_set: float
    bore: float
    tip: float | None
    F_set: float


@dataclass(frozen=True)
class PlanFamily:
    """A kind of plan: how many training tests, how far they slide."""

    name: str
    count: int
    sliding: float
    meaning: str


FAMILIES: dict[str, PlanFamily] = {
    plan.name: plan
    for plan in (
        PlanFamily(
            "factorial", 81, 56.0, "full factorial 3^4 of pressure, expansion, speed, tool temperature"
        ),
        PlanFamily("reduced", 27, 56.0, "a third of the factorial, main effects free of each other (L27)"),
        PlanFamily("tiny", 6, 12.0, "six short tests, for quick checks only"),
    )
}
PLAN_NAMES = ("factorial-81+30", "reduced-27+10", "tiny-6+3")
#: Units of the columns of the test table.
UNITS = {
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
    "specimen_diameter": "mm",
    "specimen_height": "mm",
    "contact_diameter": "mm",
    "sigma_end": "MPa",
    "sigma_levels": "MPa",
    "v_levels": "mm/s",
    "hold_at": "mm",
    "hold": "s",
    "zero_reading": "s",
}
#: Most tests of a plan that the user gives.
MOST_TESTS = 2000
_MAX_BYTES = 4_000_000


def parse_plan(name: str) -> tuple[PlanFamily, int]:
    """Return the family and the number of held-out tests of ``family-count[+heldout]``.

    Raises InputError: not such a name.

    >>> family, held_out = parse_plan("factorial-81+30")
    >>> family.count, held_out
    (81, 30)
    """
    match = re.fullmatch(r"([a-z]+)(?:-(\d+))?(?:\+(\d+))?", str(name))
    if match is None or match[1] not in FAMILIES:
        raise unknown_name("plan", name, PLAN_NAMES)
    family = FAMILIES[match[1]]
    if match[2] is not None and int(match[2]) != family.count:
        raise InputError(
            f"plan {name!r}: {family.name} has {family.count} tests; allowed: {family.name}-{family.count}"
        )
    held_out = int(match[3] or 0)
    if held_out > 300:
        raise InputError(f"plan {name!r}: {held_out} held-out tests; allowed: 0 to 300")
    return family, held_out


def tip_diameter(psi_set: float) -> float | None:
    """Return the diameter of the reduced first contact [mm]; None where the whole end face touches.

    The contact grows fivefold, from 8.9 mm to the bore of 20 mm:

    >>> tip_diameter(5.0)
    8.9443
    >>> tip_diameter(1.069) is None
    True
    """
    return None if psi_set < 1.5 else round(BORES[psi_set] / float(np.sqrt(psi_set)), 4)


def make_plan(name: str, seed: int, repeats: int = 1) -> pd.DataFrame:
    """Return the test table of a plan: setpoints, role, run order, batch, tool, waiting time.

    Training tests are run `repeats` times; column `repeat` counts them where there are several.

    Held-out tests lie at random points inside the plan (area ratio: one of the specimen shapes). The
    normal force is the set pressure times the area of the bore, so that a specimen that does not fill
    it is pressed harder than the set value: the loads come from the twin, set values are metadata.

    >>> plan = make_plan("tiny-6+3", seed=0)
    >>> len(plan), plan["role"].tolist().count("test")
    (9, 3)
    >>> plan["sigma_set"].head(3).tolist()
    [500.0, 1750.0, 2750.0]
    """
    family, held_out = parse_plan(name)
    rng = np.random.default_rng([seed, 7002])
    if family.name == "factorial":
        points = list(product(SIGMA_LEVELS, PSI_LEVELS, SPEED_LEVELS, TOOL_LEVELS))
    elif family.name == "reduced":
        points = [
            (SIGMA_LEVELS[a], PSI_LEVELS[b], SPEED_LEVELS[c], TOOL_LEVELS[(a + b + c) % 3])
            for a, b, c in product(range(3), repeat=3)
        ]
    else:
        speeds = (50.0, 200.0, 500.0)
        points = [
            (SIGMA_LEVELS[k % 3], PSI_LEVELS[k % 2], speeds[(k // 2) % 3], TOOL_LEVELS[(k * 2) % 3])
            for k in range(6)
        ]
    rows = [(*point, "train") for point in points for _ in range(repeats)]
    slowest = np.log(50.0 if family.name == "tiny" else SPEED_LEVELS[0])
    shapes = PSI_LEVELS[:2] if family.name == "tiny" else (*PSI_LEVELS, *PSI_BETWEEN)
    for _ in range(held_out):
        sigma, psi = float(rng.uniform(SIGMA_LEVELS[0], SIGMA_LEVELS[-1])), float(rng.choice(shapes))
        # Half evenly, half evenly in the logarithm: slow tests matter as much as fast ones.
        if rng.random() < 0.5:
            speed = np.exp(rng.uniform(slowest, np.log(SPEED_LEVELS[-1])))
        else:
            speed = rng.uniform(np.exp(slowest), SPEED_LEVELS[-1])
        T_tool = float(rng.uniform(TOOL_LEVELS[0], TOOL_LEVELS[-1]))
        rows.append((round(sigma, 1), psi, round(float(speed), 2), round(T_tool, 1), "test"))
    table = pd.DataFrame(rows, columns=["sigma_set", "psi_set", "v_set", "T_tool", "role"])
    count = len(table)
    table.insert(0, "test_id", [f"sct{k + 1:03d}" for k in range(count)])
    table["order"] = rng.permutation(count) + 1
    table["batch"] = np.where(rng.permutation(count) < count // 2, "A", "B")
    tools = rng.integers(1, 4, count)
    table["tool_id"] = [f"plate{k}" for k in tools]
    roughness = np.round(rng.uniform(0.008, 0.03, 3), 4)
    table["Ra"] = roughness[tools - 1]
    table["t_wait"] = np.round(rng.uniform(0.3, 0.8, count), 3)
    table["T_specimen"] = table["T_tool"]
    table["sd_set"] = family.sliding
    table["bore"] = [BORES[psi] for psi in table["psi_set"]]
    table["tip"] = [tip_diameter(psi) for psi in table["psi_set"]]
    table["F_set"] = np.round(table["sigma_set"] * np.pi / 4.0 * table["bore"] ** 2, 0)
    table["synthetic"] = True
    if repeats > 1:
        table["repeat"] = [k % repeats + 1 if k < len(points) * repeats else 1 for k in range(count)]
    return table


def read_plan(source: pd.DataFrame | str | os.PathLike[str], seed: int) -> pd.DataFrame:
    """Return the test table of a plan that the user gives, as a table or a CSV file; see `complete_plan`.

    Raises InputError: no such file, not a table, too many rows, or what `complete_plan` refuses.
    """
    if isinstance(source, pd.DataFrame):
        return complete_plan(source, seed, "plan")
    path = Path(source)
    check_readable(path, _MAX_BYTES, "a CSV file with a plan")
    return complete_plan(read_table(path), seed, str(path))


def complete_plan(rows: pd.DataFrame, seed: int, where: str) -> pd.DataFrame:
    """Check the rows of a plan and fill in missing settings.

    Raises InputError: a column or value is missing or outside its limits; names the row, counted from 0.

    - `rows`: `sigma_set` [MPa], `v_set` [mm/s], `T_tool` [degC]; optional `psi_set` (one of `BORES`),
      `sd_set` [mm], `protocol` with its parameters (`protocols.PROTOCOLS`), and any other column of a test
      table.
    - `seed`: of order, batch, tool and waiting time where they are not given.

    >>> rows = pd.DataFrame({"sigma_set": [1000.0], "v_set": [50.0], "T_tool": [100.0]})
    >>> plan = complete_plan(rows, seed=0, where="plan")
    >>> plan[["test_id", "T_specimen", "sd_set"]].values.tolist()
    [['sct001', 100.0, 56.0]]
    """
    if not 1 <= len(rows) <= MOST_TESTS:
        raise InputError(f"{where}: {len(rows)} rows; allowed: 1 to {MOST_TESTS}")
    for name in ("sigma_set", "v_set", "T_tool"):
        if name not in rows.columns:
            raise missing_column(name, rows.columns, where)
    rng = np.random.default_rng([seed, 7012])
    count = len(rows)
    order, halves = rng.permutation(count) + 1, rng.permutation(count) < count // 2
    tools, waits = rng.integers(1, 4, count), np.round(rng.uniform(0.3, 0.8, count), 3)
    roughness = np.round(rng.uniform(0.008, 0.03, 3), 4)
    filled = []
    for k, row in enumerate(rows.to_dict("records")):
        here = f"{where}: row {k}"
        given = {str(name): value for name, value in row.items() if is_given(value)}
        if "v_set" not in given and "v_levels" in given:
            given["v_set"] = numbers(given, "v_levels", here)[0]
        full = {
            "test_id": f"sct{k + 1:03d}",
            "psi_set": PSI_LEVELS[0],
            "role": "train",
            "order": int(order[k]),
            "batch": "A" if halves[k] else "B",
            "tool_id": f"plate{tools[k]}",
            "Ra": float(roughness[tools[k] - 1]),
            "t_wait": float(waits[k]),
            "T_specimen": given.get("T_tool"),
            "sd_set": FAMILIES["factorial"].sliding,
            **given,
        }
        full["test_id"] = check_test_id(str(full["test_id"]), here)
        for name in ("sigma_set", "v_set", "T_tool", "T_specimen", "sd_set", "t_wait", "Ra"):
            full[name] = number(full, name, here)
        full["psi_set"] = _shape_named(full["psi_set"], here)
        full["bore"], full["tip"] = BORES[full["psi_set"]], tip_diameter(full["psi_set"])
        full["F_set"] = round(full["sigma_set"] * np.pi / 4.0 * full["bore"] ** 2, 0)
        schedule(full, here)
        filled.append({**full, "synthetic": True})
    table = pd.DataFrame(filled)
    twice = table["test_id"][table["test_id"].duplicated()]
    if len(twice):
        raise InputError(f"{where}: test_id {twice.iloc[0]!r} stands in two rows; allowed: one row a test")
    return table


def _shape_named(value: Any, where: str) -> float:
    try:
        psi = float(value)
    except (TypeError, ValueError):
        psi = float("nan")
    if psi not in BORES:
        shapes = ", ".join(f"{known:g}" for known in BORES)
        raise InputError(f"{where}: psi_set = {value!r}; allowed: a specimen shape of the rig: {shapes}")
    return psi
