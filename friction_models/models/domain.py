"""The trained domain of a model: lower and upper limit of each load, and how far a point lies outside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..common import InputError
from ..loads import LOAD_NAMES, LOADS, FloatArray, TriboLoads


@dataclass(frozen=True)
class Domain:
    """A box in load space.

    Attributes
    ----------
    lower, upper : tuple of 5 float
        Limits in the order and units of the contract; the physical ones for a load in `absent`.
    absent: tuple of str
        Loads that were not measured: they have no domain, and no influence on the model.

    Examples
    --------
    >>> from friction_models import Domain, TriboLoads
    >>> domain = Domain.of(TriboLoads.from_array([[0, 20, 500, 0, 1], [100, 120, 1500, 10, 1.5]]))
    >>> domain.to_dict()["T"]
    [20.0, 120.0]

    At 150 mm/s half a range lies between the speed and the trained ones:

    >>> domain.distance([[50, 70, 1000, 5, 1.2], [150, 70, 1000, 5, 1.2]]).tolist()
    [0.0, 0.5]
    >>> domain.clamp([[150, 70, 1000, 5, 1.2]]).tolist()
    [[100.0, 70.0, 1000.0, 5.0, 1.2]]
    """

    lower: tuple[float, ...]
    upper: tuple[float, ...]
    absent: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if len(self.lower) != len(LOADS) or len(self.upper) != len(LOADS):
            raise InputError(f"domain: {len(self.lower)} limits, allowed: one for each of {LOAD_NAMES}")
        for quantity, low, high in zip(LOADS, self.lower, self.upper):
            if not quantity.lower <= low <= high <= quantity.upper:
                raise InputError(
                    f"domain: {quantity.name!r} from {low!r} to {high!r} is no range within "
                    f"{quantity.lower:g} to {quantity.upper:g} {quantity.unit}"
                )

    @classmethod
    def of(cls, loads: TriboLoads) -> Domain:
        """Return the smallest box around points."""
        array = loads.as_array()
        box = cls(tuple(array.min(axis=0).tolist()), tuple(array.max(axis=0).tolist()))
        return box.without(loads.absent)

    @classmethod
    def physical(cls) -> Domain:
        """Return the physical limits of the contract: the domain of a law that was never trained."""
        return cls(tuple(q.lower for q in LOADS), tuple(q.upper for q in LOADS))

    @classmethod
    def from_dict(cls, content: Mapping[str, Sequence[float] | None]) -> Domain:
        """Build from ``{load: [lower, upper]}``; None for a load that was not measured."""
        try:
            given = [(q, content[q.name]) for q in LOADS]
            pairs = [(q.lower, q.upper) if p is None else (float(p[0]), float(p[1])) for q, p in given]
        except (KeyError, IndexError, TypeError, ValueError):
            raise InputError(
                f"domain: {content!r:.80} is not a domain; allowed: [lower, upper] (or null, not measured) for each of {LOAD_NAMES}"
            ) from None
        return cls(tuple(p[0] for p in pairs), tuple(p[1] for p in pairs)).without(
            [q.name for q, p in given if p is None]
        )

    def to_dict(self) -> dict[str, list[float] | None]:
        """Return ``{load: [lower, upper]}``; None for a load that was not measured."""
        limits = zip(LOAD_NAMES, self.lower, self.upper)
        return {n: None if n in self.absent else [low, high] for n, low, high in limits}

    def without(self, absent: Sequence[str]) -> Domain:
        """Return the domain of the loads that are not in `absent` either."""
        names = tuple(n for n in LOAD_NAMES if n in self.absent or n in absent)
        low = tuple(q.lower if q.name in names else a for q, a in zip(LOADS, self.lower))
        high = tuple(q.upper if q.name in names else b for q, b in zip(LOADS, self.upper))
        return Domain(low, high, names)

    @property
    def measured(self) -> tuple[str, ...]:
        """The loads that were measured."""
        return tuple(n for n in LOAD_NAMES if n not in self.absent)

    @property
    def scale(self) -> FloatArray:
        """Width of each range; for a load that never varied its size, at least 1."""
        low, high = np.array(self.lower), np.array(self.upper)
        return np.where(high > low, high - low, np.maximum(np.abs(high), 1.0))

    @property
    def centre(self) -> FloatArray:
        """Middle of the box, shape (5,)."""
        return 0.5 * (np.array(self.lower) + np.array(self.upper))

    def distance(self, loads: npt.ArrayLike) -> FloatArray:
        """Return how far points of shape (n, 5) lie outside, relative to the range: the largest exceedance of any load.

        The shape is (n,). 0 is inside; 1 means one whole range beyond a limit.
        """
        points = np.atleast_2d(np.asarray(loads, dtype=np.float64))
        outside = np.maximum(np.array(self.lower) - points, points - np.array(self.upper))
        outside[:, [n in self.absent for n in LOAD_NAMES]] = 0.0
        return np.maximum(outside / self.scale, 0.0).max(axis=1)

    def contains(self, loads: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Return which points of shape (n, 5) lie inside."""
        return self.distance(loads) <= 0.0

    def clamp(self, loads: npt.ArrayLike) -> FloatArray:
        """Return points of shape (n, 5), moved to the nearest point of the box."""
        return np.clip(np.asarray(loads, dtype=np.float64), self.lower, self.upper)


def known_domain(model: Any) -> Domain | None:
    """Return the trained domain of a model, None where it has none (a constant, an FMU that does not say).

    Examples
    --------
    >>> from friction_models import ConstantFriction
    >>> known_domain(ConstantFriction(0.08)) is None
    True
    """
    domain = getattr(model, "domain", None)
    if not isinstance(domain, Domain) or domain == Domain.physical():
        return None
    return domain
