"""A case - a client on one form of the friction FMU - and how what it brought is compared with the model's own mu."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from friction_models.loads import FloatArray

from .running import Outcome, version
from .subjects import Subjects

#: Largest difference from the model itself, relative to mu: the same arithmetic in another order.
CLOSE = 1e-12
#: mu passes through a printed number, or an integrator.
PRINTED, INTEGRATED = 1e-11, 1e-6
#: What the table says of model exchange with memory.
CONSTANT = "loads constant; reference: another integrator on the model's rate"


@dataclass
class Result:
    """What a case brought.

    Attributes
    ----------
    outcome : str
        ``agrees``, ``differs``, ``refused`` (an error or a crash).
    deviation : float
        Largest difference of mu relative to the model's own; NaN without values.
    seen : str
        What stands in the table beside it.
    """

    outcome: str
    deviation: float = np.nan
    seen: str = ""


@dataclass(frozen=True)
class Case:
    """One run of one client.

    Attributes
    ----------
    client, needs : str, tuple of str
        Who, and which distributions or programs must be here for it.
    fmi, form, shape, model : str
        Version, kind of the FMU, scalar or array, and which model.
    run : callable
        Does it.
    supported : bool
        Whether the client is known to be able to do this.
    """

    client: str
    needs: tuple[str, ...]
    fmi: str
    form: str
    shape: str
    model: str
    run: Callable[[Case, Subjects, Path], Result]
    supported: bool = True

    @property
    def label(self) -> str:
        """Name in the list of tests."""
        return f"{self.client}, FMI {self.fmi} {self.form}, {self.shape}, {self.model}"

    @property
    def points(self) -> int:
        return 1 if self.shape == "scalar" else int(self.shape.rpartition(" ")[2])

    @property
    def version(self) -> str | None:
        """Version of the client, None when something it needs is not here."""
        found = [version(name) for name in self.needs]
        return None if None in found else found[0]


def compared(outcome: Outcome, expected: FloatArray, tolerance: float = CLOSE, scale: float = 1.0) -> Result:
    """Compare the values of a child process with the model's own."""
    if outcome.result is None or "values" not in outcome.result:
        return Result("refused", seen=outcome.seen)
    values = np.array(outcome.result["values"], dtype=float)[: len(expected)] / scale
    if values.shape != expected.shape:
        return Result("differs", seen=f"values of shape {values.shape} instead of {expected.shape}")
    deviation = float(np.max(np.abs(values - expected) / expected))
    if deviation <= tolerance:
        return Result("agrees", deviation, outcome.seen)
    return Result("differs", deviation, "mu is 0.0 throughout" if not values.any() else "other values")
