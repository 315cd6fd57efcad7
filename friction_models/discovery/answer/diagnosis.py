"""`Diagnosis`: the answer of `diagnose`."""

from __future__ import annotations

from dataclasses import dataclass

from .findings import Findings
from .report import text_report
from .wording import confidence_text

VERDICTS = (
    "explained",
    "partly_explained",
    "ambiguous",
    "unknown_structure",
    "nothing_missing",
    "data_problem",
    "out_of_domain",
)


@dataclass(kw_only=True)
class Diagnosis(Findings):
    """Which physical effect a model lacks, or why that cannot be said.

    `Findings` describes the attributes; the first to read are `verdict` (one of `VERDICTS`), `sentence`, `effects` and
    `warnings`.

    Examples
    --------
    Six tests in which friction falls with temperature, and a constant model that does not know of it:

    >>> import pandas as pd
    >>> from friction_models.discovery import diagnose
    >>> steps = [(k, j) for k in range(6) for j in range(8)]
    >>> data = pd.DataFrame({"test_id": [f"test{k}" for k, _ in steps], "sd": [2.0 * j for _, j in steps]})
    >>> data = data.assign(T=[20.0 + 10 * j for _, j in steps], mu=[0.1 - 0.002 * j + 1e-5 * k for k, j in steps])
    >>> answer = diagnose(data, model="constant", catalogue=["thermal_softening", "stribeck"])
    >>> answer.verdict, answer.effects
    ('explained', ['thermal_softening'])
    """

    def __repr__(self) -> str:
        named = f"effects={self.effects}, " if self.effects else ""
        return f"Diagnosis({self.verdict!r}, {named}confidence={confidence_text(self.confidence)}, model={self.model!r})"

    def report(self) -> str:
        """Return the text report: the verdict in one sentence first."""
        return text_report(self)
