"""A verification case: a run, and rows of reference, ours, deviation, tolerance, verdict."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

from friction_models.common import InputError

Verdict = Literal["pass", "fail", "skipped", "not judged"]
VERDICTS: tuple[Verdict, ...] = ("pass", "fail", "skipped", "not judged")


@dataclass(frozen=True)
class Row:
    """One number against its reference.

    Attributes
    ----------
    quantity, unit : str
        What is compared, and its unit (empty: a bare number).
    reference : float
        The number to compare with.
    source : str
        Where it comes from.
    ours : float
        What was computed.
    tolerance : float
        Allowed deviation: in % of the reference, or in the unit where `absolute`.
    absolute : bool
        The deviation is a difference in the unit, not a share of the reference.
    standing : {"judged", "skipped", "not judged"}
        ``"skipped"``: the reference could not be computed here, and the one kept from an earlier run stands in
        for it; a deviation within the tolerance then counts as skipped, not as passed. ``"not judged"``: the
        reference does not hold here; `note` says why.
    note : str
        Reason or remark.
    case : str
        Name of the case, set when it runs.
    """

    quantity: str
    unit: str
    reference: float
    source: str
    ours: float
    tolerance: float
    absolute: bool = False
    standing: Literal["judged", "skipped", "not judged"] = "judged"
    note: str = ""
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
        return {
            "case": self.case,
            "quantity": self.quantity,
            "unit": self.unit,
            "reference": self.reference,
            "source": self.source,
            "ours": self.ours,
            "deviation": self.deviation,
            "tolerance": self.tolerance,
            "deviation_unit": self.deviation_unit,
            "verdict": self.verdict,
            "note": self.note,
        }


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


@dataclass(frozen=True)
class Case:
    """A verification case.

    Attributes
    ----------
    name : str
        Short and unique, for ``--only``.
    group : str
        Heading in the documentation.
    title : str
        The set-up in one sentence.
    compute : callable
        Runs it and returns its rows, or an `Outcome`.
    fast : bool
        Takes at most a few seconds.
    """

    name: str
    group: str
    title: str
    compute: Callable[[], list[Row] | Outcome]
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
