"""What a diagnosis found, as data: the tables and numbers from which report, page and JSON are made."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NotRequired, TypedDict

import pandas as pd

from ...common.imports.drawn import Drawn
from ...common.json_values import plain
from ...effects.base import Effect
from ...estimation.noise.noise_floor import NoiseFloorNumbers
from ...estimation.search.structure import StructurePlace
from ..causes.test_groups import TestGroups
from ..formulas.offers import FormulaOffer
from ..further_tests.next_tests import NextTest
from ..judge.judged import alternatives

#: What a reader of the ranking has to know.
ORDER_OF_RANKING = "the largest stands first, but behind a simpler effect beyond which it shows nothing, or behind one whose load varies more"
OTHERS_BY_CHANCE = "each is tried without the others and shares, if only by chance, in what the first one explains: a small p of a later one says little"


class RankedEffect(TypedDict):
    """How much the data speak for an effect.

    ``gain`` is the drop of the whitened squared error less two per degree of freedom, ``p_value`` its family-wise
    p-value, ``evidence`` the gain where the form of the effect may be somewhat wrong.
    """

    effect: str
    evidence: float
    gain: float
    p_value: float


class ErrorBudget(TypedDict):
    """RMS in mu on whole tests that the fits did not see; the squares add up to the error of the model.

    ``floor`` is what no model predicts, ``explained`` what the named effects explain, ``missing`` what can be predicted and
    is not.
    """

    floor: float
    explained: float
    missing: float


class WorstTest(TypedDict):
    """RMS of what the model leaves in one test."""

    test_id: str
    rms: float


class BinnedBias(TypedDict):
    """Mean residual in a range of one load, with its 95 % interval over whole tests; `after` with the named effects."""

    load: str
    low: float
    high: float
    bias: float
    interval: list[float]
    tests: int
    after: NotRequired[float]
    after_interval: NotRequired[list[float]]


class ParameterValue(TypedDict):
    """A fitted parameter, with its 95 % interval where it was fitted."""

    value: float
    unit: str
    interval: NotRequired[list[float]]
    not_known: NotRequired[bool]  #: The interval is all that was sought.


class FittedEffect(TypedDict):
    """Equation of an effect and its fitted parameters by name."""

    equation: str
    values: dict[str, ParameterValue]


@dataclass(kw_only=True)
class Findings(Drawn):
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
        0 to 1: the share of such answers that are right.
    grounds : dict of str to float
        What the confidence is computed from (see `friction_models.discovery.judge.confidence.grounds`).
    confusion_set : list of str
        Every effect that the data cannot tell from the winner, the winner included.
    ranking : list of RankedEffect
        Best evidence first.
    noise_floor : NoiseFloorNumbers
        In mu; the 95 % interval is that of the total.
    error_budget : ErrorBudget
    where : list of StructurePlace
        Unexplained structure.
    worst_tests : list of WorstTest
        Largest residual of the base first.
    unrecorded_factor : TestGroups or None
        Two groups of test offsets, when there are.
    next_tests : list of NextTest
        The most telling first.
    warnings : list of str
        What limits the answer.
    model : str
        The base.
    bias : list of BinnedBias
    parameters : dict of str to FittedEffect
        By effect named.
    named : dict of str to Effect
        The effects named, also those that a user handed over.
    tests : dict of str to str
        A short hash of what was measured in each test, see `friction_models.models.model_card.test_digests`; empty where there
        are more than `LISTED_TESTS`, or no names.
    synthetic : bool
        Whether the data says of itself that it is synthetic (``data.attrs["synthetic"]``).
    threshold : float
        Gain from which on an effect stands out among all of the catalogue; NaN where few tests are judged in two families.
    not_first : str
        Why the first effect is not the first of the ranking, where it is not.
    formulas : list of FormulaOffer
        Empirical terms that predict unseen tests better, where structure is left that no effect explains; nothing adds them.
    averages : pandas.DataFrame
        What was judged: a row for each bin of the distance of each test, with ``test_id``, ``points``, the loads that the
        data hold, metadata that the effects named need, measured ``mu``, what the base leaves of it (``before``), what base
        and effects leave (``after``), and for each effect named its share of mu (``effect NAME``).
    """

    verdict: str
    sentence: str
    effects: list[str]
    confidence: float
    confusion_set: list[str]
    ranking: list[RankedEffect]
    noise_floor: NoiseFloorNumbers
    error_budget: ErrorBudget
    where: list[StructurePlace]
    worst_tests: list[WorstTest]
    unrecorded_factor: TestGroups | None
    next_tests: list[NextTest]
    warnings: list[str]
    model: str
    bias: list[BinnedBias]
    parameters: dict[str, FittedEffect]
    named: dict[str, Effect] = field(repr=False)
    threshold: float
    averages: pd.DataFrame = field(repr=False)
    grounds: dict[str, float] = field(default_factory=dict, repr=False)
    tests: dict[str, str] = field(default_factory=dict, repr=False)
    synthetic: bool = False
    formulas: list[FormulaOffer] = field(default_factory=list)
    not_first: str = ""

    @property
    def alternatives(self) -> list[list[str]]:
        """Each effect named with what the data cannot tell from it, the name first."""
        return alternatives(self.effects, self.confusion_set) if self.effects else []

    def to_dict(self) -> dict[str, object]:
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
            "sentence": self.sentence,
            "model": self.model,
            "parameters": plain(self.parameters),
            "residuals": plain(self.bias),
            "formulas": [offer.to_dict() for offer in self.formulas],
            "not_first": self.not_first,
            "tests": dict(self.tests),
            "alternatives": self.alternatives,
        }
