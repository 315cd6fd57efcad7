"""Metadata of tests that a model was not trained with: what is taken in their place, in words."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Protocol

import numpy as np
import pandas as pd

from ..common import nearest, shown
from ..common.json_values import JsonObject
from ..common.wording import counted
from ..loads.contract import behind
from .variables import UNKNOWN_LABEL, SystemVariable, as_numbers

#: Labels that a sentence lists.
_LISTED = 5


class Variable(Protocol):
    """A system variable of a model, whatever file the model stands in; see `SystemVariable`."""

    @property
    def name(self) -> str: ...
    @property
    def unit(self) -> str: ...
    @property
    def start(self) -> float: ...
    @property
    def labels(self) -> Sequence[str]: ...


def metadata_remarks(
    variables: Iterable[Variable | JsonObject], tests: pd.DataFrame | None, measured: Iterable[Any]
) -> list[str]:
    """Return what to say of tests whose metadata a model does not know, one sentence a system variable.

    Parameters
    ----------
    variables : iterable of Variable
        System variables of the model; those of an ONNX file as its metadata has them.
    tests : pandas.DataFrame or None
        The table of tests, with `test_id`.
    measured : iterable
        Names of the tests that the model is evaluated at.

    Examples
    --------
    >>> from friction_models.models.variables import SystemVariable
    >>> batch = SystemVariable("batch", "1", start=0.0, min=0.0, max=1.0, labels=("lot A", "lot B"))
    >>> tests = pd.DataFrame({"test_id": ["t1", "t2"], "batch": ["lot A", "Lot-B"]})
    >>> metadata_remarks([batch], tests, ["t1", "t2"])
    ["1 of 2 tests has a batch that was not in the training: 'Lot-B' (nearest: 'lot B'); it adds nothing to mu"]
    >>> metadata_remarks([batch], None, ["t1"])
    ["the table of tests has no column 'batch': 'lot A' is taken for all tests"]
    """
    names = list(dict.fromkeys(map(str, measured)))
    remarks = []
    for given in variables:
        variable = _of_file(given) if isinstance(given, Mapping) else given
        labels = list(variable.labels)
        start = f"{variable.start:.4g}{behind(variable.unit)}"
        if variable.start in range(len(labels)):
            start = repr(shown(labels[int(variable.start)], 60))
        if tests is None or variable.name not in tests.columns or "test_id" not in tests.columns:
            columns = [] if tests is None else [str(c) for c in tests.columns]
            near = nearest(variable.name, columns)
            guess = f" (is it {near!r}?)" if near else ""
            remarks.append(
                f"the table of tests has no column {variable.name!r}{guess}: {start} is taken for all tests"
            )
            continue
        column = pd.Series(tests[variable.name].to_numpy(), index=tests["test_id"].astype(str))
        values = column.reindex(names).to_numpy()
        if labels:
            unknown = as_numbers(values, labels, variable.start) == UNKNOWN_LABEL
        else:
            unknown = np.isnan(as_numbers(values, (), np.nan))
        if not unknown.any():
            continue
        count = int(unknown.sum())
        subject = f"{count} of {counted(len(names), 'test')} {'has' if count == 1 else 'have'}"
        if not labels:
            remarks.append(f"{subject} no number as {variable.name}: {start} is taken")
            continue
        found = dict.fromkeys(
            "an empty cell" if pd.isna(v) else _with_nearest(v, labels) for v in values[unknown]
        )
        more = [f"and {len(found) - _LISTED} more"] if len(found) > _LISTED else []
        listed = ", ".join([*list(found)[:_LISTED], *more])
        remarks.append(
            f"{subject} a {variable.name} that was not in the training: {listed}; it adds nothing to mu"
        )
    return remarks


def _of_file(entry: JsonObject) -> Variable:
    labels = tuple(map(str, entry.get("labels", ())))
    return SystemVariable(
        str(entry.get("name")), str(entry.get("unit", "1")), entry["start"], 0.0, 0.0, labels
    )


def _with_nearest(value: object, labels: Sequence[str]) -> str:
    near = nearest(str(value), labels)
    # quoted before it is shortened: a blank at its end is what it may differ by
    return shown(repr(str(value)), 60) + (f" (nearest: {shown(near, 60)!r})" if near else "")
