"""How far a host that takes numbers, not code, stays from the model: at 10 000 points of the trained domain."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from friction_models.common import InputError, shown, unknown_name
from friction_models.common.ranges import is_number
from friction_models.loads import LOAD_NAMES, LOADS, QUANTITIES, FloatArray
from friction_models.loads.contract import behind
from friction_models.models.variables import UNKNOWN_LABEL, as_numbers

from ...interface.friction_source import FrictionSource
from .. import options
from ..common import Reference, one_line, test_box

POINTS = 10_000
#: Steps in which the memory of a point is brought to its sliding distance.
_STEPS = 10


@dataclass(frozen=True)
class Deviation:
    """Largest and root-mean-square difference between what a host uses and the model.

    Examples
    --------
    >>> print(Deviation(0.02, 0.01, {"v_rel": 5.0, "T": 20.0}, 0.1).text())
    0.02 (root mean square 0.01) at 10000 points of the domain; largest at v_rel = 5 mm/s, T = 20 degC, where the model has mu = 0.1
    """

    largest: float
    rms: float
    at: dict[str, float]  #: The loads where it is largest.
    mu: float  #: The model's coefficient there.

    def text(self) -> str:
        """Return the deviation as a phrase."""
        place = ", ".join(f"{n} = {with_unit(n, x)}" for n, x in self.at.items())
        return (
            f"{self.largest:.3g} (root mean square {self.rms:.3g}) at {POINTS} points of the domain; largest at {place}, "
            f"where the model has mu = {self.mu:.4g}"
        )

    def report(self) -> dict[str, object]:
        """Return what stands in an export's JSON file."""
        return {
            "points": POINTS,
            "largest deviation": self.largest,
            "root mean square deviation": self.rms,
            "largest at": self.at,
            "mu of the model there": self.mu,
        }


def with_unit(name: str, value: float) -> str:
    """Return a load with its unit.

    Examples
    --------
    >>> with_unit("T", 80.0), with_unit("psi", 1.25)
    ('80 degC', '1.25')
    """
    unit = QUANTITIES[name].unit
    return f"{value:.4g}{behind(unit)}"


def system_values(source: FrictionSource, given: object = None) -> dict[str, float]:
    """Return the values of all system variables: the given ones, the start values of the others.

    Raises InputError: no mapping, a name that is no system variable, no number, none of its labels.
    """
    values = {p.name: p.start for p in source.system}
    labels = {p.name: p.labels for p in source.system}
    for name, value in options.mapping("system", given, values).items():
        if labels[name]:
            values[name] = _of_label(name, value, labels[name])
        else:
            values[name] = options.number(f"system variable {name}", value, -1e300, 1e300)
    return values


def _of_label(name: str, value: object, labels: Sequence[str]) -> float:
    """Return the number of a label; a number that is no label itself may be that of one."""
    (code,) = as_numbers([value], labels, UNKNOWN_LABEL)
    if code != UNKNOWN_LABEL:
        return float(code)
    if is_number(value) and value in range(len(labels)):
        return float(value)
    error = unknown_name(
        "label", shown(value, 60), [one_line(label) for label in labels], f"system variable {name}"
    )
    raise InputError(f"{error} (or its number, 0 to {len(labels) - 1})")


def held_loads(source: FrictionSource, given: object, names: Collection[str]) -> dict[str, float]:
    """Return where the loads `names` are held: at the given values, the others at their start values.

    Raises InputError: no mapping, another name, no number, one outside the physical limits.
    """
    interface = source.interface(1)
    held = {q.name: interface.start(q) for q in LOADS if q.name in names}
    for name, value in options.mapping("fixed", given, held).items():
        held[name] = options.number(f"fixed {name}", value, QUANTITIES[name].lower, QUANTITIES[name].upper)
    return held


def held_system(source: FrictionSource, held: Mapping[str, float]) -> list[str]:
    """Return a sentence for each system variable: where a host of numbers holds it, and what that leaves out."""
    if not held:
        return []
    reference = Reference(source)
    loads = np.random.default_rng(41).uniform(*test_box(source), size=(500, len(LOAD_NAMES)))
    own = reference.mu(loads, system=list(held.values()))
    found = []
    for p in source.system:
        value = held[p.name]
        label = {float(k): f" ({one_line(text)})" for k, text in enumerate(p.labels)}.get(value, "")
        unit = behind(one_line(p.unit))
        text = f"{p.name} is held at {value:.4g}{unit}{label}"
        seen = [float(k) for k in range(len(p.labels))]
        if not seen and p.lower is not None and p.upper is not None:
            seen = np.linspace(p.lower, p.upper, 5).tolist()
        if seen:
            others = [reference.mu(loads, system=list({**held, p.name: x}.values())) for x in seen]
            off = float(np.abs(np.array(others) - own).max())
            text += f"; at other values of the training mu is off by up to {off:.2e}"
        found.append(text)
    return found


def domain_points(
    source: FrictionSource, system: Mapping[str, float] | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return loads over the trained domain, shape (n, 5), and mu of the model there, shape (n,).

    A model with memory is asked after each point has slid its distance `sd` at its own constant loads. System variables
    have the values `system`, or else their start values.

    Examples
    --------
    >>> from fmus.source.reading import read_source
    >>> from friction_models import ConstantFriction
    >>> loads, mu = domain_points(read_source(ConstantFriction(mu=0.1)))
    >>> loads.shape, float(mu.max())
    ((10000, 5), 0.1)
    """
    reference = Reference(source)
    values = list(({p.name: p.start for p in source.system} | dict(system or {})).values())
    points = np.random.default_rng(40).uniform(*test_box(source), size=(POINTS, len(LOAD_NAMES)))
    if not source.states:
        return points, reference.mu(points, system=values)
    v, sd = points[:, 0], points[:, 3]
    dt = sd / np.maximum(v, 1e-3) / _STEPS
    mu = np.empty(POINTS)
    # The length of a step is one number a call: points of about the same length go together.
    for part in np.array_split(np.argsort(dt), 200):
        state = reference.model.start_state(len(part))
        for k in range(_STEPS):
            at = points[part].copy()
            at[:, 3] = sd[part] * (k + 1) / _STEPS
            state = reference.step(at, state, float(dt[part].mean()), values)
        mu[part] = reference.mu(points[part], state, system=values)
    return points, mu


def deviation(
    source: FrictionSource,
    host: Callable[[FloatArray], FloatArray],
    system: Mapping[str, float] | None = None,
) -> Deviation:
    """Return how far `host`, mu at loads of shape (n, 5), stays from the model at the system variables `system`.

    Examples
    --------
    >>> from fmus.source.reading import read_source
    >>> from friction_models import ConstantFriction
    >>> found = deviation(read_source(ConstantFriction(mu=0.1)), lambda loads: 0.12 + 0.0 * loads[:, 0])
    >>> round(found.largest, 12)
    0.02
    """
    points, mu = domain_points(source, system)
    off = np.abs(host(points) - mu)
    k = int(np.argmax(off))
    place = {n: float(x) for n, x in zip(LOAD_NAMES, points[k])}
    return Deviation(float(off[k]), float(np.sqrt((off**2).mean())), place, float(mu[k]))
