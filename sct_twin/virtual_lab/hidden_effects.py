"""Hidden physical effects of the virtual laboratory.

Each is a change of mu that a measured lubricant might show, in a closed form of the laboratory's own:
rational, algebraic and inverse-tangent functions, so that a catalogue of textbook laws never meets its
own formula. Amplitudes are such that the part which no linear law of the five loads can take up is
about as large as the scatter between tests.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from friction_models.common import InputError, unknown_name
from friction_models.loads import FloatArray

from .rig.instruments import Faults


@dataclass(frozen=True)
class LawInput:
    """What the true law may depend on; arrays of one shape (metadata: numbers).

    `work` is the friction work per area so far [N/mm, the number in mJ/mm2], `slip` the distance since the
    contact last stood still [mm]; where it is not given, it never stood still but at the start.
    """

    v_rel: FloatArray
    T: FloatArray
    sigma_n: FloatArray
    sd: FloatArray
    psi: FloatArray
    work: FloatArray
    context: Mapping[str, float]
    slip: FloatArray | None = None


#: What an effect adds to mu.
Contribution = Callable[[LawInput, Mapping[str, float]], FloatArray]


@dataclass(frozen=True)
class HiddenEffect:
    """Name of the mechanism, its formula in words, default parameters and the contribution to mu.

    Half of the amplitude A is left at the speed v0:

    >>> one = np.ones(1)
    >>> at_v0 = LawInput(20 * one, 20 * one, 500 * one, 0 * one, one, 0 * one, {})
    >>> HIDDEN["stribeck"].contribution(at_v0, {"A": 0.02, "v0": 20.0}).tolist()
    [0.01]
    """

    name: str
    formula: str
    parameters: Mapping[str, float]
    contribution: Contribution


HIDDEN: dict[str, HiddenEffect] = {}


def _effect(name: str, formula: str, **parameters: float) -> Callable[[Contribution], Contribution]:
    """Add a function to `HIDDEN` as an effect with these parameters."""

    def add(contribution: Contribution) -> Contribution:
        HIDDEN[name] = HiddenEffect(name, formula, parameters, contribution)
        return contribution

    return add


def _step(x: FloatArray) -> FloatArray:
    """Algebraic step from 0 to 1."""
    return np.asarray(0.5 * (1.0 + x / np.sqrt(1.0 + x * x)))


@_effect("stribeck", "A / (1 + v/v0)", A=0.03, v0=25.0)
def _stribeck(i: LawInput, p: Mapping[str, float]) -> FloatArray:
    return p["A"] / (1.0 + i.v_rel / p["v0"])


@_effect("viscous", "A atan(H/H0), H = v / (sigma + 50) / (1 + (T/T0)^2)", A=0.03, T0=80.0, H0=0.04)
def _viscous(i: LawInput, p: Mapping[str, float]) -> FloatArray:
    viscosity = 1.0 / (1.0 + (np.maximum(i.T, 0.0) / p["T0"]) ** 2)
    hersey = i.v_rel * viscosity / (i.sigma_n + 50.0)
    return np.asarray(p["A"] * np.arctan(hersey / p["H0"]))


@_effect("thermal_softening", "A / (1 + (T/T0)^2)", A=0.045, T0=90.0)
def _thermal_softening(i: LawInput, p: Mapping[str, float]) -> FloatArray:
    return p["A"] / (1.0 + (np.maximum(i.T, 0.0) / p["T0"]) ** 2)


@_effect("thermal_breakdown", "A (1 + x/sqrt(1 + x^2)) / 2, x = (T - T_b)/w", A=0.03, T_b=260.0, w=15.0)
def _thermal_breakdown(i: LawInput, p: Mapping[str, float]) -> FloatArray:
    return p["A"] * _step((i.T - p["T_b"]) / p["w"])


@_effect("pressure_saturation", "A atan(x)/x, x = sigma/s0", A=0.09, s0=500.0)
def _pressure_saturation(i: LawInput, p: Mapping[str, float]) -> FloatArray:
    x = np.maximum(i.sigma_n, 1e-6) / p["s0"]
    return np.asarray(p["A"] * np.arctan(x) / x)


@_effect("pressure_power", "A s0 / (sigma + s0)", A=0.15, s0=300.0)
def _pressure_power(i: LawInput, p: Mapping[str, float]) -> FloatArray:
    return p["A"] * p["s0"] / (i.sigma_n + p["s0"])


@_effect("surface_expansion", "A x / (x + x0), x = psi - 1", A=0.06, x0=0.2)
def _surface_expansion(i: LawInput, p: Mapping[str, float]) -> FloatArray:
    x = np.maximum(i.psi - 1.0, 0.0)
    return p["A"] * x / (x + p["x0"])


@_effect("running_in", "A / (1 + (sd/s0)^2)", A=0.03, s0=5.0)
def _running_in(i: LawInput, p: Mapping[str, float]) -> FloatArray:
    return p["A"] / (1.0 + (i.sd / p["s0"]) ** 2)


@_effect("wear_out", "A (x + sqrt(x^2 + w^2)) / 20, x = sd - s0 (zero at sd = 0)", A=0.015, s0=38.0, w=5.0)
def _wear_out(i: LawInput, p: Mapping[str, float]) -> FloatArray:
    x = i.sd - p["s0"]
    return np.asarray(p["A"] * 0.05 * (x + np.hypot(x, p["w"]) - (np.hypot(p["s0"], p["w"]) - p["s0"])))


@_effect("work_exhaustion", "A W^3 / (W0^3 + W^3), W friction work per area", A=0.04, W0=3500.0)
def _work_exhaustion(i: LawInput, p: Mapping[str, float]) -> FloatArray:
    x = (np.maximum(i.work, 0.0) / p["W0"]) ** 3
    return p["A"] * x / (1.0 + x)


@_effect("flash_temperature", "-A x / sqrt(1 + x^2), x = sigma sqrt(v) / q0", A=0.03, q0=8000.0)
def _flash_temperature(i: LawInput, p: Mapping[str, float]) -> FloatArray:
    x = i.sigma_n * np.sqrt(i.v_rel) / p["q0"]
    return np.asarray(-p["A"] * x / np.sqrt(1.0 + x * x))


@_effect("static_peak", "A / (1 + (sd/s0)^4)", A=0.04, s0=0.8)
def _static_peak(i: LawInput, p: Mapping[str, float]) -> FloatArray:
    slip = i.sd if i.slip is None else i.slip
    return p["A"] / (1.0 + (slip / p["s0"]) ** 4)


@_effect("batch", "A in the second batch", A=0.012)
def _batch(i: LawInput, p: Mapping[str, float]) -> FloatArray:
    return p["A"] * i.context.get("batch_number", 0.0) + 0.0 * i.sd


@_effect("tool_roughness", "A x / (1 + x), x = Ra/Ra0", A=0.05, Ra0=0.03)
def _tool_roughness(i: LawInput, p: Mapping[str, float]) -> FloatArray:
    x = i.context.get("Ra", 0.01) / p["Ra0"]
    return p["A"] * x / (1.0 + x) + 0.0 * i.sd


@_effect(
    "unlisted_ridge",
    "A / ((1 + ((T - T0)/T_w)^2) (1 + ((sigma - s0)/s_w)^2)); outside every catalogue",
    A=0.04,
    T0=170.0,
    T_w=60.0,
    s0=1750.0,
    s_w=400.0,
)
def _unlisted_ridge(i: LawInput, p: Mapping[str, float]) -> FloatArray:
    x, y = (i.T - p["T0"]) / p["T_w"], (i.sigma_n - p["s0"]) / p["s_w"]
    return p["A"] / ((1.0 + x * x) * (1.0 + y * y))


#: What may be hidden besides a change of mu: the offset of the friction cell [N] that begins with the load. The cell is
#: tared before the load, so that only a reading without load after a test shows it.
FORCE_ZERO, FORCE_OFFSET = "force_zero", 2000.0


def hidden_names(names: str | Sequence[str] | None, allowed: Collection[str] = HIDDEN) -> tuple[str, ...]:
    """Return the single names of ``"stribeck+wear_out"`` or a sequence. Raises InputError: an unknown name."""
    parts = () if names is None else tuple(names.split("+") if isinstance(names, str) else names)
    for part in parts:
        if part not in allowed:
            raise unknown_name("hidden effect", part, allowed)
    return parts


def with_offset(faults: Faults | None, seed: int) -> Faults:
    """Return the faults of a campaign whose friction cell has an offset in every test, drawn within 10 %.

    Raises InputError: the faults have an offset of their own, or happen to some tests only.
    """
    faults = faults or Faults()
    if faults.force_zero or faults.tests:
        raise InputError(
            f"campaign: hidden {FORCE_ZERO} beside faults of {'some tests' if faults.tests else 'the same name'}; "
            "allowed: beside other faults that happen to all tests"
        )
    factor = float(np.random.default_rng([seed, 7018]).uniform(0.9, 1.1))
    return replace(faults, force_zero=FORCE_OFFSET * factor)
