"""Laws that no effect of the catalogue describes. `partial` holds the effects that are a true part of them."""

from __future__ import annotations

import numpy as np

from benchmarks.blind.campaign import Array, Campaign, Rng
from benchmarks.blind.law import law


@law("Friction peak in a window of temperature (glaze before it forms)", partial="thermal_breakdown")
def temperature_window(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.035 * np.exp(-(((c.load("T") - 150) / 38) ** 2)))


@law("Two transitions: up with T, down again, up: a wave")
def temperature_wave(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.014 * np.sin(2 * np.pi * c.load("T") / 150))


@law("Resonance of the rig at one speed", partial="stribeck rising_speed")
def resonance(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.03 * np.exp(-((np.log(c.load("v_rel") / 60) / 0.55) ** 2)))


@law("Turning marks of the plate: a wave over the path")
def turning_marks(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.008 * np.sin(2 * np.pi * c.load("sd") / 13 + 0.8))


@law("Lubricant pockets are passed every 18 mm: saw teeth")
def pockets(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.022 * (np.mod(c.load("sd"), 18) / 18 - 0.5))


@law(
    "Pressure: friction falls (film hardens), then rises (film breaks): a minimum",
    partial="pressure_power pressure_saturation",
)
def pressure_minimum(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.03 * np.abs(c.load("sigma_n") / 1500 - 1) ** 1.5)


@law("Speed lowers friction of cold films and raises that of hot ones")
def crossing_speed_heat(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.012 * np.log(c.load("v_rel") / 50) * np.tanh((c.load("T") - 150) / 80))


@law(
    "Path: films polish at low pressure and wear at high pressure",
    partial="work_exhaustion wear_out running_in",
)
def polish_or_wear(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.035 * (c.load("sd") / 50) * np.tanh((c.load("sigma_n") - 1500) / 600))


@law("Expansion: a hump at psi = 5 (patches of film turn over)", partial="surface_expansion")
def expansion_hump(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.03 * np.exp(-((np.log(c.load("psi") / 5) / 0.6) ** 2)))


@law("Ridge: friction peak at a temperature that moves with the logarithm of speed (Williams-Landel-Ferry)")
def wlf_ridge(c: Campaign, mu0: Array, rng: Rng) -> Array:
    centre = 90 + 28 * np.log(c.load("v_rel") / 10)
    return np.asarray(0.035 * np.exp(-(((c.load("T") - centre) / 45) ** 2)))


@law(
    "Lubricant is drawn in only where speed is high and expansion small; else squeezed out",
    partial="stribeck surface_expansion",
)
def entrapment(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(
        0.014 * np.tanh(np.log(c.load("v_rel") / 50)) * np.tanh(np.log(c.load("psi") / 5) * 1.5)
    )


@law(
    "One material is sensitive to heat, the others are not",
    partial="factor:material thermal_breakdown",
    metadata="material",
)
def one_material_hot(c: Campaign, mu0: Array, rng: Rng) -> Array:
    mine = c.of_test("material") == "C15"
    return np.asarray(np.where(mine, 0.04 * (c.load("T") - 150) / 150, 0.0))


@law("Ploughing grows with pressure: friction rises and levels off")
def ploughing_rise(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.045 * (1 - np.exp(-c.load("sigma_n") / 900)))


@law("Expansion opens dimples that feed lubricant: friction falls with psi")
def feeding_dimples(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(-0.012 * np.log(c.load("psi")))


@law("Hump along the path: debris gathers and leaves", partial="running_in wear_out")
def debris_hump(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.022 * np.exp(-(((c.load("sd") - 24) / 8) ** 2)))


@law(
    "Tribofilm that grows faster when hot (Arrhenius rate along the path)",
    partial="running_in thermal_softening",
)
def hot_tribofilm(c: Campaign, mu0: Array, rng: Rng) -> Array:
    rate = 0.35 * np.exp(-4200 * (1 / (c.load("T") + 273.15) - 1 / 573.15))
    return np.asarray(-0.04 * -np.expm1(-rate * c.load("sd")))


@law("Highest pressure so far hardens the film: other friction on the way down")
def pressure_memory(c: Campaign, mu0: Array, rng: Rng) -> Array:
    p = c.load("sigma_n")
    peak = np.concatenate([np.maximum.accumulate(p[rows]) for rows in c.slices()])
    return np.asarray(0.035 * (peak - p) / 1500)


@law("Carrier evaporates with time, not distance", partial="running_in wear_out rising_speed stribeck")
def evaporation(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.03 * -np.expm1(-c.load("t") / 1.2))


@law("Checkerboard: phases of a two-part coating answer heat and expansion oppositely")
def checkerboard(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.012 * np.tanh((c.load("T") - 150) / 40) * np.tanh(3 * np.log(c.load("psi") / 5)))


@law("Window of pressure and speed where chatter sets in")
def chatter_window(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(
        0.045 * np.exp(-(((c.load("sigma_n") - 1500) / 500) ** 2) - (np.log(c.load("v_rel") / 60) / 0.9) ** 2)
    )
