"""The verdict in one sentence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ...common.wording import first_names, listed
from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.campaign.binning import FEW_TESTS
from ...estimation.search.scan import Fit
from ...estimation.search.structure import StructurePlace
from ..causes.run_order import JUMP
from ..causes.test_groups import TestGroups
from ..judge.doubts import LIKELY
from ..judge.judged import alternatives
from ..judge.verdict import LEVEL, Evidence
from .wording import confidence_text

#: How the sentence begins where nothing is missing, as far as anybody can tell; a page has the same headline.
NOTHING = "nothing is missing"
NOTHING_SEEN = "nothing can be seen to be missing"


@dataclass(frozen=True, kw_only=True)
class Sentence:
    """What the verdict in one sentence tells."""

    verdict: str
    base: str  #: Name of the model that was judged.
    evidence: Evidence
    chosen: Sequence[Fit]
    confusion: Sequence[str]  #: What cannot be told apart.
    confidence: float
    campaign: BinnedTests
    where: Sequence[StructurePlace] = ()  #: The structure that is left.
    by_factor: bool = False  #: Whether the model is off by a factor where it is off everywhere.
    factor: TestGroups | None = None  #: Groups of tests.
    close: float | None = (
        None  #: Error on unseen tests as a share of mu, where it is below what can be measured.
    )
    unread: bool = (
        False  #: Whether an offset of the force is named beside other effects, and was not read without load.
    )
    hidden: bool = False  #: Whether an effect stands out, or would not show.
    jump: str | None = None  #: Where the tests jump in their order.
    by_settings: bool = (
        False  #: Whether settings differ by more than their repeats, and nothing predicts how.
    )

    def text(self) -> str:
        """Return the sentence as a user reads it."""
        say = {
            "explained": self._explained,
            "partly_explained": self._partly_explained,
            "ambiguous": self._ambiguous,
            "data_problem": self._data_problem,
            "unknown_structure": self._unknown_structure,
            "out_of_domain": self._out_of_domain,
        }
        return say.get(self.verdict, self._nothing_missing)()

    def _explained(self) -> str:
        p = self.evidence.p_value
        # where the scan is not sure, unseen tests are
        by = f"p = {p:.3f}" if p < LEVEL else f"by the error on unseen tests (p = {p:.3f})"
        verb = "is" if len(self.chosen) == 1 else "are"
        return f"{self._labels} {verb} missing from {self._model}: {self._what} {self._sure()}, {by}."

    def _partly_explained(self) -> str:
        verb, it = ("is", "it") if len(self.chosen) == 1 else ("are", "them")
        rest = f"something else that can be predicted is left{self._rest}"
        if self.by_settings:
            rest = "settings still differ by more than their repeats, and nothing predicts how"
        return f"{self._labels} {verb} missing from {self._model}: {self._what}; with {it} the error on unseen tests falls, but {rest} {self._sure()}."

    def _ambiguous(self) -> str:
        known = {f.name: f.effect.label for f in self.evidence.found.ranking}
        more = f"; something else that can be predicted is left{self._rest}" if self.where else ""
        what = f"{self._what} {self._sure()}{more}."
        if len(self.chosen) == 1:
            rivals = ", ".join(known.get(name, name) for name in self.confusion)
            return f"an effect is missing from {self._model}, but these data cannot tell {rivals} apart; {self._labels} fits best: {what}"
        groups = alternatives([f.name for f in self.chosen], self.confusion)
        parts = [" or ".join(known.get(n, n) for n in g) for g in groups]
        several = listed(f"({p})" if len(g) > 1 else p for p, g in zip(parts, groups, strict=True))
        return f"{several} are missing from {self._model}; {self._labels} fit best: {what}"

    def _data_problem(self) -> str:
        if not self.chosen:
            return (
                f"{100 * self.campaign.spikes:.0f} % of the points lie far off their neighbours: the records have to be repaired "
                f"before {self._model} can be judged {self._sure()}."
            )
        p = f"p = {self.evidence.p_value:.3f}"
        if self.jump:
            return (
                f"{JUMP} {self.jump} in the order of the campaign, which {self._labels} only follows: something was changed there that the "
                f"test table does not record {self._sure()}, {p}."
            )
        return f"the residual of {self._model} looks like a fault of the data: {self._labels}, {self._what} {self._sure()}, {p}."

    def _unknown_structure(self) -> str:
        if self.where and not _along(self.where):
            what = "factor" if self.by_factor else "amount"
            return (
                f"{self._model} is off by the same {what} everywhere ({self.where[0]['shape']}), which no effect of a load explains "
                f"{self._sure()}."
            )
        return f"something systematic is missing from {self._model} that no effect in the catalogue explains{self._rest} {self._sure()}."

    def _out_of_domain(self) -> str:
        return (
            f"{100 * self.evidence.outside:.0f} % of the points, every test counted alike, lie outside the loads that {self._model} was trained on; no effect can be "
            "judged there."
        )

    def _nothing_missing(self) -> str:
        tests = len(self.campaign.tests)
        seen = f"{NOTHING_SEEN} from {self._model}"
        if tests < FEW_TESTS:
            some = f"{tests} test{'s' if tests > 1 else ''}"
            short = "cannot show the scatter between tests: at least 3 are needed, better 10"
            if self.evidence.found.floor.known:
                short = "hardly show the scatter between tests: 10 would be better"
            return f"{seen}, but {some} {short} (confidence {confidence_text(self.confidence)})."
        if self.factor is not None:
            group, several = self.factor["group"], self.factor.get("groups", 2) > 2
            one, few = ("higher ones", "several groups up to") if several else ("higher one", "two groups")
            return (
                f"no effect in the catalogue can be seen to be missing from {self._model}, but the tests fall into {few} "
                f"{self.factor['gap']:.4f} apart ({len(group)} and {self.factor['others']} tests; the {one}: {first_names(group)}): a "
                f"factor that is not recorded may set them apart {self._sure()}."
            )
        if self.confidence <= LIKELY:
            return f"{seen}, but these tests do not rule it out {self._sure()}."
        if self.hidden:
            return f"{seen} {self._sure()}; an effect that these tests hardly show may be there all the same."
        if self.close is not None:
            return (
                f"{NOTHING} from {self._model}: it predicts tests that it has not seen to {100 * self.close:.2g} % of mu, "
                f"closer than friction can be measured {self._sure()}."
            )
        return f"{NOTHING} from {self._model}: its residual is at the noise floor {self._sure()}."

    def _sure(self) -> str:
        few = (
            "" if self.evidence.found.floor.known else "; so few tests cannot show the scatter between tests"
        )
        return f"(confidence {confidence_text(self.confidence)}{few})"

    @property
    def _model(self) -> str:
        return f"the {self.base} model"

    @property
    def _labels(self) -> str:
        return listed(f.effect.label for f in self.chosen)

    @property
    def _what(self) -> str:
        what = "; ".join(f.effect.sentence for f in self.chosen)
        reading = "; only a reading without load tells the offset of the force from an effect of pressure"
        return what + (reading if self.unread else "")

    @property
    def _rest(self) -> str:
        along = _along(self.where)
        return f", along {along}" if along else ""


def _along(where: Sequence[StructurePlace]) -> str:
    """Return the loads along which structure is left."""
    joints = {"interaction": " x "}
    return "; ".join(
        joints.get(w["shape"], " and ").join(w["variables"]) for w in where[:2] if w["variables"]
    )
