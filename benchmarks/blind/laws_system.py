"""Laws of the system (lots, tools, materials, oils) and faults of rig and twin."""

from __future__ import annotations

import numpy as np

from benchmarks.blind.campaign import Array, Campaign, Rng
from benchmarks.blind.law import law


def _levels(c: Campaign, column: str, values: dict[object, float]) -> Array:
    return np.array([values[x] for x in c.of_test(column)], float)


@law("Lots of lubricant differ: normal offsets", "batch factor:batch", metadata="batch")
def lots_normal(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return _levels(c, "batch", {"L1": -0.006, "L2": 0.004, "L3": 0.009, "L4": -0.007})


@law("One lot is bad: twelve per cent more friction", "batch factor:batch", metadata="batch")
def one_bad_lot(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return _levels(c, "batch", {"L1": 0, "L2": 0, "L3": 0.18, "L4": 0}) * mu0


@law("Old and new delivery, under the name lot", "factor:lot", metadata="lot")
def deliveries(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return _levels(c, "lot", {"0417": 0.012, "0532": 0.0, "0533": 0.0})


@law("Materials of the workpiece differ", "factor:material", metadata="material")
def materials(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return _levels(c, "material", {"16MnCr5": 0.0, "C15": -0.002, "42CrMo4": 0.011})


@law("An operator wipes the tool, the other does not", "factor:operator", metadata="operator")
def operators(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return _levels(c, "operator", {"Ott": 0.0, "Lindner": 0.009})


@law(
    "Friction falls with the logarithm of the oil's viscosity at 40 degC",
    "factor:viscosity",
    metadata="viscosity",
)
def oil_grade(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(-0.008 * np.log(c.number_of_test("viscosity") / 100))


@law("Humidity softens the soap", "factor:humidity", metadata="humidity")
def humid_soap(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.018 * ((c.number_of_test("humidity") - 45) / 25))


@law("Ploughing goes with the root of the tool's roughness", "tool_roughness factor:Ra", metadata="Ra")
def rough_root(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.03 * np.sqrt(c.number_of_test("Ra")))


@law("Roughness counts from the thickness of the film on", "tool_roughness factor:Ra", metadata="Ra")
def rough_film(c: Campaign, mu0: Array, rng: Rng) -> Array:
    r = c.number_of_test("Ra")
    return np.asarray(0.03 * r * r / (r * r + 0.2**2))


@law("The cell warms up over the first runs of the campaign", "sensor_drift factor:order", metadata="order")
def warming_cell(c: Campaign, mu0: Array, rng: Rng) -> Array:
    order = c.number_of_test("order")
    return np.asarray(0.02 * -np.expm1(-order / (0.5 * order.max())))


@law("Zero of the friction cell off by a constant force", "force_zero")
def zero_force(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(9.0 / c.load("sigma_n"))


@law(
    "The twin takes 45 per cent too little heat into the contact; friction falls 0.1 per 1000 K of the true one",
    "twin_heating",
    metadata="T_tool",
)
def cold_twin(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(-1.5e-4 * 0.8 * (c.load("T") - c.number_of_test("T_tool")))
