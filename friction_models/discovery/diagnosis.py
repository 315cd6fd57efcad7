"""`Diagnosis`: the answer of `diagnose`."""

from __future__ import annotations

from dataclasses import dataclass

from .findings import Findings
from .report import text_report

VERDICTS = ("explained", "ambiguous", "unknown_structure", "nothing_missing", "data_problem", "out_of_domain")


@dataclass(kw_only=True)
class Diagnosis(Findings):
    """Which physical effect a model lacks, or why that cannot be said.

    `Findings` describes the attributes; the first to read are `verdict` (one of `VERDICTS`), `sentence`, `effects` and
    `warnings`.
    """

    def report(self) -> str:
        """Return the text report: the verdict in one sentence first."""
        return text_report(self)
