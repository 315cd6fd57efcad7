"""Inputs of friction FMUs for contact points that carry no pressure.

A point of the workpiece that has not touched a tool yet has neither pressure nor sliding velocity. A law such as mu = a p^-n
has no value there, although nothing depends on it. The friction FMUs of this project move such loads to the border of their
trained domain. FMUs made elsewhere get ordinary loads instead.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from fmus.runtime.ports import Port
from friction_models.loads import LOAD_NAMES, MU, FloatArray

from .setup.wiring import Link

#: Loads for points without contact: an ordinary pressure [MPa], and a velocity [mm/s] that is small enough for the sliding
#: distance not to grow, and large enough for powers and logarithms to be finite.
STAND_IN = {"sigma_n": 500.0, "v_rel": 1e-3}
_Rows = npt.NDArray[np.intp]


@dataclass
class PointsWithoutPressure:
    """Finds the points of a friction component that carry no pressure, and replaces their loads."""

    source: str  # the component that computes the contact
    rows: _Rows = field(repr=False)  # places of the pressure among its outputs, shape (points,)

    @classmethod
    def of(
        cls, name: str, links: Iterable[Link], outputs: Mapping[str, Port]
    ) -> PointsWithoutPressure | None:
        """Find the pressure behind the loads of component `name`; None where no component gives one out."""
        for link in links:
            if link.target != name or _base(link.sources[0].name) not in LOAD_NAMES:
                continue
            port = outputs[link.source]
            rows = [i for i, v in enumerate(port.variables) if _base(v.name) == "sigma_n"]
            if len(rows) == len(link.sources):
                return cls(link.source, np.array(rows, dtype=np.intp))
        return None

    def points(self, outputs: Mapping[str, Port]) -> npt.NDArray[np.bool_]:
        """Return which points have no pressure, shape (points,)."""
        idle: npt.NDArray[np.bool_] = outputs[self.source].values[self.rows] <= 0.0
        return idle

    def patch(self, name: str, link: Link, first: int) -> Patch | None:
        """Return what changes the values of a connection from or to component `name`; None for those left alone.

        `first` is the place of its first value among those of the transfer.
        """
        if len(link.sources) != len(self.rows):
            return None
        places = np.arange(first, first + len(self.rows), dtype=np.intp)
        load = _base(link.sources[0].name)
        if link.target == name and link.source == self.source and load in STAND_IN:
            return Patch(self, places, STAND_IN[load] * link.factor + link.offset)
        if link.source == name and _base(link.targets[0].name) == MU.name:
            return Patch(self, places, None)
        return None


@dataclass
class Patch:
    """Replaces the values of one connection at points without contact: by another load, or a mu that is not a number by 0."""

    idle: PointsWithoutPressure
    places: _Rows
    value: float | None

    def apply(self, values: FloatArray, outputs: Mapping[str, Port]) -> None:
        """Change `values` in place."""
        places = self.places[self.idle.points(outputs)]
        if self.value is not None:
            values[places] = self.value
        else:
            values[places] = np.where(np.isfinite(values[places]), values[places], 0.0)


def _base(name: str) -> str:
    return name.partition("[")[0]
