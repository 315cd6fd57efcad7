"""Standard uncertainties of pressure, surface expansion and contact temperature at every point of a test."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from forming.fe.heat.properties import scaled
from friction_models.common import InputError
from friction_models.common.ranges import is_number
from friction_models.loads import FloatArray

from .heat.thermal_settings import ThermalBody, ThermalSettings
from .upsetting import ContactAtPoints, ContactState, UpsettingRun, fills

#: Plate cells across the contact of the runs whose differences count.
COARSE = 12
#: Change of the contact area whose effect on the temperature is computed, relative.
AREA_STEP = 0.02
#: Change of the specimen's temperature when it begins to slide whose effect is computed [K].
START_STEP = 5.0


@dataclass(frozen=True)
class GivenUncertainty:
    """Standard uncertainties of what the twin is given, and of its own numbers.

    Raises InputError: a value that is negative or above 1.

    Examples
    --------
    >>> GivenUncertainty(flow_stress=0.05).flow_stress
    0.05
    """

    #: Flow stress, relative.
    flow_stress: float = 0.02
    #: Friction while upsetting.
    upsetting_mu: float = 0.02
    #: Diameters of specimen and bore [mm].
    diameter: float = 0.02
    #: Conductivity and heat capacity of each body, relative.
    heat_data: float = 0.05
    #: Natural logarithm of the interface heat transfer coefficient: anything between half and twice is alike
    #: likely, ln 2 / sqrt(3).
    heat_transfer: float = 0.4
    #: Mesh of the upsetting run: relative, of pressure and expansion.
    mesh: float = 0.008
    #: The same where the side of the specimen folds onto the plate: of the expansion beyond 1, relative.
    fold: float = 0.04
    #: Grid of the sliding model: relative, of the rise above the plate.
    grid: float = 0.006

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (is_number(value) and 0.0 <= value <= 1.0):
                raise InputError(f"uncertainty of {name} = {value!r:.60}; allowed: 0 to 1")


def other_dimensions(
    upsetting: UpsettingRun, F_n: FloatArray, upset_to: float, by: float
) -> list[ContactAtPoints]:
    """Return contacts of a specimen whose diameter is larger by `by` [mm], and of a bore that is.

    A filled bore gives the area, and a larger specimen expands less in it. Otherwise a specimen that is s times as
    large under s^2 times the force has s^2 times the contact.
    """
    specimen, bore = upsetting.case.punch.specimen_diameter, upsetting.case.punch.bore_diameter
    usual = upsetting.at_points(F_n, upset_to)
    s2 = (1.0 + by / specimen) ** 2
    if bore is not None and fills(2.0 * math.sqrt(usual.area[-1] / math.pi), upsetting.case.punch):
        b2 = (1.0 + by / bore) ** 2
        return [usual._replace(psi=usual.psi / s2), usual._replace(area=usual.area * b2, psi=usual.psi * b2)]
    wider = upsetting.at_points(F_n / s2, upset_to / s2)
    return [wider._replace(area=wider.area * s2)]


def other_friction(
    read: Callable[[float], ContactAtPoints], upsetting_mu: float, given: GivenUncertainty
) -> list[ContactAtPoints]:
    """Return the contact after another friction while upsetting: more, or less where a fold does not get through with more."""
    by = given.upsetting_mu
    for mu in (upsetting_mu + by, max(upsetting_mu - by, 0.0)):
        with suppress(InputError):
            return [read(mu)]
    return []


def load_uncertainties(
    sigma_n: FloatArray,
    rise: FloatArray,
    contact: ContactAtPoints,
    others: Iterable[ContactAtPoints],
    state: ContactState,
    T0: float,
    heat: ThermalSettings,
    temperature: Callable[[ContactState, ThermalSettings], FloatArray],
    given: GivenUncertainty,
    filled: bool,
) -> dict[str, FloatArray]:
    """Return `u_sigma_n` [MPa], `u_psi` and `u_T` [K] at every point, shape (n,).

    Each cause is changed by its standard uncertainty, and the changes are added as squares. Nearly all of it is
    common to the points of a test.

    - `sigma_n`: as stated [MPa]; `rise`: of the contact temperature above the plate [K]; both of shape (n,).
    - `contact`, `others`: the contact as stated, and after each change of what shapes it.
    - `T0`: temperature of the specimen before it is upset [degC].
    - `filled`: whether the contact fills the bore of the punch.
    - `temperature`: returns the contact temperature at the points for another contact, warmer or wider, or other heat data.
    """
    area, psi = contact.area, contact.psi
    coarse = replace(heat, cells=min(COARSE, heat.cells))
    usual = temperature(state, coarse)

    def change(settings: ThermalSettings, area_factor: float = 1.0, warmer: float = 0.0) -> FloatArray:
        other = replace(
            state,
            area=state.area * area_factor,
            radius=state.radius * math.sqrt(area_factor),
            T_specimen=state.T_specimen + warmer,
        )
        return temperature(other, settings) - usual

    # A grid that is half as fine has the same sensitivities to some percent.
    factor = 1.0 + given.heat_data / math.sqrt(2.0)
    squares_T = (given.grid * rise) ** 2
    film = heat.heat_transfer * math.exp(-given.heat_transfer)
    squares_T += change(replace(coarse, heat_transfer=film)) ** 2
    squares_T += change(replace(coarse, plate=_scaled(heat.plate, factor))) ** 2
    more, specimen = 1.0 + given.heat_data, heat.specimen
    conducting = replace(specimen, conductivity=scaled(specimen.conductivity, more))
    squares_T += change(replace(coarse, specimen=conducting)) ** 2
    # Heat of upsetting warms a specimen of larger capacity less.
    colder = (contact.T_specimen - T0) * (1.0 / more - 1.0)
    holding = replace(specimen, capacity=scaled(specimen.capacity, more))
    squares_T += change(replace(coarse, specimen=holding), warmer=colder) ** 2
    by_area = change(coarse, 1.0 + AREA_STEP) / math.log1p(AREA_STEP)
    squares_sigma, squares_psi = (given.mesh * sigma_n) ** 2, (given.mesh * psi) ** 2
    if not filled:
        squares_psi += (given.fold * (psi - 1.0)) ** 2
    by_start = change(coarse, warmer=START_STEP) / START_STEP
    squares_T += (by_area * given.mesh) ** 2
    for other in others:
        grown = np.log(other.area / area)
        squares_sigma += (sigma_n * grown) ** 2
        squares_psi += (other.psi - psi) ** 2
        # What is upset less slides on a smaller area, which is hotter, but starts colder.
        squares_T += (by_area * grown + by_start * (other.T_specimen - contact.T_specimen)) ** 2
    names = ("u_sigma_n", "u_psi", "u_T")
    return dict(zip(names, map(np.sqrt, (squares_sigma, squares_psi, squares_T))))


def _scaled(body: ThermalBody, factor: float) -> ThermalBody:
    """Return a body of `factor` times the conductivity and capacity: the effusivity counts, which is their mean."""
    return ThermalBody(scaled(body.conductivity, factor), scaled(body.capacity, factor))
