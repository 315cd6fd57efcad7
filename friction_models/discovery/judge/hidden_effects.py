"""How large an effect of one load could be there and not be seen in these tests."""

from __future__ import annotations

import numpy as np

from ...estimation.search.scan import Prepared
from ...estimation.search.search_round import SearchRound
from .naming.names import CLEAR

#: Shares of the shapes of a law that show: of the law that shows best, and of each.
EASY, MOST = 0.25, 0.75
#: Standard errors beyond what is needed from which on nine of ten effects are seen (normal distribution).
NINE_OF_TEN = 1.28


def unseen_sizes(found: SearchRound) -> dict[str, tuple[float, float]]:
    """Return the changes of mu over the tests with each load from which on effects are seen that are easy to see, and most.

    One of four shapes of the law that shows best is seen from the first on, three of four shapes of each law from the second.
    """
    sizes: dict[str, tuple[float, float]] = {}
    for candidate in found.candidates:
        effect = candidate.candidate.effect
        simple = effect.kind == "physics" and len(effect.driver) == 1 and not effect.needs_state
        if simple and candidate.usable[:, 0].any():
            easy, most = _unseen(found, candidate)
            other = sizes.get(effect.driver[0], (easy, most))
            sizes[effect.driver[0]] = min(other[0], easy), max(other[1], most)
    return sizes


def _unseen(found: SearchRound, candidate: Prepared) -> tuple[float, float]:
    """Return the changes of mu over the tests from which on an effect is seen in a few and in most of its shapes."""
    needed = found.significance.needed(CLEAR, candidate.name) + candidate.penalty
    usable = candidate.usable[:, 0]
    seen = np.sqrt(candidate.gram[usable, 0, 0])  # whitened, of an amplitude of 1
    change = np.ptp(candidate.candidate.columns[:, usable, 0], axis=0)
    easy, most = (np.sqrt(needed) + NINE_OF_TEN) * np.quantile(change / seen, [EASY, MOST])
    return float(easy), float(most)
