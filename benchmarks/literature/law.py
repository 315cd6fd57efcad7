"""What a friction law is for this package, and the register of all of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import names

Array = NDArray[np.float64]
Parameters = dict[str, float]
State = dict[str, Array]


@dataclass
class Point:
    """Loads of all tests at one sliding distance; every array has the shape (n_tests,).

    Attributes
    ----------
    t, dt : ndarray
        Time and time step [s].
    v : ndarray
        Sliding speed [mm/s].
    T, rise : ndarray
        Contact temperature [degC] and its rise by friction heat [K].
    sigma : ndarray
        Contact pressure [MPa].
    sd, dsd : ndarray
        Sliding distance and its step [mm].
    psi : ndarray
        Surface expansion [-].
    mu : ndarray
        Friction coefficient of the step before [-].
    meta : dict of str to ndarray
        Metadata of the tests, keys without units.
    """

    t: Array
    dt: Array
    v: Array
    T: Array
    rise: Array
    sigma: Array
    sd: Array
    dsd: Array
    psi: Array
    mu: Array
    meta: dict[str, NDArray[Any]]


@dataclass(frozen=True)
class Ranges:
    """Ranges of the loads in a campaign without a hidden effect (2 % and 98 % points)."""

    low: dict[str, float]
    high: dict[str, float]

    def between(self, load: str, share: float) -> float:
        """Value at a share of the range of a load, on a straight scale."""
        return self.low[load] + share * (self.high[load] - self.low[load])

    def between_log(self, load: str, share: float) -> float:
        """Value at a share of the range of a load, on a logarithmic scale."""
        low = max(self.low[load], 1e-6)
        return float(low * (max(self.high[load], 1.0001 * low) / low) ** share)


Shape = Callable[[Point, Parameters, State], Array]
Draw = Callable[[np.random.Generator, Ranges], Parameters]


@dataclass(frozen=True)
class Law:
    """A friction law: ``mu = base + amplitude * shape``.

    Attributes
    ----------
    key : str
        Name of the law in this package.
    equation : str
        Shape in plain text.
    source : str
        Where the form was published.
    accept : tuple of str
        Keys of `names.EFFECT` that are right answers. Empty: outside the catalogue.
    twins : tuple of str
        Keys that the data usually cannot tell from the right ones; counted apart.
    tolerated : tuple of str
        Only outside the catalogue: names that describe a part of the law without being wrong.
    factors : tuple of str
        Set points that must vary in the plan (``v``, ``T``, ``sigma``, ``psi``).
    within_only : bool
        True if averages over a test cannot show the law.
    fault : bool
        True for a fault of sensor or twin; nothing is refined then.
    draw, shape : callable
        Random parameters; the shape at one point.
    scale_free : bool
        False if the shape only makes sense for cold forging loads.
    """

    key: str
    equation: str
    source: str
    accept: tuple[str, ...]
    draw: Draw
    shape: Shape
    factors: tuple[str, ...] = ()
    twins: tuple[str, ...] = ()
    tolerated: tuple[str, ...] = ()
    within_only: bool = False
    fault: bool = False
    scale_free: bool = True

    @property
    def outside(self) -> bool:
        """True if no catalogue name is a right answer."""
        return not self.accept

    def right(self) -> frozenset[str]:
        """Comparable names of the right answers."""
        return names.plain_set(self.accept)

    def near(self) -> frozenset[str]:
        """Comparable names of right answers, twins and tolerated names."""
        return names.plain_set((*self.accept, *self.twins, *self.tolerated))


REGISTER: dict[str, Law] = {}


def add(law: Law) -> Law:
    """Put a law into the register.

    Raises
    ------
    ValueError
        If its key is taken.
    """
    if law.key in REGISTER:
        raise ValueError(f"law {law.key!r} is registered twice")
    REGISTER[law.key] = law
    return law


def get(key: str, among: Mapping[str, Law] = REGISTER) -> Law:
    """Law of a key.

    Raises
    ------
    KeyError
        If there is none; the message lists all keys.
    """
    if key not in among:
        raise KeyError(f"no law {key!r}; there are {sorted(among)}")
    return among[key]
