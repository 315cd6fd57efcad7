"""A verification case: a run, and rows of reference, ours, deviation, tolerance, verdict; common parts of the cases."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError

from ..fe.mesh.shape import FloatArray
from ..materials.materials import HenselSpittel, steel_16MnCr5
from ..processes.base import FormingProcess
from ..results.result import FormingResult

Verdict = Literal["pass", "fail", "skipped", "not judged"]
VERDICTS: tuple[Verdict, ...] = ("pass", "fail", "skipped", "not judged")


@dataclass(frozen=True)
class Row:
    """One number against its reference."""

    #: What is compared, and its unit (empty: a bare number).
    quantity: str
    unit: str
    #: The number to compare with, and where it comes from.
    reference: float
    source: str
    #: What was computed.
    ours: float
    #: Allowed deviation: in % of the reference, or in the unit where `absolute`.
    tolerance: float
    #: The deviation is a difference in the unit, not a share of the reference.
    absolute: bool = False
    #: ``"skipped"``: the reference could not be computed here, and the one kept from an earlier run stands in
    #: for it; a deviation within the tolerance then counts as skipped, not as passed. ``"not judged"``: the
    #: reference does not hold here; `note` says why.
    standing: Literal["judged", "skipped", "not judged"] = "judged"
    note: str = ""
    #: Name of the case, set when it runs.
    case: str = ""

    @property
    def deviation(self) -> float:
        """Ours minus the reference, in % of it or in the unit."""
        difference = self.ours - self.reference
        if self.absolute:
            return difference
        return 100.0 * difference / self.reference if self.reference else math.nan

    @property
    def verdict(self) -> Verdict:
        """``"pass"``, ``"fail"``, ``"skipped"`` or ``"not judged"``; a number that is not finite fails."""
        if self.standing == "not judged":
            return "not judged"
        if not abs(self.deviation) <= self.tolerance:
            return "fail"
        return "skipped" if self.standing == "skipped" else "pass"

    @property
    def deviation_unit(self) -> str:
        """Unit of deviation and tolerance."""
        return self.unit if self.absolute else "%"

    def to_dict(self) -> dict[str, object]:
        """Return the row for JSON."""
        shown = "case quantity unit reference source ours deviation tolerance deviation_unit verdict note"
        return {name: getattr(self, name) for name in shown.split(" ")}


class Unfinished(Exception):
    """A run of a case stopped before its end; the message says where and why."""


@dataclass(frozen=True)
class Outcome:
    """Rows of a case, and a Markdown table with the details for the documentation."""

    rows: list[Row]
    details: str = ""


@dataclass(frozen=True)
class CaseResult:
    """Rows of a case that has run, details (Markdown), and its duration [s]."""

    case: Case
    rows: list[Row]
    details: str
    seconds: float

    @property
    def failed(self) -> bool:
        """Whether a row failed."""
        return any(row.verdict == "fail" for row in self.rows)


#: Runs a case and returns its rows, or an `Outcome`.
Compute = Callable[[], list[Row] | Outcome]


@dataclass(frozen=True)
class Case:
    """A verification case."""

    #: Short and unique, for ``--only``.
    name: str
    #: Heading in the documentation.
    group: str
    #: The set-up in one sentence.
    title: str
    compute: Compute
    #: Takes at most a few seconds.
    fast: bool = True

    def run(self) -> CaseResult:
        """Run the case; a run that stops early gives a failed row with the reason."""
        start = time.perf_counter()
        try:
            found = self.compute()
        except (Unfinished, InputError) as error:
            found = [Row("run to its end", "", 1.0, "", math.nan, 0.0, note=str(error))]
        outcome = found if isinstance(found, Outcome) else Outcome(found)
        rows = [replace(row, case=self.name) for row in outcome.rows]
        return CaseResult(self, rows, outcome.details, time.perf_counter() - start)


def case(cases: list[Case], name: str, group: str, fast: bool = True) -> Callable[[Compute], Compute]:
    """Add a function to `cases`; its docstring, the set-up in one sentence, is the title."""

    def add(compute: Compute) -> Compute:
        title = " ".join((compute.__doc__ or "").split())
        cases.append(Case(name, group, title, compute, fast))
        return compute

    return add


#: Published coefficients of 16MnCr5, kept apart from the product's: A [MPa], m1 [1/K], m2, m3, m4.
PUBLISHED = (677.443, -0.000788968, 0.103451, 0.0253737, 8.45076e-05)
#: Rate at which rate-independent comparisons hold the flow curve [1/s].
FROZEN_RATE = 0.5
#: Allowed error of the energy balance and of the unloaded volume [%].
ENERGY, VOLUME = 0.5, 0.1


def published_flow_stress(strain: npt.ArrayLike, T: float, rate: float) -> FloatArray:
    """Return the flow stress of 16MnCr5 after Hensel and Spittel from the published coefficients [MPa].

    The strain is bounded from below as the product does it: sqrt(strain^2 + 0.002^2).
    """
    A, m1, m2, m3, m4 = PUBLISHED
    phi = np.hypot(np.asarray(strain, dtype=np.float64), 2e-3)
    return A * np.exp(m1 * T + m4 / phi) * phi**m2 * rate**m3


def rate_independent() -> HenselSpittel:
    """Return 16MnCr5 with its flow curve held at 0.5/s, as CalculiX is given it."""
    steel = steel_16MnCr5()
    return replace(steel, A=steel.A * FROZEN_RATE**steel.m3, m3=0.0)


def finished(process: FormingProcess, result: FormingResult) -> FormingResult:
    """Return the result of a run that has reached its end.

    Raises Unfinished: the run stopped before its end.
    """
    if result.status != "ok":
        raise Unfinished(f"{process.name}: {result.message}")
    return result


def account_rows(result: FormingResult) -> list[Row]:
    """Return the rows on the energy balance and the unloaded volume of a run."""
    balance = "work of the punch = plastic + friction + elastic + contact springs"
    energy, volume = 100.0 * result.energy_balance, 100.0 * result.volume_change
    return [
        Row("energy balance", "%", 0.0, balance, energy, ENERGY, absolute=True),
        Row("unloaded volume", "%", 0.0, "plastic flow keeps it", volume, VOLUME, absolute=True),
    ]
