"""Variables of a model beside the five loads: internal states (memory) and system variables (metadata)."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..common.json_values import JsonObject
from ..common.ranges import is_number

#: Number of a label that was not there in training: it is none of those that were.
UNKNOWN_LABEL = -1.0
#: Label of the tests for which nothing is recorded, where these are several.
NOT_RECORDED = "not recorded"


@dataclass(frozen=True)
class StateVariable:
    """One internal state, kept once per material contact point.

    Examples
    --------
    >>> StateVariable("age", "s", start=1.0, ode=True).to_dict()
    {'name': 'age', 'unit': 's', 'start': 1.0, 'ode': True}
    """

    #: Identifier and unit (``"1"`` for a number).
    name: str
    unit: str
    #: Value of fresh, never loaded contact.
    start: float
    #: Whether the state obeys an ODE whose derivative the model gives.
    ode: bool = False

    def to_dict(self) -> JsonObject:
        """Return the entry of `tribofmu.state`."""
        return asdict(self)


@dataclass(frozen=True)
class SystemVariable:
    """One property of the tribological system that test metadata may hold (tool roughness, batch).

    Examples
    --------
    >>> batch = SystemVariable("batch", "1", start=0.0, min=0.0, max=1.0, labels=("A", "B"))
    >>> batch.to_dict()["labels"]
    ['A', 'B']
    """

    #: Identifier and unit.
    name: str
    unit: str
    #: Value used where the metadata lacks it.
    start: float
    #: Range seen in training.
    min: float
    max: float
    #: For metadata that is text: the labels of the numbers 0, 1, 2 ...; empty for a number.
    labels: tuple[str, ...] = ()

    def to_dict(self) -> JsonObject:
        """Return the entry of `tribofmu.system`; `labels` only where there are some."""
        entry = asdict(self) | {"labels": list(self.labels)}
        return entry if self.labels else {k: v for k, v in entry.items() if k != "labels"}


def as_numbers(
    values: Sequence[Any] | npt.NDArray[Any], labels: Sequence[str], start: float
) -> npt.NDArray[Any]:
    """Return metadata, one entry a point as the table of tests has it, as the numbers that a model takes, shape (n,).

    `labels` are those of the numbers 0, 1, 2 ..., empty where the metadata is a number. A label that is not among
    them becomes `UNKNOWN_LABEL`, an empty cell `NOT_RECORDED` if that is one of them; `start` is taken where a number is missing. A
    table in which all labels look like numbers has lost how they were written: there a number is the one label of its value.

    Examples
    --------
    >>> as_numbers(["B", "A", "C"], labels=["A", "B"], start=0.0).tolist()
    [1.0, 0.0, -1.0]
    >>> as_numbers([1, 2.0], labels=["01", "2", "X"], start=0.0).tolist()
    [0.0, 1.0]
    >>> as_numbers(["A", None], labels=["A", "not recorded"], start=0.0).tolist()
    [0.0, 1.0]
    >>> as_numbers([0.02, None], labels=[], start=0.01).tolist()
    [0.02, 0.01]
    """
    import pandas as pd

    if len(labels):
        codes = {str(label): float(k) for k, label in enumerate(labels)}
        empty = codes.get(NOT_RECORDED, UNKNOWN_LABEL)
        by_value = _by_value(codes)

        def code(value: Any) -> float:
            other = by_value.get(float(value), UNKNOWN_LABEL) if is_number(value) else UNKNOWN_LABEL
            return empty if pd.isna(value) else codes.get(str(value), other)

        return np.array([code(v) for v in values], dtype=np.float64)
    numbers = pd.to_numeric(pd.Series(values), errors="coerce").to_numpy(dtype=np.float64)
    return np.where(np.isfinite(numbers), numbers, start)


def _by_value(codes: Mapping[str, float]) -> dict[float, float]:
    """Return the codes of labels that look like numbers by their values; without values that two of them have."""
    found: dict[float, list[float]] = {}
    for label, code in codes.items():
        with contextlib.suppress(ValueError):
            found.setdefault(float(label), []).append(code)
    return {value: own[0] for value, own in found.items() if len(own) == 1}
