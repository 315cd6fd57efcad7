"""Errors of the twin: some tests of a campaign are evaluated again with one setting or assumption changed at a time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
import pandas as pd

from forming.materials.materials import as_material
from friction_models.common import InputError
from friction_models.common.processes.pool import Progress, map_unordered

from ..ingest.raw_campaign import RawCampaign
from .evaluation import TwinSettings, evaluate_file
from .test_result import TestResult

Twin = TypeVar("Twin", bound=TwinSettings)
#: Uncertainty of the friction while upsetting, factors on interface heat transfer and on the flow stress.
MU_CHANGE, TRANSFER_FACTOR, STRESS_FACTOR = 0.03, 2.0, 1.02
#: Quantities that are compared, in percent; temperatures relative to the rise above the tool.
QUANTITIES = ("sigma_n", "psi", "T", "T_max")


def variants(twin: Twin) -> dict[str, Twin]:
    """Return twins that differ in one thing each, by what differs."""
    heat = twin.heat
    changed = {"finer mesh and grid": twin.finer()}
    if twin.upsetting_mu is not None:
        for mu in (max(twin.upsetting_mu - MU_CHANGE, 0.0), twin.upsetting_mu + MU_CHANGE):
            changed[f"upsetting mu {mu:.3g}"] = replace(twin, upsetting_mu=mu)
        changed["upsetting mu of the first sliding"] = replace(twin, upsetting_mu=None)
    harder = as_material(twin.material).hardened(STRESS_FACTOR)
    changed[f"flow stress x {STRESS_FACTOR:g}"] = replace(twin, material=harder, thermal=heat)
    changed["contact heated evenly"] = replace(twin, uniform_pressure=not twin.uniform_pressure)
    changed["heat data of 20 degC"] = replace(twin, thermal=heat.constant())
    for factor in (1.0 / TRANSFER_FACTOR, TRANSFER_FACTOR):
        film = replace(heat, heat_transfer=heat.heat_transfer * factor)
        changed[f"interface heat transfer x {factor:g}"] = replace(twin, thermal=film)
    return changed


def check(
    twin: TwinSettings,
    campaign: RawCampaign,
    test_ids: Sequence[str],
    count: int,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> pd.DataFrame:
    """Evaluate `count` tests, evenly among `test_ids`, with each of `variants` and compare with the twin itself.

    Returns one row a test and variant: `test_id, variant`, and for each of `QUANTITIES` the change of its mean over the
    sliding [%]; temperatures in percent of the mean rise above the tool. A variant that cannot be evaluated is missing.

    Raises InputError: less than one test.
    """
    if count < 1:
        raise InputError(f"check = {count} tests; allowed: at least 1")
    chosen = [test_ids[int(k)] for k in np.unique(np.linspace(0, len(test_ids) - 1, count).round())]
    plain = replace(twin, uncertainty=None)
    twins = {"": plain, **variants(plain)}
    names = [(test_id, name) for test_id in chosen for name in twins]
    folder, mass = str(campaign.folder), campaign.moving_mass
    items = [(twins[name], folder, campaign.metadata(test_id), mass) for test_id, name in names]
    means: dict[tuple[str, str], dict[str, float]] = {}
    for done, (index, outcome) in enumerate(map_unordered(evaluate_file, items, jobs), 1):
        if isinstance(outcome, TestResult):
            means[names[index]] = {name: float(outcome.columns[name].mean()) for name in QUANTITIES}
        if progress is not None:
            progress(done, len(items), f"error of test {names[index][0]}")
    rows: list[dict[str, str | float]] = []
    for test_id, name in names:
        if name and (test_id, name) in means and (test_id, "") in means:
            told = campaign.metadata(test_id).get("T_tool")
            base, other = means[test_id, ""], means[test_id, name]
            row: dict[str, str | float] = {"test_id": test_id, "variant": name}
            for quantity in QUANTITIES:
                zero = float(told) if quantity.startswith("T") and told is not None else 0.0
                whole = base[quantity] - zero
                row[quantity] = round(100.0 * (other[quantity] - base[quantity]) / max(whole, 1e-9), 3)
            rows.append(row)
    return pd.DataFrame(rows, columns=["test_id", "variant", *QUANTITIES])


def summary(errors: pd.DataFrame) -> dict[str, dict[str, float]]:
    """Return the largest change by variant and quantity [%], with its sign."""
    found: dict[str, dict[str, float]] = {}
    for variant, rows in errors.groupby("variant", sort=False):
        found[str(variant)] = {q: float(rows[q].iloc[rows[q].abs().to_numpy().argmax()]) for q in QUANTITIES}
    return found


def table(errors: pd.DataFrame) -> str:
    """Return the summary as text for a console."""
    if errors.empty:
        return "errors of the twin: not checked"
    lines = [
        f"largest change of a test's means in {errors['test_id'].nunique()} tests [%]; "
        "temperatures: of the rise above the tool",
        f"{'changed':36s}" + "".join(f"{name:>9s}" for name in QUANTITIES),
    ]
    lines += [
        f"{name:36s}" + "".join(f"{values[q]:+9.2f}" for q in QUANTITIES)
        for name, values in summary(errors).items()
    ]
    return "\n".join(lines)
