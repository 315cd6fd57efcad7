"""The contact: base friction, hidden laws and heating, marched together along the sliding distance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .domains import Domain
from .heat import HeatedContact
from .law import Law, Parameters, Point, State
from .profiles import Profiles

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Base:
    """Friction linear in the five loads, which a linear model can learn.

    Attributes
    ----------
    mu0 : float
        Friction at zero loads.
    slopes : dict of str to float
        Slope of each load, per unit of the load.
    """

    mu0: float
    slopes: dict[str, float]

    def __call__(self, v: Array, T: Array, sigma: Array, sd: Array, psi: Array) -> Array:
        s = self.slopes
        return self.mu0 + s["v"] * v + s["T"] * T + s["sigma"] * sigma + s["sd"] * sd + s["psi"] * psi


def draw_base(domain: Domain, rng: np.random.Generator) -> Base:
    """Random base with slopes of either sign, a few hundredths over each range at most."""
    size = domain.size
    span = {
        "v": domain.v[2],
        "T": 300.0 if domain.size == 1.0 else domain.T[2],
        "sigma": domain.sigma[2],
        "sd": domain.sd_max,
        "psi": domain.psi[2],
    }
    reach = {
        "v": rng.uniform(-0.010, 0.006),
        "T": rng.uniform(-0.008, 0.004),
        "sigma": rng.uniform(-0.015, 0.006),
        "sd": rng.uniform(-0.004, 0.008),
        "psi": rng.uniform(0.0, 0.012),
    }
    return Base(rng.uniform(*domain.mu), {k: size * reach[k] / span[k] for k in span})


@dataclass
class Run:
    """Result of a march; arrays of shape (n_tests, n_points).

    Attributes
    ----------
    T : ndarray
        Contact temperature [degC].
    mu : ndarray
        Friction without scatter: base and laws.
    shapes : list of ndarray
        Unit shape of each law along the true loads.
    """

    T: Array
    mu: Array
    shapes: list[Array]


def march(
    loads: Profiles,
    meta: dict[str, NDArray[Any]],
    base: Base,
    laws: list[Law],
    parameters: list[Parameters],
    amplitudes: list[float],
    scatter: Array,
    heat: float,
) -> Run:
    """March all tests along the distance; friction of a step heats the contact of the next one.

    Parameters
    ----------
    loads : Profiles
        Speeds, pressures and so on.
    meta : dict of str to ndarray
        Metadata for the laws.
    base : Base
        Linear friction.
    laws, parameters, amplitudes : list
        Hidden laws, their parameters and factors.
    scatter : ndarray, shape (n_tests, n_points)
        Physical scatter of friction (specimen, lubricant), which heats like any friction.
    heat : float
        Share of the friction heat that reaches the surfaces.

    Returns
    -------
    Run
        Temperatures, friction without scatter and unit shapes.
    """
    n, m = loads.sd.shape
    contact = HeatedContact(n, heat)
    states: list[State] = [{} for _ in laws]
    T, mu = np.empty((n, m)), np.empty((n, m))
    shapes = [np.empty((n, m)) for _ in laws]
    dt = np.diff(loads.t, axis=1, prepend=0.0)
    dsd = np.diff(loads.sd, axis=1, prepend=0.0)
    last = base(0.5 * loads.v[:, 0], loads.T_start, loads.sigma[:, 0], loads.sd[:, 0], loads.psi[:, 0])
    for i in range(m):
        felt = last + scatter[:, i]
        rise = contact.step(felt, loads.sigma[:, i], loads.v[:, i], dt[:, i])
        T[:, i] = loads.T_start + rise
        point = Point(
            loads.t[:, i],
            dt[:, i],
            loads.v[:, i],
            T[:, i],
            rise,
            loads.sigma[:, i],
            loads.sd[:, i],
            dsd[:, i],
            loads.psi[:, i],
            last,
            meta,
        )
        now = base(point.v, point.T, point.sigma, point.sd, point.psi)
        for k, law in enumerate(laws):
            shapes[k][:, i] = law.shape(point, parameters[k], states[k])
            now = now + amplitudes[k] * shapes[k][:, i]
        mu[:, i] = last = now
    return Run(T, mu, shapes)


def twin_temperature(loads: Profiles, mu: Array, sigma: Array, heat: float) -> Array:
    """Temperature a digital twin reports: the same heat balance, driven by measured friction and pressure.

    Parameters
    ----------
    loads : Profiles
        Speeds and times.
    mu, sigma : ndarray, shape (n_tests, n_points)
        Measured friction [-] and pressure [MPa].
    heat : float
        Share of the friction heat that reaches the surfaces.

    Returns
    -------
    ndarray, shape (n_tests, n_points)
        Contact temperature [degC].
    """
    n, m = loads.sd.shape
    contact = HeatedContact(n, heat)
    dt = np.diff(loads.t, axis=1, prepend=0.0)
    T = np.empty((n, m))
    for i in range(m):
        before = max(i - 1, 0)
        T[:, i] = loads.T_start + contact.step(mu[:, before], sigma[:, i], loads.v[:, i], dt[:, i])
    return T
