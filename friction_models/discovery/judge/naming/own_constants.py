"""Names that stand for other values of the model's own constants, which a fit takes as given: the offsets of a power law."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from ....estimation.search.base_law import BaseLaw
from ....estimation.search.scan import Fit
from ..beside_reference import effects_of
from ..error_budget import fall
from ..unseen_tests import ErrorsByTest, UnseenTests
from .names import CERTAIN


class OwnConstants:
    """Tries the model alone, with constants that the tests may choose, in place of names."""

    def __init__(self, unseen: UnseenTests) -> None:
        self.unseen = unseen

    def do_as_well(self, kept: Sequence[Fit]) -> tuple[str, ...]:
        """Return these constants, by their parameters, if unseen tests do not clearly prefer the names to them."""
        constants = tuple(self.unseen.base.constants)
        if not kept or not constants:
            return ()
        _, certain = fall(self._errors, self.unseen.errors(effects_of(kept)))
        return () if certain > CERTAIN else constants

    @cached_property
    def _errors(self) -> ErrorsByTest:
        """Errors of the model with constants of its own choice."""
        base = self.unseen.base
        law = BaseLaw(base.name, np.column_stack([base.columns, *base.constants.values()]), base.offset)
        return UnseenTests(self.unseen.campaign, law, self.unseen.seed).errors()
