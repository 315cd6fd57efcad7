"""A verdict after the prediction of whole tests that no fit has seen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from ...estimation.noise.repeats import Repeats
from ...estimation.search.scan import Fit
from ...estimation.search.structure import StructurePlace
from ...loads import FloatArray
from .error_budget import ErrorShares

#: Verdicts that name effects.
NAMED = ("explained", "partly_explained", "ambiguous", "data_problem")
#: Less than this share of what can be predicted is left: the names explain it.
EXPLAINED = 0.15
#: More than this share is left: what is named is not the answer.
NOT_THE_ANSWER = 0.4
#: From so many standard errors on the reference predicts better than what is named, however little: its form is another one.
ANOTHER_FORM = 2.5


class OwnFormExplains(NamedTuple):
    """What explains what is missing where nothing is named."""

    own: tuple[str, ...]  #: What the model itself could do, though no fit of it does.
    effect: str = ""  #: The effect that it takes beside; empty where none is needed.


@dataclass(frozen=True)
class Confirmation:
    """Verdict after the prediction of unseen tests."""

    verdict: str
    chosen: list[Fit] = field(default_factory=list)  #: Effects that lower the error on unseen tests.
    shares: ErrorShares | None = None  #: None where there are too few tests to leave some out.
    #: Standard errors over the tests by which the last name lowers the error; 0 where nothing is named.
    certain: float = 0.0
    where: list[StructurePlace] = field(default_factory=list)  #: Where something predictable is left.
    beyond: FloatArray | None = None  #: This in the bins, shape (m,).
    #: Effects whose lead the first one owes to no more than what it leaves itself: it may be a matter of formulas. Then further
    #: names, each with what unseen tests cannot tell from it.
    rivals: tuple[str, ...] = ()
    behind: tuple[str, ...] = ()  #: Rivals of the scan that unseen tests leave far behind.
    #: Names in whose place two effects of one load each predict unseen tests no worse, and these two.
    parts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    #: Names in whose place the product of two loads predicts unseen tests better, if not for certain, and these loads.
    products: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    #: Names in whose place the model itself does as well, and with what, though no fit of it does it.
    own_form: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    #: What the model itself could do to explain what is missing, where nothing is named; None where that is not enough.
    own_form_explains: OwnFormExplains | None = None
    #: Names of several loads in whose place a power law of the loads does as well.
    by_powers: tuple[str, ...] = ()
    little: tuple[str, ...] = ()  #: Of several names those without which the error hardly rises.
    repeats: Repeats | None = None  #: Scatter of tests at the same settings, where there are some.
    #: Names that cancel slopes of the model, but that unseen tests prefer to all plain bends along their load.
    sharper: frozenset[str] = frozenset()
    own_law: str = ""  #: Which level of a column follows a law of its own, and along what.
    #: Whether the model alone predicts unseen tests closer than friction is measured.
    within_resolution: bool = False

    @property
    def lacks_fit(self) -> bool:
        """Whether settings differ by more than their repeats do, beside the model and what is named."""
        return self.repeats is not None and self.repeats.lacks_fit

    @property
    def by_repeats(self) -> bool:
        """Whether settings differ by more than their repeats, and nothing predicts how: a law of the loads, or of the day."""
        return self.lacks_fit and self.shares is not None and self.shares.source == "model"

    @property
    def leaves_much(self) -> bool:
        """Whether more can be predicted, and something does predict it, than effects that explain may leave."""
        shares = self.shares
        return (
            self.verdict in NAMED
            and shares is not None
            and shares.source != "model"
            and shares.left > EXPLAINED
        )

    @property
    def of_another_form(self) -> bool:
        """Whether unseen tests are predicted a little better without the formulas of what is named than with them."""
        return self.verdict in NAMED and self.shares is not None and self.shares.beyond > ANOTHER_FORM
