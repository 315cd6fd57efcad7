"""Constant offset between measurements and a model that is not refitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from ..estimation.campaign.binning import Campaign
from ..estimation.search.importance import LEAST_SHARE, error_share
from ..estimation.search.scan import Fit
from ..estimation.search.search_round import SearchRound
from ..estimation.search.structure import StructurePlace
from ..loads import LOAD_NAMES
from .verdict import STRUCTURE_LEVEL


@dataclass(frozen=True)
class LevelOffset:
    """Measured minus modelled mu, as far as it does not depend on loads or effects.

    Attributes
    ----------
    value, error : float
        Generalised least squares estimate and its standard error, in mu.
    p_value : float
        Two-sided, of Student's t with the tests that are left to show the scatter between them.
    floor : float
        Noise floor of one average.
    """

    value: float = 0.0
    error: float = 0.0
    p_value: float = 1.0
    floor: float = 0.0

    @property
    def off(self) -> bool:
        """Whether it is significant, and large enough beside the noise floor to matter."""
        return self.p_value < STRUCTURE_LEVEL and error_share(self.value, self.floor) > LEAST_SHARE

    def entry(self, campaign: Campaign) -> StructurePlace:
        """Return the offset as structure that is left: over the whole tested range, driven by no load."""
        region = {}
        for name in LOAD_NAMES:
            if campaign.varies(name):
                values = getattr(campaign.loads, name)
                region[name] = [float(values.min()), float(values.max())]
        return {
            "variables": [],
            "region": region,
            "shape": f"constant offset {self.value:+.4f}",
            "share": error_share(self.value, self.floor),
        }

    def text(self, model: str) -> str:
        """Return a sentence about it."""
        side = "below" if self.value > 0 else "above"
        return (
            f"{model} lies {abs(self.value):.4f} +- {self.error:.4f} {side} the measurements everywhere: a level and no effect of a "
            "load; fit the model's level, or check the zero of the force"
        )


def level_of(found: SearchRound, chosen: Sequence[Fit]) -> LevelOffset:
    """Return the level beside a fixed model, with the effects found fitted at the same time.

    Parameters
    ----------
    found : SearchRound
        Its first column of the base is the constant.
    chosen : sequence of Fit
    """
    if not found.floor.known:
        return LevelOffset(floor=found.floor.total)
    columns = np.column_stack([found.columns, *(f.binned for f in chosen)])
    white = found.whiten(columns)
    inverse = np.linalg.pinv(white.T @ white, rcond=1e-12)
    value = float(inverse[0] @ (white.T @ found.whiten(found.y)))
    error = float(np.sqrt(inverse[0, 0]))
    p = float(2.0 * student.sf(abs(value) / max(error, 1e-300), found.freedom))
    return LevelOffset(value, error, p, found.floor.total)
