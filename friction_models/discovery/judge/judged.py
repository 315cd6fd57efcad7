"""A verdict, what it rests on, and what it leaves open."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ...estimation.search.scan import Fit
from ...estimation.search.search_round import SearchRound
from .confirmation import NAMED, Confirmation
from .unseen_tests import UnseenTests
from .verdict import Evidence


@dataclass
class Judged:
    """A verdict and what it rests on."""

    found: SearchRound
    evidence: Evidence
    confirmed: Confirmation
    notes: list[str]
    unseen: UnseenTests | None = None
    beside: Callable[[Sequence[Fit]], SearchRound] | None = None  #: Searches beside names.
    knows_noise: bool = False
    odd_kept: bool = False  #: Whether tests that lie far off all others are among these.
    odd_region: bool = False  #: Whether such tests were left out that lie together in a corner of the loads.

    @property
    def verdict(self) -> str:
        """Verdict after the prediction of unseen tests."""
        return self.confirmed.verdict

    @property
    def chosen(self) -> list[Fit]:
        """What it names."""
        return self.confirmed.chosen

    @property
    def named(self) -> list[Fit]:
        """The effects that the verdict names; none where it is one without names."""
        return self.chosen if self.verdict in NAMED else []

    @property
    def confusion(self) -> list[str]:
        """What cannot be told from the first name, the name itself first; then further names, each before its own rivals."""
        if not self.named:
            return []
        first, *others = [f.name for f in self.named]
        if self.verdict == "explained":  # each name stands alone, whatever the search could not tell apart
            return [first]
        known, rivals = self.evidence.confusion_set, self.confirmed.rivals
        # what is named beside the first one is no rival of it
        alike = [n for n in known if n not in others] if first in known else []
        # a larger effect may lead, found beside the winner of the scan
        later = known if len(known) > 1 and known[0] in others else []
        return list(dict.fromkeys([first, *alike, *rivals, *later]))


def alternatives(names: Sequence[str], confusion: Sequence[str]) -> list[list[str]]:
    """Return each effect that is named with what the data cannot tell from it, the name first.

    In `confusion` stand the first name and its rivals, then each further name that has rivals, before them.

    Examples
    --------
    >>> alternatives(["work_exhaustion", "stribeck"], ["work_exhaustion", "stribeck", "hersey"])
    [['work_exhaustion'], ['stribeck', 'hersey']]
    """
    groups = {name: [name] for name in names}
    own = next(iter(groups))
    for name in confusion:
        if name in groups:
            own = name
        else:
            groups[own].append(name)
    return list(groups.values())
