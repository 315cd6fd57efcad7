"""What is missing, as unseen tests show it, and the terms that may be tried for it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...effects.empirical.terms import Term
from ...estimation.campaign.binning import BinnedTests
from ...estimation.noise.noise_floor import Whitener
from ...loads import FloatArray
from .bins import Bins
from .grammar import terms

#: Fewest tests from which terms are chosen.
LEAST_TESTS = 8


@dataclass
class Missing:
    """What is missing, as unseen tests show it."""

    campaign: BinnedTests  #: As it was searched.
    columns: FloatArray  #: The model and what is named, in the bins, shape (m, p).
    y: FloatArray  #: Bin means of mu without the fixed part of the model, shape (m,).
    whiten: Whitener
    fold_of_test: npt.NDArray[np.intp]  #: Shape (tests,).
    #: Mean squared error of each unseen test of the model with what is named, shape (tests,).
    before: FloatArray
    best: float  #: Mean squared error of the best prediction that is known.
    seed: int = 0
    sloping: bool = False  #: Whether the model has no slopes, so that terms keep theirs.

    def grammar(self) -> tuple[Bins, tuple[Term, ...]]:
        """Return the bins with the terms of the grammar that vary in them."""
        bins = Bins(self.campaign, self.columns, self.y)
        return bins, terms(tuple(self.campaign.varied), self.sloping, bins.logarithms)
