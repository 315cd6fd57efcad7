"""Constant offset, or factor, between measurements and a model that is not refitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.special import stdtr

from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.search.importance import LEAST_SHARE, error_share
from ...estimation.search.scan import Fit
from ...estimation.search.search_round import SearchRound
from ...estimation.search.structure import StructurePlace
from ...loads import LOAD_NAMES, FloatArray
from .verdict import STRUCTURE_LEVEL


@dataclass(frozen=True)
class LevelOffset:
    """How far the measurements lie above a model everywhere, whatever the effects do that are missing from it."""

    #: Least distance over the tested loads (generalised least squares) and its standard error, in mu; 0 where an effect makes
    #: the model right at some of them.
    value: float = 0.0
    error: float = 0.0
    #: Two-sided, of Student's t with the tests that are left to show the scatter between them.
    p_value: float = 1.0
    floor: float = 0.0  #: Noise floor of one average.
    factor: float | None = (
        None  #: Measured over modelled mu, where tests prefer it to an offset; `error` then is its own.
    )
    left: FloatArray = field(default_factory=lambda: np.zeros(1))  #: What it is in the bins, shape (m,).

    @property
    def off(self) -> bool:
        """Whether it is significant, and large enough beside the noise floor to matter."""
        return self.p_value < STRUCTURE_LEVEL and error_share(self.value, self.floor) > LEAST_SHARE

    def entry(self, campaign: BinnedTests) -> StructurePlace:
        """Return the offset as structure that is left: over the whole tested range, driven by no load."""
        shape = f"constant offset {self.value:+.4f}" if self.factor is None else f"factor {self.factor:.3g}"
        return {
            "variables": [],
            "region": campaign.ranges(LOAD_NAMES),
            "shape": shape,
            "share": error_share(self.value, self.floor),
        }

    def text(self, model: str) -> str:
        """Return a sentence about it."""
        if self.factor is not None:
            return (
                f"measured friction is {self.factor:.3g} +- {self.error:.2g} times that of {model} everywhere: a factor and no effect of a load; fit the model "
                "anew, or check the gain of the force"
            )
        side = "below" if self.value > 0 else "above"
        return (
            f"{model} lies at least {abs(self.value):.4f} +- {self.error:.4f} {side} the measurements everywhere: a level and no "
            "effect of a load; fit the model's level, or check zero and gain of the force"
        )


def level_of(found: SearchRound, chosen: Sequence[Fit], scaled: bool = False) -> LevelOffset:
    """Return the level beside a fixed model, with the effects found and their amplitudes fitted at the same time.

    The first column of the base is the constant; where the model is `scaled`, what it predicts is the second one, and takes its place.
    """
    if not found.floor.known:
        return LevelOffset(floor=found.floor.total)
    columns = found.columns_with(chosen)[:, int(scaled) :]
    white = found.whiten(columns)
    inverse = np.linalg.pinv(white.T @ white, rcond=1e-12)
    fitted = inverse @ (white.T @ found.whiten(found.y))
    error = float(np.sqrt(inverse[0, 0]))
    # where an effect is zero is a matter of its formula: the level, or factor, is what remains wherever it is least
    unit = columns[:, 0]
    known = unit != 0.0
    everywhere = (columns[known] @ fitted) / unit[known]
    size = float(np.clip(0.0, everywhere.min(), everywhere.max()))
    left = unit * size
    p = float(2.0 * stdtr(found.freedom.between, -abs(size) / max(error, 1e-300)))
    factor = 1.0 + size if scaled else None
    return LevelOffset(float(np.mean(left)), error, p, found.floor.total, factor, left)
