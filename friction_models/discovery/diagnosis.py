"""`Diagnosis`: the answer of `diagnose`, as data, as JSON and as a text report."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from ..effects.base import Effect

VERDICTS = ("explained", "ambiguous", "unknown_structure", "nothing_missing", "data_problem", "out_of_domain")


@dataclass
class Diagnosis:
    """Which physical effect a model lacks, or why that cannot be said.

    Attributes
    ----------
    verdict : str
        One of `VERDICTS`.
    sentence : str
        The verdict in one sentence.
    effects : list of str
        What to add: one effect, a pair, or nothing.
    confidence : float
        0 to 1: how sure the verdict is.
    confusion_set : list of str
        Every effect that the data cannot tell from the winner, the winner included.
    ranking : list of dict
        ``effect``, ``evidence`` (the gain where the form of the effect may be somewhat wrong), ``gain`` (drop of the
        whitened squared error less two per degree of freedom), ``p_value`` (of the gain, family-wise), best
        evidence first.
    noise_floor : dict
        ``sensor``, ``test``, ``drift``, ``total`` and the 95 % ``interval`` of the total, all in mu.
    error_budget : dict
        RMS in mu: ``floor``, ``explained`` by the effects named, ``missing`` beyond both.
    where : list of dict
        Unexplained structure: ``variables``, ``region``, ``shape``, ``share``.
    worst_tests : list of dict
        ``test_id`` and ``rms`` of the base's residual.
    unrecorded_factor : dict or None
        Two groups of test offsets, when there are.
    next_tests : list of dict
        ``protocol``, ``setpoints``, ``separates``, ``expected_t``.
    warnings : list of str
        What limits the answer.
    model : str
        The base.
    bias : list of dict
        Binned residual against each load: ``load``, ``low``, ``high``, ``bias``, ``interval``, ``tests``; where
        effects are named also ``after`` and ``after_interval`` with them.
    parameters : dict
        Fitted parameters of the effects named, with units.
    named : dict of str to Effect
        The effects named, also those that a user handed over.
    synthetic : bool
        Whether the data says of itself that it is synthetic (``data.attrs["synthetic"]``).
    threshold : float
        Gain from which on an effect stands out among all of the catalogue.
    averages : pandas.DataFrame
        What was judged: a row for each bin of the distance of each test, with ``test_id``, ``points``, the loads that
        the data hold, metadata that the effects named need, measured ``mu``, what the base leaves of it (``before``), what base and effects
        leave (``after``), and for each effect named its share of mu (``effect NAME``).
    """

    verdict: str
    sentence: str
    effects: list[str] = field(default_factory=list)
    confidence: float = 0.0
    confusion_set: list[str] = field(default_factory=list)
    ranking: list[dict[str, Any]] = field(default_factory=list)
    noise_floor: dict[str, Any] = field(default_factory=dict)
    error_budget: dict[str, float] = field(default_factory=dict)
    where: list[dict[str, Any]] = field(default_factory=list)
    worst_tests: list[dict[str, Any]] = field(default_factory=list)
    unrecorded_factor: dict[str, Any] | None = None
    next_tests: list[dict[str, Any]] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    model: str = ""
    bias: list[dict[str, Any]] = field(default_factory=list)
    parameters: dict[str, dict[str, Any]] = field(default_factory=dict)
    named: dict[str, Effect] = field(default_factory=dict, repr=False)
    synthetic: bool = False
    threshold: float = float("nan")
    averages: pd.DataFrame = field(default_factory=pd.DataFrame, repr=False)

    def to_dict(self) -> dict[str, Any]:
        """Return what ``diagnose --json`` writes."""
        return {
            "verdict": self.verdict,
            "effects": list(self.effects),
            "confidence": self.confidence,
            "confusion_set": list(self.confusion_set),
            "ranking": self.ranking,
            "noise_floor": self.noise_floor,
            "error_budget": self.error_budget,
            "where": self.where,
            "worst_tests": self.worst_tests,
            "unrecorded_factor": self.unrecorded_factor,
            "next_tests": self.next_tests,
            "warnings": list(self.warnings),
        }

    def report(self) -> str:
        """Return the text report: the verdict in one sentence first."""
        from .report import text_report

        return text_report(self)
