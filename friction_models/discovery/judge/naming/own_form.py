"""What the model itself could do, though no fit of it does (the offsets of a power law, the bends of trees), in the place of names."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from ....estimation.search.base_law import BaseLaw
from ....estimation.search.scan import Fit
from ....models.tangent import Beside
from ..beside_reference import effects_of
from ..confirmation import EXPLAINED, OwnFormExplains
from ..error_budget import ErrorShares, fall
from ..unseen_tests import UnseenTests
from .names import CERTAIN


class OwnForm:
    """Tries what the model could do beside (`Tangent.beside`) in the place of names."""

    def __init__(self, unseen: UnseenTests) -> None:
        self.unseen = unseen

    @cached_property
    def wider(self) -> UnseenTests | None:
        """The unseen tests of the model with all that it could do; None where a fit of it does all."""
        beside = self.unseen.base.beside
        return self._with(beside) if beside else None

    def explains(self, shares: ErrorShares, seen: Sequence[Fit]) -> OwnFormExplains | None:
        """Return what it takes of the model, alone or beside one effect, to explain what is missing where nothing is named."""
        if self.wider is None or not shares.missing > 0.0:
            return None
        own = tuple(b.name for b in self.unseen.base.beside)
        enough = shares.best + EXPLAINED * shares.missing
        if self.wider.errors().rms ** 2 <= enough:
            return OwnFormExplains(own)
        beside = {f.name: self.wider.errors([f.effect]).rms ** 2 for f in seen}
        name = min(beside, key=beside.__getitem__, default="")
        return OwnFormExplains(own, name) if name and beside[name] <= enough else None

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
