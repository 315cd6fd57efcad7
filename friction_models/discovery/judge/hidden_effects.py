"""How large an effect of one load could be there and not be seen in these tests."""

from __future__ import annotations

import numpy as np

from ...estimation.search.scan import Prepared
from ...estimation.search.search_round import SearchRound
from .names import CLEAR

#: Share of the shapes of a law that show.
SHAPES = 0.75
#: Standard errors beyond what is needed from which on nine of ten effects are seen (normal distribution).
NINE_OF_TEN = 1.28


def unseen_sizes(found: SearchRound) -> dict[str, float]:
    """Return the change of mu over the tests with each load from which on it is seen in most such campaigns.

    Three of four shapes of each law of the load show by that.
    """
    sizes: dict[str, float] = {}
    for candidate in found.candidates:
        effect = candidate.candidate.effect
        simple = effect.kind == "physics" and len(effect.driver) == 1 and not effect.needs_state
        if simple and candidate.usable[:, 0].any():
            load = effect.driver[0]
            sizes[load] = max(sizes.get(load, 0.0), _unseen(found, candidate))
    return sizes


def _unseen(found: SearchRound, candidate: Prepared) -> float:
    """Return the change of mu over the tests from which on an effect is seen in most of its shapes."""
    needed = found.significance.needed(CLEAR, candidate.name) + candidate.penalty
    usable = candidate.usable[:, 0]
    seen = np.sqrt(candidate.gram[usable, 0, 0])  # whitened, of an amplitude of 1
    change = np.ptp(candidate.candidate.columns[:, usable, 0], axis=0)
    return float((np.sqrt(needed) + NINE_OF_TEN) * np.quantile(change / seen, SHAPES))
