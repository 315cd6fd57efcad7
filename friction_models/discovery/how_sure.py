"""How sure an answer is: by what it rests on, and by everything that speaks against it."""

from __future__ import annotations

from dataclasses import dataclass

from ..estimation.campaign.binned_tests import BinnedTests
from ..estimation.search.base_law import BaseLaw
from .causes.other_causes import OtherCauses
from .judge.closest import Closest
from .judge.confidence import grounds, undoubted
from .judge.doubts import LIKELY, MOSTLY, ZERO_UNREAD, Doubt, Sureness, doubts_of, least, sureness
from .judge.judged import Judged
from .judge.level_offset import LevelOffset
from .judge.load_doubts import load_doubts


@dataclass(frozen=True)
class HowSure:
    """How sure an answer is, and why no surer."""

    grounds: dict[str, float]  #: What the confidence rests on; ``most`` is how sure the doubts let it be.
    of_loads: list[Doubt]  #: What loads leave open that the tests hardly show; each reason is a sentence.
    beside_loads: Sureness  #: How sure it is without these.

    @classmethod
    def of(
        cls,
        campaign: BinnedTests,
        base: BaseLaw,
        judged: Judged,
        causes: OtherCauses,
        level: LevelOffset,
        closest: Closest | None,
        *,
        unread: bool,
        codes: bool,
    ) -> HowSure:
        """Weigh a verdict.

        Beside it stand other `causes`, the `level` of a model as it is, and what comes `closest` where nothing is named. An offset of
        the force may be `unread`, and numbers of a column `codes`.
        """
        verdict, chosen = judged.verdict, judged.named
        rests_on = grounds(judged.found, judged.evidence, judged.confirmed, len(campaign.tests))
        doubts = [*doubts_of(campaign, base, judged, rests_on, level.off), *causes.doubts(verdict)]
        if unread:
            doubts.append(Doubt(ZERO_UNREAD, MOSTLY))
        if closest is not None and closest.explains:
            # of twenty such answers to campaigns of three authors ten were right and nine acceptable
            reason = "one effect would explain what is missing, if its form were another"
            doubts.append(Doubt(reason, LIKELY))
        if codes:
            doubts.append(Doubt("the numbers of a column may be names", MOSTLY))
        of_loads = load_doubts(campaign, verdict, chosen)
        sure = undoubted(judged.confirmed, rests_on, level.p_value if level.off else None)
        return cls({**rests_on, "most": least([*doubts, *of_loads])}, of_loads, sureness(sure, doubts))

    @property
    def value(self) -> float:
        """The confidence, as files have it: the sentence and a page made of them say the same."""
        return round(sureness(self.beside_loads.value, self.of_loads).value, 3)

    @property
    def held_by_loads(self) -> bool:
        """Whether loads hold it more than anything else."""
        return least(self.of_loads) < self.beside_loads.value
