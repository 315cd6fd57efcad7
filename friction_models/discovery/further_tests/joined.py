"""Joins several campaigns with one lubricant: the first tests and the further ones that they called for."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from ...common import InputError
from ...loads import LOADS, DataSet
from ...loads.contract import ORDER
from ...loads.dataset import roles_of
from ...loads.run_order import with_places


def join_campaigns(campaigns: Mapping[str, DataSet]) -> tuple[DataSet, list[str]]:
    """Return the tests of several campaigns with one lubricant as one data set, and a sentence for each thing that was changed.

    The campaigns stand by name in the order in which they were run. A test whose name is taken is renamed to ``CAMPAIGN TEST``.
    Tests without a role are for training. The run order continues from campaign to campaign; of a later one
    that has none the tests follow as they stand. Points keep the columns that all
    campaigns have; missing cells of the test table stay empty.
    Raises InputError: no campaign, or a load that some campaigns hold and others lack.
    """
    if not campaigns:
        raise InputError("campaigns: none was given; allowed: at least one")
    _check_columns(campaigns)
    remarks: list[str] = []
    taken: set[str] = set()
    points, tables, last = [], [], 0.0
    for name, data in campaigns.items():
        own = data.points.assign(test_id=data.points["test_id"].astype(str))
        own.attrs.clear()
        names = _free_names(name, list(dict.fromkeys(own["test_id"])), taken)
        renamed = {old: new for old, new in names.items() if old != new}
        if renamed:
            old, new = next(iter(renamed.items()))
            shown = f"{old!r} is called {new!r}" + (
                f", {len(renamed) - 1} more alike" if len(renamed) > 1 else ""
            )
            remarks.append(f"{name}: test names that are taken: {shown}")
        taken |= set(names.values())
        points.append(own.assign(test_id=own["test_id"].map(names)))
        table, last = _continued(data.tests, names, last)
        tables.append(table)
    columns = [{str(c) for c in p.columns} for p in points]
    lost = sorted(set().union(*columns) - columns[0].intersection(*columns))
    if "t" in lost:
        remarks.append(
            "not all campaigns have the time t: it is left out, effects of memory take it from speed"
        )
    joined = pd.concat([p.drop(columns=lost, errors="ignore") for p in points], ignore_index=True)
    tests = pd.concat(tables, ignore_index=True)
    if any(d.tests is not None and "role" in d.tests.columns for d in campaigns.values()):
        tests["role"] = roles_of(tests["role"])
    labels = {d.synthetic for d in campaigns.values()}
    if len(labels) > 1:
        remarks.append("synthetic and measured campaigns together: all of it counts as synthetic")
    info: dict[str, object] = {"synthetic": any(labels), "campaigns": list(campaigns)}
    return DataSet(joined, tests, info), remarks


def _check_columns(campaigns: Mapping[str, DataSet]) -> None:
    known = {name: set(data.points.columns) for name, data in campaigns.items()}
    for quantity in LOADS:
        lacking = [name for name, columns in known.items() if quantity.name not in columns]
        if lacking and len(lacking) < len(known):
            having = next(name for name in known if name not in lacking)
            raise InputError(
                f"{lacking[0]}: column {quantity.name!r} [{quantity.unit}] is missing, {having} has it; "
                "allowed: the same loads in all campaigns"
            )


def _free_names(campaign: str, tests: list[str], taken: set[str]) -> dict[str, str]:
    """Return a unique name for each test."""
    names: dict[str, str] = {}
    used = taken | set(tests)
    for test in tests:
        new, count = test, 1
        while new in taken or (new != test and new in used):
            new = f"{campaign} {test}" + (f" ({count})" if count > 1 else "")
            count += 1
        used.add(new)
        names[test] = new
    return names


def _continued(
    tests: pd.DataFrame | None, names: Mapping[str, str], last: float
) -> tuple[pd.DataFrame, float]:
    """Return the test table under the new names with the run order after `last`, and the last place in it."""
    if tests is None:
        table = pd.DataFrame({"test_id": list(names.values())})
    else:
        table = tests.assign(test_id=tests["test_id"].astype(str))
        table = table[table["test_id"].isin(names)].reset_index(drop=True)
        table["test_id"] = table["test_id"].map(names)
        table = with_places(table)
    if ORDER not in table.columns and last > 0.0:
        table[ORDER] = np.arange(1.0, len(table) + 1.0)  # as they stand, after all before
    if ORDER in table.columns:
        order = pd.to_numeric(table[ORDER], errors="coerce")
        if order.notna().any():
            table[ORDER] = order + last
            last = float(table[ORDER].max())
    return table, last
