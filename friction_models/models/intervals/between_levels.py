"""What is added to a prediction interval between the levels of a plan, where no test measured."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ...common import InputError
from ...common.json_values import JsonObject
from ...expressions.ops import NumpyOps, Ops, Value
from ...expressions.parameters import check_number
from ...loads import LOAD_NAMES
from ...loads.contract import QUANTITIES
from .features import feature

#: Most that is added to half the width of an interval [mu].
MOST_ADDED = 10.0


@dataclass(frozen=True)
class Widening:
    """A gap between two levels of a load, and what is added to half the width of an interval in its middle.

    Examples
    --------
    >>> import numpy as np
    >>> between = Widening("T", 100.0, 200.0, 0.004)
    >>> between.at(NumpyOps(), np.array([50.0, 100.0, 125.0, 150.0, 190.0])).round(4).tolist()
    [0.0, 0.0, 0.002, 0.004, 0.0008]
    """

    load: str
    low: float  #: Levels, in the unit of the load.
    high: float
    extra: float  #: In mu.

    def at(self, x: Ops, column: Value) -> Value:
        """Return what is added at values of the load, with either back end; falls to 0 at both levels."""
        low, high = (float(feature(NumpyOps(), self.load, np.array(v))) for v in (self.low, self.high))
        place = feature(x, self.load, column)
        share = x.minimum(place - low, high - place) * (2.0 / (high - low))
        return x.maximum(share, 0.0) * self.extra

    def to_dict(self) -> JsonObject:
        """Return it as JSON holds it."""
        return asdict(self)

    @classmethod
    def from_dict(cls, content: Any) -> Widening:
        """Build from `to_dict`. Raises InputError: a value is missing, no number, or outside its limits."""
        if not isinstance(content, dict) or content.get("load") not in LOAD_NAMES:
            raise InputError(
                f"interval: between = {content!r:.60}; allowed: load ({', '.join(LOAD_NAMES)}), low, high, extra"
            )
        load = QUANTITIES[content["load"]]
        low, high, extra = (
            check_number("interval", f"between.{key}", content.get(key), *limits)
            for key, limits in (
                ("low", (load.lower, load.upper)),
                ("high", (load.lower, load.upper)),
                ("extra", (0.0, MOST_ADDED)),
            )
        )
        if high <= low:
            raise InputError(f"interval: between.low = {low:g}, high = {high:g}; allowed: low below high")
        return cls(content["load"], low, high, extra)
