"""Contact of a specimen and a plate that slides below it: both bodies joined by a film, step by step.

Units: mm, N, s, K (1 W/(m K) = 1 N/(s K); 1 W/(m2 K) = 1e-3 N/(mm s K)).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from friction_models.loads import FloatArray

from .bodies import Kirchhoff, LabHeat
from .cylinder import Cylinder
from .half_space import HalfSpace

#: Steps of the iteration for the flux into the plate, at most, and the error at which it ends [K].
_ITERATIONS, _CLOSE = 60, 2e-3


class ContactMeans(NamedTuple):
    """Means over the contact [degC]: of both surfaces, of the plate's and of the specimen's, and the hottest place."""

    mean: float
    plate: float
    specimen: float
    maximum: float


class RubbedContact:
    """A round contact; the plate under it is a half space, the specimen a cylinder of the contact's radius.

    - `radius`, `height`: of contact and specimen [mm]; temperatures at the start [degC].
    - `pressure`: relative contact pressure over the radius [mm]; any scale.

    At rest a hot specimen warms the plate, and both effusivities say how far:

    >>> contact = RubbedContact(8.0, 10.0, 20.0, 120.0, 120.0, np.ones_like, LabHeat())
    >>> bool(20.0 < contact.advance(0.1, 0.0, 0.0).plate < contact.means.specimen < 120.0)
    True
    """

    def __init__(
        self,
        radius: float,
        height: float,
        T_plate: float,
        T_specimen: float,
        T_punch: float,
        pressure: Callable[[FloatArray], FloatArray],
        heat: LabHeat,
    ) -> None:
        on, self.size = _disc(radius, heat.cells)
        size, (columns, rows) = self.size, on.shape
        self._on = on
        x = ((np.arange(columns)[:, None] + 0.5 - 0.5 * columns) * size + np.zeros(rows))[on]
        y = ((np.arange(rows) + 0.5) * size + np.zeros((columns, 1)))[on]
        relative = np.maximum(np.asarray(pressure(np.minimum(np.hypot(x, y), radius))), 0.0)
        #: Friction heat of the cells [N/(mm s)] for 1 N mm/s in the whole contact.
        self._share = relative / (2.0 * float(relative.sum()) * size**2)
        self._h = h = heat.heat_transfer
        self._to_plate = Kirchhoff(heat.plate, T_plate)
        self._to_specimen = Kirchhoff(heat.specimen, T_punch)
        self._plate = HalfSpace(size, columns, rows, self._to_plate)
        self._specimen = Cylinder(x, y, radius, height, self._to_specimen, h, T_specimen)
        self._flux = np.zeros(int(on.sum()))
        mean = 0.5 * (T_plate + T_specimen)
        self.means = ContactMeans(mean, T_plate, T_specimen, mean)

    def warm(self, rise: float) -> None:
        """Raise the temperature of the whole specimen [K], by heat that is released in it."""
        self._specimen.warm(rise)

    def advance(self, dt: float, distance: float, power: float) -> ContactMeans:
        """Slide on for `dt` [s] over `distance` [mm] with a friction power [N mm/s]; return the contact."""
        on, h, heat = self._on, self._h, self._share * power
        left_p = self._plate.begin(dt, distance)[on]
        left_s = self._specimen.begin(dt)
        # Were every cell a bar of its own, this would solve at once; heat that goes sideways needs a few more.
        bar = 2.0 * math.sqrt(dt / math.pi) / self._to_plate.effusivity + self._specimen.stiffest
        flux = self._flux
        whole = np.zeros(on.shape)
        for _ in range(_ITERATIONS):
            whole[on] = flux
            T_p = self._to_plate.temperature(left_p + self._plate.respond(whole)[on])
            T_s = self._to_specimen.temperature(left_s + self._specimen.respond(heat - flux))
            # Half of the heat of the film goes either way, and what flows from body to body.
            missing = 0.5 * heat + h * (T_s - T_p) - flux
            flux = flux + missing / (1.0 + h * bar)
            if float(np.abs(missing).max()) < _CLOSE * h:
                break
        whole = np.zeros(on.shape)
        whole[on] = flux
        self._plate.end(whole)
        self._specimen.end(heat - flux)
        self._flux = flux
        both = 0.5 * (T_p + T_s)
        plate, specimen = float(T_p.mean()), float(T_s.mean())
        self.means = ContactMeans(0.5 * (plate + specimen), plate, specimen, float(both.max()))
        return self.means


def _disc(radius: float, cells: int) -> tuple[npt.NDArray[np.bool_], float]:
    """Return which square cells stand for half of a disc, shape (columns, rows), and their size [mm].

    Cells count whole or not at all, and together they have the area of the disc.
    """
    x = np.arange(cells)[:, None] + 0.5 - 0.5 * cells
    y = np.arange((cells + 1) // 2)[None, :] + 0.5
    on = np.hypot(x, y) <= 0.5 * cells
    return on, radius * math.sqrt(0.5 * math.pi / int(on.sum()))
