"""``--target radioss`` and ``--target calculix``: hosts with a fixed formula, whose coefficients are fitted to the model.

OpenRadioss (engine source, contact type 7; p contact pressure, v sliding speed)::

    Ifric 1: mu = Fric + (C1 + C4 p) p + (C2 + C3 p) v + C5 v^2
    Ifric 2: mu = Fric + C1 exp(C2 v) p^2 + C3 exp(C4 v) p + C5 exp(C6 v)

CalculiX (source of *FRICTION) has one coefficient an interaction, without dependence, and a stick slope.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping

import numpy as np

from friction_models.loads import LOAD_NAMES, FloatArray

from ...interface.friction_source import FrictionSource
from .. import options
from ..common import Files, Reference, c_prefix, description, documents, rows, template, test_box
from ..host_units import HostUnits, host_units
from .deviation import Deviation, deviation, domain_points, held_loads, held_system, system_values, with_unit

OPTIONS = ("name", "units", "fixed", "system")
#: Points of pressure and speed at which a formula is fitted.
_GRID = 41
_HELD = ("T", "sd", "psi")


def polynomial_law(c: FloatArray, v: FloatArray, p: FloatArray) -> FloatArray:
    """Return mu of Ifric 1 with the coefficients Fric, C1 to C5."""
    return np.maximum(c[0] + (c[1] + c[4] * p) * p + (c[2] + c[3] * p) * v + c[5] * v**2, 1e-30)


def darmstadt_law(c: FloatArray, v: FloatArray, p: FloatArray) -> FloatArray:
    """Return mu of Ifric 2 with the coefficients Fric, C1 to C6."""
    mu = c[0] + c[1] * np.exp(c[2] * v) * p**2 + c[3] * np.exp(c[4] * v) * p + c[5] * np.exp(c[6] * v)
    return np.asarray(np.maximum(mu, 1e-30))


def fit_polynomial(v: FloatArray, p: FloatArray, mu: FloatArray) -> FloatArray:
    """Return the coefficients whose largest deviation is smallest, by reweighted least squares (Lawson).

    Examples
    --------
    >>> v, p = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 1, 5))
    >>> c = fit_polynomial(v.ravel(), p.ravel(), 0.1 - 0.02 * p.ravel() + 0.01 * v.ravel())
    >>> bool(np.allclose(c, [0.1, -0.02, 0.01, 0.0, 0.0, 0.0]))
    True
    """
    scale = np.array([max(float(np.abs(p).max()), 1e-30), max(float(np.abs(v).max()), 1e-30)])
    x, y = p / scale[0], v / scale[1]
    columns = np.column_stack([np.ones_like(x), x, y, x * y, x**2, y**2])
    weights, best, smallest = np.full(len(mu), 1.0 / len(mu)), np.zeros(6), np.inf
    for _ in range(60):
        root = np.sqrt(weights)
        c = np.linalg.lstsq(columns * root[:, None], mu * root, rcond=None)[0]
        off = np.abs(columns @ c - mu)
        if off.max() < smallest:
            best, smallest = c, float(off.max())
        if smallest < 1e-13:
            break
        weights = weights * np.maximum(off, 1e-3 * off.max())
        weights /= weights.sum()
    powers = np.array([[0, 0], [1, 0], [0, 1], [1, 1], [2, 0], [0, 2]])
    return np.asarray(best / np.prod(scale**powers, axis=1))


def fit_darmstadt(v: FloatArray, p: FloatArray, mu: FloatArray) -> FloatArray:
    """Return coefficients of Ifric 2 by least squares from a few starts of the three rates."""
    from scipy.optimize import least_squares

    width, height = max(float(v.max()), 1e-30), max(float(p.max()), 1e-30)
    x, y = p / height, v / width
    best, smallest = np.zeros(7), np.inf

    def linear(rates: FloatArray) -> tuple[FloatArray, FloatArray]:
        columns = np.column_stack(
            [np.ones_like(x), np.exp(rates[0] * y) * x**2, np.exp(rates[1] * y) * x, np.exp(rates[2] * y)]
        )
        c = np.linalg.lstsq(columns, mu, rcond=None)[0]
        return c, columns @ c - mu

    def misfit(rates: FloatArray) -> FloatArray:
        return linear(rates)[1]

    for start in ((-1.0, -1.0, -5.0), (-0.1, -0.1, -20.0)):
        found = least_squares(misfit, start, bounds=(-50.0, 3.0), max_nfev=60)
        c, off = linear(found.x)
        if np.abs(off).max() < smallest:
            smallest = float(np.abs(off).max())
            r = found.x / width
            best = np.array([c[0], c[1] / height**2, r[0], c[2] / height, r[1], c[3], r[2]])
    return best


def _slice(
    source: FrictionSource, held: Mapping[str, float], system: Mapping[str, float]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return speeds, pressures and mu of the model on a grid of both, the other loads held."""
    lower, upper = test_box(source)
    v, p = (a.ravel() for a in np.meshgrid(*(np.linspace(lower[k], upper[k], _GRID) for k in (0, 2))))
    loads = np.empty((len(v), len(LOAD_NAMES)))
    loads[:, 0], loads[:, 2] = v, p
    for name, value in held.items():
        loads[:, LOAD_NAMES.index(name)] = value
    return v, p, Reference(source).mu(loads, system=list(system.values()))


def _sentences(held: Mapping[str, float]) -> list[str]:
    return [f"{n} is held at {with_unit(n, x)}" for n, x in held.items()]


def _texts(
    source: FrictionSource, prefix: str, host: HostUnits, held: list[str], found: Deviation
) -> dict[str, str]:
    return description(source) | {
        "P": prefix,
        "UNITS": host.text(),
        "DEVIATION": found.text(),
        "LARGEST": f"{found.largest:.3g}",
        "FIXED": rows(held),
        "MEMORY": "THIS MODEL HAS MEMORY, which the host cannot have: mu is fitted to a fresh contact point."
        if source.states
        else "The model has no memory.",
    }


def radioss_files(
    source: FrictionSource,
    name: str | None = None,
    units: object = "tonne-mm-s",
    fixed: object = None,
    system: object = None,
) -> Files:
    """Return the files of an OpenRadioss export: the better of both formulas, fitted over speed and pressure.

    The loads that the formulas do not know are held where `fixed` says, system variables where `system` does; at their start
    values by default.

    Examples
    --------
    >>> from fmus.source.reading import read_source
    >>> from friction_models import ConstantFriction
    >>> sorted(radioss_files(read_source(ConstantFriction(mu=0.1)), name="law"))
    ['LICENSE.txt', 'README.txt', 'card.json', 'fit.json', 'law_friction.rad', 'model.onnx']
    """
    host, held, prefix = host_units(units), held_loads(source, fixed, _HELD), c_prefix(source, name)
    chosen_system = system_values(source, system)
    v, p, mu = _slice(source, held, chosen_system)
    v, p = v / host.speed, p / host.pressure
    fits = {1: fit_polynomial(v, p, mu), 2: fit_darmstadt(v, p, mu)}
    laws: dict[int, Callable[[FloatArray, FloatArray, FloatArray], FloatArray]]
    laws = {1: polynomial_law, 2: darmstadt_law}
    errors = {k: float(np.abs(laws[k](c, v, p) - mu).max()) for k, c in fits.items()}
    chosen = min((round(error, 12), k) for k, error in errors.items())[1]
    # What the host reads: ten digits.
    c = np.array([float(f"{x:.12e}") for x in fits[chosen]])
    found = deviation(
        source,
        lambda loads: laws[chosen](c, loads[:, 0] / host.speed, loads[:, 2] / host.pressure),
        chosen_system,
    )
    kept = [*_sentences(held), *held_system(source, chosen_system)]
    cells = [f"{x:20.12e}" for x in (*c[1:], 0.0)[:6]]
    values = _texts(source, prefix, host, kept, found) | {
        "IFRIC": str(chosen),
        "SLICE_ERROR": f"{errors[chosen]:.3g}",
        "OTHER": f"Ifric {3 - chosen}: {errors[3 - chosen]:.3g}",
        "FIRST": "".join(cells[:5]),
        "SECOND": cells[5] + f"{c[0]:20.12e}",
    }
    report = {
        "Ifric": chosen,
        "Fric": float(c[0]),
        "C": c[1:].tolist(),
        "units": host.text(),
        "summary": f"Ifric {chosen} is off by at most {found.text()}",
        "held": kept,
        "largest deviation at the held loads, by Ifric": {str(k): e for k, e in errors.items()},
        "remaining": found.report(),
    }
    return {
        f"{prefix}.rad": template("radioss.rad", values),
        "fit.json": json.dumps(report, indent=2) + "\n",
        "README.txt": template("readme_radioss.txt", values),
        **documents(source),
    }


def calculix_files(
    source: FrictionSource,
    name: str | None = None,
    units: object = "tonne-mm-s",
    fixed: object = None,
    system: object = None,
    slip: object = 0.01,
) -> Files:
    """Return the files of a CalculiX export: one coefficient, in the middle of those of the domain, and a stick slope.

    With loads in `fixed` mu is taken there, in place of the middle of the domain; system variables have the values `system`,
    their start values by default. Sticking ends at the elastic slip `slip` [mm], which makes the stick slope.

    Examples
    --------
    >>> from fmus.source.reading import read_source
    >>> from friction_models import ConstantFriction
    >>> files = calculix_files(read_source(ConstantFriction(mu=0.1)), name="law")
    >>> str(files["law_friction.inp"]).splitlines()[-1]
    '0.1, 10000'
    """
    host, prefix = host_units(units), c_prefix(source, name)
    held = held_loads(source, fixed, LOAD_NAMES)
    chosen = system_values(source, system)
    length = options.number("slip", slip, 1e-6, 10.0)
    if fixed:
        at = np.array([[held[n] for n in LOAD_NAMES]])
        mu = float(Reference(source).mu(at, system=list(chosen.values()))[0])
    else:
        found = domain_points(source, chosen)[1]
        mu = 0.5 * float(found.min() + found.max())
    mu = max(float(f"{mu:.9g}"), 1e-6)  # *FRICTION refuses 0
    remains = deviation(source, lambda loads: np.full(len(loads), mu), chosen)
    kept = held_system(source, chosen)
    slope = mu * held["sigma_n"] / host.pressure / (length / host.length)
    values = _texts(source, prefix, host, [*_sentences(held), *kept], remains) | {
        "MU": f"{mu:.9g}",
        "SLOPE": f"{slope:.6g}",
        "SLIP": f"{length:g}",
        "CHOICE": "the coefficient at the loads below"
        if fixed
        else "the middle between the smallest and the largest coefficient of the domain, which makes the largest deviation smallest",
    }
    report = {
        "mu": mu,
        "stick slope": slope,
        "units": host.text(),
        "summary": f"mu = {mu:g} is off by at most {remains.text()}",
        "held": kept,
        "remaining": remains.report(),
    }
    return {
        f"{prefix}.inp": template("calculix.inp", values),
        "fit.json": json.dumps(report, indent=2) + "\n",
        "README.txt": template("readme_calculix.txt", values),
        **documents(source),
    }
