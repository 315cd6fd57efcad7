"""Names that stand for what the model itself could do, though no fit of it does: the offsets of a power law, the bends of trees."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....estimation.search.base_law import BaseLaw
from ....estimation.search.scan import Fit
from ....models.tangent import Beside
from ..beside_reference import effects_of
from ..error_budget import fall
from ..unseen_tests import UnseenTests
from .names import CERTAIN


class OwnForm:
    """Tries what the model could do beside (`Tangent.beside`) in the place of each name."""

    def __init__(self, unseen: UnseenTests) -> None:
        self.unseen = unseen

    def does_as_well(self, kept: Sequence[Fit]) -> dict[str, tuple[str, ...]]:
        """Return the names that unseen tests do not clearly prefer to it, each with what does as well."""
        found = {}
        for fit in kept:
            own = [b for b in self.unseen.base.beside if {*b.loads} <= {*fit.effect.driver}]
            others = effects_of([f for f in kept if f is not fit])
            if (
                own
                and fall(self._with(own).errors(others), self.unseen.errors(effects_of(kept)))[1] <= CERTAIN
            ):
                found[fit.name] = tuple(b.name for b in own)
        return found

    def _with(self, beside: Sequence[Beside]) -> UnseenTests:
        """Return the unseen tests of the model with that."""
        base = self.unseen.base
        # without the model, its columns are fitted: no fit of the model itself does what is beside them
        law = BaseLaw(base.name, np.column_stack([base.columns, *(b.column for b in beside)]), base.offset)
        return UnseenTests(self.unseen.campaign, law, self.unseen.seed)
