"""The trained domain of a model: lower and upper limit of each load, and how far a point lies outside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .loads import LOAD_NAMES, LOADS, FloatArray, InputError


@dataclass(frozen=True)
class Domain:
    """A box in load space.

    Attributes
    ----------
    lower, upper : tuple of 5 float
        Limits in the order and units of the contract.
    """

    lower: tuple[float, ...]
    upper: tuple[float, ...]

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
    def of(cls, loads: FloatArray) -> Domain:
        """Return the smallest box around points of shape (n, 5)."""
        return cls(tuple(loads.min(axis=0).tolist()), tuple(loads.max(axis=0).tolist()))

    @classmethod
    def physical(cls) -> Domain:
        """Return the physical limits of the contract: the domain of a law that was never trained."""
        return cls(tuple(q.lower for q in LOADS), tuple(q.upper for q in LOADS))

    @classmethod
    def from_dict(cls, content: Mapping[str, Sequence[float]]) -> Domain:
        """Build from ``{load: [lower, upper]}``."""
        try:
            pairs = [(float(content[n][0]), float(content[n][1])) for n in LOAD_NAMES]
        except (KeyError, IndexError, TypeError, ValueError):
            raise InputError(
                f"domain: {content!r:.80} is not a domain; allowed: [lower, upper] for each of {LOAD_NAMES}"
            ) from None
        return cls(tuple(p[0] for p in pairs), tuple(p[1] for p in pairs))

    def to_dict(self) -> dict[str, Any]:
        """Return ``{load: [lower, upper]}``."""
        return {n: [low, high] for n, low, high in zip(LOAD_NAMES, self.lower, self.upper)}

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
        """Return how far points lie outside, relative to the range: the largest exceedance of any load.

        Parameters
        ----------
        loads : array_like, shape (n, 5)

        Returns
        -------
        ndarray, shape (n,)
            0 inside; 1 means one whole range beyond a limit.
        """
        points = np.atleast_2d(np.asarray(loads, dtype=np.float64))
        outside = np.maximum(np.array(self.lower) - points, points - np.array(self.upper))
        return np.maximum(outside / self.scale, 0.0).max(axis=1)

    def contains(self, loads: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Return which points of shape (n, 5) lie inside."""
        return self.distance(loads) <= 0.0

    def clamp(self, loads: npt.ArrayLike) -> FloatArray:
        """Return points of shape (n, 5), moved to the nearest point of the box."""
        return np.clip(np.asarray(loads, dtype=np.float64), self.lower, self.upper)


def known_domain(model: Any) -> Domain | None:
    """Return the trained domain of a model, None where it has none (a constant, an FMU that does not say)."""
    domain = getattr(model, "domain", None)
    if not isinstance(domain, Domain) or domain == Domain.physical():
        return None
    return domain
