"""Parameters of an effect: linear strengths with a physical sign, and shape parameters with bounds and scan values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..loads import QUANTITIES, FloatArray

#: What spans the data have: quantity -> (low, high); loads and derived quantities (`work`, `flash`). The ``range of`` a load also holds
#: its widest untested parts.
Spans = Mapping[str, tuple[float, ...]]
#: A shape parameter that is closer to a bound than this share of its range is at the bound.
AT_BOUND = 1e-6
#: Larger logarithms are no numbers.
LARGEST_LOG = 700.0
_ABSOLUTE_ZERO = QUANTITIES["T"].lower


@dataclass(frozen=True)
class Amplitude:
    """A linear strength of an effect.

    Attributes
    ----------
    name, unit, meaning : str
        Identifier, unit, one phrase.
    sign : {-1, 0, 1}
        Physical sign; 0 when both directions are physical.
    start : float
        A typical value for cold forging, used before any fit.

    Examples
    --------
    >>> from friction_models.effects import Amplitude, Stribeck
    >>> Amplitude("k_g", "1", "rise over 10 mm", sign=1, start=0.02).start
    0.02
    >>> [a.name for a in Stribeck.amplitudes]
    ['delta_s']
    """

    name: str
    unit: str
    meaning: str
    sign: Literal[-1, 0, 1]
    start: float


@dataclass(frozen=True)
class ShapeParameter:
    """A nonlinear shape parameter of an effect.

    Attributes
    ----------
    name, unit, meaning : str
        Identifier, unit, one phrase.
    lower, upper : float
        Physical bounds.
    start : float
        A typical value for cold forging.
    values : tuple of float
        Scan values, when they do not follow the data.
    follows : str or None
        Quantity whose span in the data sets the scan values, from ``span[0] * low`` to ``span[1] * high``.
    span : tuple of float
        Factors on the low and the high end.
    points : int
        Number of scan values; 1 means that the parameter is a scale taken from the data, not fitted.
    log : bool
        Geometric instead of even spacing.
    earlier : float or None
        What it is in models that were saved before the law had this parameter.

    Examples
    --------
    A speed that is tried from half the lowest to twice the highest speed of the data:

    >>> from friction_models.effects import ShapeParameter
    >>> v_s = ShapeParameter("v_s", "mm/s", "Stribeck speed", 1e-3, 1e4, 30.0, follows="v_rel", span=(0.5, 2), points=3)
    >>> v_s.grid({"v_rel": (20.0, 500.0)}).round(6).tolist()
    [10.0, 100.0, 1000.0]
    >>> v_s.fitted
    True
    """

    name: str
    unit: str
    meaning: str
    lower: float
    upper: float
    start: float
    values: tuple[float, ...] = ()
    follows: str | None = None
    span: tuple[float, float] = (1.0, 1.0)
    points: int = 8
    log: bool = True
    earlier: float | None = None

    @property
    def logarithmic(self) -> bool:
        """Whether fits, steps and intervals are on a logarithmic scale: what is positive; temperatures from absolute zero on."""
        return self.lower > self._zero

    def inner(self, value: float) -> float:
        """Return a value on the scale on which it is fitted."""
        return float(np.log(value - self._zero)) if self.logarithmic else value

    def outer(self, value: float) -> float:
        """Return what a value on the scale of the fit is, within the bounds."""
        free = float(np.exp(min(value, LARGEST_LOG))) + self._zero if self.logarithmic else value
        return min(max(free, self.lower), self.upper)

    def at_bound(self, value: float, bounds: tuple[float, float] | None = None) -> bool:
        """Return whether a value is at one of the physical bounds, or of others."""
        low, high = (self.inner(v) for v in bounds or (self.lower, self.upper))
        own = self.inner(value)
        return min(own - low, high - own) <= AT_BOUND * (high - low)

    @property
    def _zero(self) -> float:
        return _ABSOLUTE_ZERO if self.unit == "degC" else 0.0

    @property
    def fitted(self) -> bool:
        """Whether the parameter is fitted (and costs a degree of freedom) or only sets a scale."""
        return len(self.values) > 1 or (not self.values and self.points > 1)

    def grid(self, spans: Spans) -> FloatArray:
        """Return the scan values for data with these spans."""
        if self.values or self.follows is None:
            return np.array(self.values or (self.start,))
        low, high, *_ = spans.get(self.follows, (self.start, self.start))
        a, b = self.span[0] * low, self.span[1] * high
        if self.points == 1:
            return np.clip(
                np.array([np.sqrt(a * b) if self.log and a > 0 else 0.5 * (a + b)]), self.lower, self.upper
            )
        a, b = max(a, self.lower), min(b, self.upper)
        if not b > a:
            a, b = max(0.5 * b, self.lower), b
        if not b > a:
            return np.clip(np.array([b]), self.lower, self.upper)
        if self.log:
            return np.geomspace(max(a, 1e-6 * b), b, self.points)
        return np.linspace(a, b, self.points)
