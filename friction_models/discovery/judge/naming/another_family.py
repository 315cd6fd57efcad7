"""A power law of the loads in the place of a straight law with effects of several loads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from ....estimation.search.base_law import base_law
from ....estimation.search.scan import Fit
from ....families.power_law import PowerLawFriction
from ....loads import LOAD_NAMES
from ....models.base import FrictionModel
from ..beside_reference import effects_of
from ..confirmation import EXPLAINED
from ..error_budget import fall
from ..unseen_tests import UnseenTests, refitted
from .names import CERTAIN


@dataclass(frozen=True)
class AnotherFamily:
    """Asks whether loads that only multiply, each with a power of its own, predict unseen tests as well as names do.

    A straight law adds its loads. Where friction is a product of their powers, what it leaves looks like an effect of several loads.
    """

    unseen: UnseenTests

    @cached_property
    def power_law(self) -> UnseenTests | None:
        """Unseen tests of a power law; None beside a model that is no straight law."""
        base = self.unseen.base
        straight = isinstance(base.model, FrictionModel) and base.model.family in {"constant", "linear"}
        if not (straight and refitted(base)):
            return None
        campaign, seed = self.unseen.campaign, self.unseen.seed
        return UnseenTests(campaign, base_law(PowerLawFriction(), campaign, seed), seed)

    def does_as_well(self, kept: Sequence[Fit]) -> tuple[str, ...]:
        """Return the names of several loads in whose place it does as well, the others beside it."""
        several = [f for f in kept if len(f.effect.driver) > 1 and {*f.effect.driver} <= {*LOAD_NAMES}]
        several = [f for f in several if not f.effect.needs_state]
        if not several or self.power_law is None:
            return ()
        others = effects_of([f for f in kept if f not in several])
        named, without = self.unseen.errors(effects_of(kept)), self.unseen.errors(others)
        worse, certain = fall(self.power_law.errors(others), named)
        explained = without.rms**2 - named.rms**2
        as_well = certain <= CERTAIN and worse <= EXPLAINED * explained
        return tuple(f.name for f in several) if as_well else ()
