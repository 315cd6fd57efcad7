"""Temperatures of a specimen and the plate that slides under it: 3-D half model, plate advected by whole cells.

The frame is fixed to the specimen. Plate material moves along +x; it is carried by exact shifts of
whole cells, so that there is no numerical diffusion along the track. Conduction is split: implicit
sweeps along x and y, then one implicit sweep through the thickness that couples plate, interface and
specimen in a single tridiagonal system. Conductivity and heat capacity may depend on temperature. The
friction power enters at the interface between two halves of the contact resistance; how it is shared
follows from the solution.

Units: mm, N, s, K (1 W/(m K) = 1 N/(s K); 1 W/(m2 K) = 1e-3 N/(mm s K)).
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from friction_models.loads import FloatArray

from .conduction_kernels import interface_means, properties, settle, shift_plate, sweep_across, sweep_depth
from .thermal_settings import ThermalBody, ThermalSettings

__all__ = ["ContactTemperature", "SlidingContact", "ThermalBody", "ThermalSettings", "layers"]


class ContactTemperature(NamedTuple):
    """Area-weighted means over the contact and the maximum [degC].

    `mean` is the mean of both surfaces, `film` that of the middle of the film between them. All friction heat q
    is released there, and each half of the film has the resistance 1 / (2 h). With what flows into both
    bodies, 2 h (film - plate) + 2 h (film - specimen) = q, it follows that film = mean + q / (4 h). Heat that is
    released evenly through the film would lift its middle by half as much. With another `friction_heat_share` it is the
    place in the film where the heat is released.
    """

    mean: float
    maximum: float
    plate: float
    specimen: float
    film: float


class SlidingContact:
    """A round (or band-shaped) contact between a specimen and a sliding plate.

    - `radius`: contact radius [mm]; half the length of the band when `band`.
    - `height`: height of the specimen [mm]; its far end touches the punch.
    - `speed`: typical sliding speed [mm/s]; only sets how much plate around the contact is modelled.
    - `plate_temperature`, `specimen_temperature`, `punch_temperature`: start temperatures [degC]; fresh plate
      enters at the plate's.
    - `pressure`: relative contact pressure over the radius; any scale. Uniform by default.
    - `band`: two-dimensional contact, infinitely long across the sliding direction.
    - `margin`: plate modelled around the contact [mm]; from the speed by default.
    """

    def __init__(
        self,
        radius: float,
        height: float = 8.0,
        *,
        speed: float = 100.0,
        plate_temperature: float = 20.0,
        specimen_temperature: float = 20.0,
        punch_temperature: float = 20.0,
        pressure: Callable[[FloatArray], FloatArray] | None = None,
        settings: ThermalSettings | None = None,
        band: bool = False,
        margin: float | None = None,
    ) -> None:
        self.settings = settings = settings or ThermalSettings()
        self.radius, self.height = float(radius), float(height)
        self.plate_temperature = float(plate_temperature)
        self.punch_temperature = float(punch_temperature)
        self.cell = dx = 2.0 * radius / settings.cells
        if margin is None:
            # Heat diffuses against the motion over a few times diffusivity / speed.
            diffusivity = settings.plate.diffusivity(self.plate_temperature)
            margin = float(np.clip(3.0 * diffusivity / max(speed, 1e-9), 2.0 * dx, radius))
        before = round(margin / dx)
        after = max(before, 4) if margin > 0 else 0
        index = np.arange(settings.cells + before + after, dtype=np.float64) - before
        x: FloatArray = np.asarray((index + 0.5) * dx - radius)
        widths = np.array([1.0]) if band else _half_width(radius, settings.cells, margin)
        y_edges: FloatArray = np.concatenate([np.zeros(1), np.cumsum(widths)])
        fraction = _covered(x, dx, y_edges, radius, band)
        self._dy = widths
        self._fraction = fraction
        self._plate_layers = layers(settings.surface_layer, settings.growth, settings.depth)
        self._specimen_layers = layers(settings.surface_layer, settings.growth, self.height)
        shape = fraction.shape
        self._plate = np.full((*shape, len(self._plate_layers)), self.plate_temperature)
        self._specimen = np.full((*shape, len(self._specimen_layers)), float(specimen_temperature))
        cell_area = dx * widths[None, :] * fraction  # of the half model; a band is 1 mm wide
        mid = 0.5 * (y_edges[1:] + y_edges[:-1])
        distance = np.sqrt(x[:, None] ** 2 + (0.0 if band else mid[None, :] ** 2))
        weight = np.ones(shape) if pressure is None else np.asarray(pressure(np.minimum(distance, radius)))
        weight = np.where(fraction > 0, np.maximum(weight, 0.0), 0.0)
        self._full = np.ones(shape)
        #: Contact area on the grid [mm2]; per mm of width for a band.
        self.area = float(cell_area.sum()) * (1.0 if band else 2.0)
        # Power density of each contact cell for 1 N mm/s of friction power in the whole contact.
        self._share = weight / (np.sum(weight * cell_area) * (1.0 if band else 2.0))
        self._weights = cell_area / cell_area.sum()
        self._offset = 0.0
        self.contact = self._measure(0.0)

    def advance(self, dt: float, distance: float, power: float) -> ContactTemperature:
        """Slide on for `dt` seconds over `distance` mm with a friction power [N mm/s]; return the contact.

        Steps longer than half a cell are divided; the plate shifts by whole cells when it is due.
        """
        parts = max(1, int(np.ceil(2.0 * distance / self.cell - 1e-9)))
        for _ in range(parts):
            self._step(dt / parts, distance / parts, power)
        return self.contact

    def heat_content(self, reference: float) -> float:
        """Return the heat in plate and specimen above a uniform temperature [N mm]; both halves."""
        s = self.settings
        cell = (self.cell * self._dy)[None, :, None]
        plate = cell * self._plate_layers * s.plate.heat(reference, self._plate)
        covered = cell * self._fraction[:, :, None]
        specimen = covered * self._specimen_layers * s.specimen.heat(reference, self._specimen)
        return float(plate.sum() + specimen.sum()) * (1.0 if self._dy.size == 1 else 2.0)

    def copy(self) -> SlidingContact:
        """Return an independent copy of the state (arrays that never change are shared)."""
        other = copy.copy(self)
        other._plate, other._specimen = self._plate.copy(), self._specimen.copy()
        return other

    def _step(self, dt: float, distance: float, power: float) -> None:
        # The lattice runs from half a cell behind its true place to half a cell ahead of it.
        self._offset += distance / self.cell
        if self._offset > 0.5:
            shift_plate(self._plate, self.plate_temperature)
            self._offset -= 1.0
        s, heat = self.settings, self._share * power
        bodies = ((self._plate, self._full, s.plate), (self._specimen, self._fraction, s.specimen))
        found = []
        for field, share, body in bodies:
            k, c = np.empty_like(field), np.empty_like(field)
            properties(field, body.table, k, c)
            found.append((k, c, field if body.keeps_capacity else field.copy()))
            sweep_across(field, share, k, c, self.cell, self._dy, dt)
        (k_p, c_p, _), (k_s, c_s, _) = found
        sweep_depth(
            self._plate,
            self._specimen,
            self._fraction,
            heat,
            self._plate_layers,
            self._specimen_layers,
            k_p,
            c_p,
            k_s,
            c_s,
            dt,
            s.heat_transfer,
            s.friction_heat_share,
            self.punch_temperature,
        )
        for (field, _, body), (_, c, before) in zip(bodies, found):
            if not body.keeps_capacity:
                settle(field, before, body.table, c)
        self.contact = self._measure(power)

    def _measure(self, power: float) -> ContactTemperature:
        s, share = self.settings, self.settings.friction_heat_share
        plate, specimen, top = interface_means(
            self._plate,
            self._specimen,
            self._weights,
            self._share * power,
            self._offset,
            self._plate_layers[0],
            self._specimen_layers[0],
            s.plate.table,
            s.specimen.table,
            share / s.heat_transfer,
            (1.0 - share) / s.heat_transfer,
        )
        mean = 0.5 * (plate + specimen)
        drop = share * (1.0 - share) * power / self.area / s.heat_transfer
        film = (1.0 - share) * plate + share * specimen + drop
        return ContactTemperature(mean, top, plate, specimen, film)


def layers(first: float, growth: float, depth: float) -> FloatArray:
    """Return layer thicknesses [mm] from `first`, growing by `growth`, that add up to `depth`."""
    count = max(2, int(np.ceil(np.log1p(depth * (growth - 1.0) / first) / np.log(growth))))
    thickness = first * growth ** np.arange(count)
    # The surface keeps its resolution; the deep layers take up what is left over.
    rest = depth - thickness.sum()
    stretch = np.linspace(0.0, 1.0, count) * thickness
    return np.asarray(thickness + rest * stretch / stretch.sum())


def _half_width(radius: float, cells: int, margin: float) -> FloatArray:
    """Widths of the cells from the symmetry plane outwards: uniform over the contact, growing outside."""
    dx = 2.0 * radius / cells
    widths = [dx] * int(np.ceil(0.5 * cells))
    outside = 0.0
    while outside < margin - 1e-9:
        widths.append(dx * 1.3 ** (1 + len(widths) - int(np.ceil(0.5 * cells))))
        outside += widths[-1]
    return np.array(widths)


def _covered(x: FloatArray, dx: float, y_edges: FloatArray, radius: float, band: bool) -> FloatArray:
    """Return the covered share of each cell, from 8 x 8 sample points."""
    sub = (np.arange(8) + 0.5) / 8.0
    xs = (x[:, None] + (sub - 0.5)[None, :] * dx).ravel()
    if band:
        inside = (np.abs(xs) < radius).astype(float)
        return inside.reshape(len(x), 8).mean(axis=1)[:, None]
    ys = (y_edges[:-1, None] + sub[None, :] * np.diff(y_edges)[:, None]).ravel()
    inside = (xs[:, None] ** 2 + ys[None, :] ** 2 < radius**2).astype(float)
    return np.asarray(inside.reshape(len(x), 8, len(y_edges) - 1, 8).mean(axis=(1, 3)))
