"""Rival shapes: for each effect of the catalogue, curves that its one-sentence description allows.

They are of this benchmark, not of the project, and only serve to see which other effect could be the hidden one on
this plan. A rival is a matrix of columns; its first column has the sign that its description demands.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from benchmarks.blind.campaign import Array, Campaign
from benchmarks.blind.laws_pressure_path import after_step

SIGNLESS = ("factor:", "batch", "rate_state", "running_in", "force_zero", "twin_heating", "sensor_drift")
METADATA = ("batch", "lot", "material", "operator", "viscosity", "humidity", "Ra", "order")


def has_direction(name: str) -> bool:
    """Whether the description of an effect says which way friction goes."""
    return not name.startswith(SIGNLESS)


def _speed(c: Campaign) -> Iterator[tuple[str, Array]]:
    v, p, T = c.load("v_rel"), c.load("sigma_n"), c.load("T")
    for v0 in (5, 10, 20, 40, 80, 150, 300):
        for d in (0.6, 1.0, 1.6):
            yield "stribeck", np.exp(-((v / v0) ** d))
            yield "stribeck", 1 / (1 + (v / v0) ** d)
        yield "rising_speed", np.log1p(v / v0)
        yield "rising_speed", v / (v + v0)
    for q in (0.1, 0.25, 0.4):
        yield "rising_speed", v**q
    for h0 in (0.005, 0.015, 0.04, 0.1, 0.3):
        for d in (0.5, 1.0, 1.7):
            yield "hersey", np.exp(-((v / p / h0) ** d))
            yield "hersey", 1 / (1 + (v / p / h0) ** d)
    for T0 in (30, 60, 120, 250):
        for q in (0.5, 0.75, 1.0):
            yield "viscous", (v / 500) ** q * np.exp(-(T - 20) / T0)


def _heat(c: Campaign) -> Iterator[tuple[str, Array]]:
    v, p, T = c.load("v_rel"), c.load("sigma_n"), c.load("T")
    for T0 in (30, 60, 120, 250, 1000):
        yield "thermal_softening", np.exp(-(T - 20) / T0)
        yield "thermal_softening", 1 / (1 + np.exp((T - 150) / T0))
        yield "thermal_softening", (np.maximum(T, 5) / 20) ** (-30 / T0)
    for Tb in (100, 140, 180, 220, 260, 300):
        for w in (8, 20, 40):
            step = 1 / (1 + np.exp(-(T - Tb) / w))
            yield "thermal_breakdown", step
            yield "thermal_breakdown", np.clip((T - Tb) / (5 * w), 0, 1)
        yield "thermal_breakdown", np.clip((T - Tb) / 100, 0, None)
        for a in (40, 80, 130):
            yield "hot_pressure_breakdown", 1 / (1 + np.exp(-(T - Tb + a * np.log(p / 1500)) / 30))
        for s in (0.1, 0.3):
            yield "hot_pressure_breakdown", 1 / (1 + np.exp(-(T * p / (Tb * 1500) - 1) / s))
    for q in (0.3, 0.5, 0.8):
        work = p / 1500 * (v / 100) ** q
        yield "flash_temperature", -work
        for w0 in (0.5, 1.5, 4.0):
            yield "flash_temperature", np.exp(-work / w0)
    if "T_tool" in c.tests and np.std(T - c.number_of_test("T_tool")) > 3:
        yield "twin_heating", T - c.number_of_test("T_tool")
        yield "twin_heating", c.number_of_test("T_tool") - T


def _pressure_and_expansion(c: Campaign) -> Iterator[tuple[str, Array]]:
    p, psi = c.load("sigma_n"), c.load("psi")
    for p0 in (400, 800, 1200, 1700, 2300):
        yield "pressure_saturation", np.minimum(1, p0 / p)
        yield "pressure_saturation", np.tanh(p / p0) / p
        for n in (1, 2, 4):
            yield "pressure_saturation", 1 / (1 + (p / p0) ** n)
    for e in (0.1, 0.3, 0.6, 1.0):
        yield "pressure_power", p**-e
    yield "force_zero", 1000 / p
    yield "force_zero", -1000 / p
    yield "surface_expansion", np.log(psi)
    for x in (1.5, 3, 6, 12):
        yield "surface_expansion", 1 - np.exp(-(psi - 1) / x)
        yield "surface_expansion", 1 / (1 + (x / psi) ** 3)
    for g in (-1, -0.5, 0.3, 1):
        yield "surface_expansion", np.sign(g) * psi**g


def _path(c: Campaign) -> Iterator[tuple[str, Array]]:
    sd, p = c.load("sd"), c.load("sigma_n")
    for s in (0.2, 0.4, 0.8):
        yield "static_peak", np.exp(-sd / s)
    for s in (0.8, 1.5, 3, 6, 10, 15):
        for sign in (1, -1):
            yield "running_in", sign * np.exp(-sd / s)
    for s in (15, 25, 35, 45, 60):
        for n in (1.0, 2.0, 3.5):
            yield "wear_out", -np.expm1(-((sd / s) ** n))
            yield "work_exhaustion", -np.expm1(-((sd * p / 1500 / s) ** n))
        yield "wear_out", np.clip(sd - s, 0, None) / 50
        yield "work_exhaustion", np.clip(sd * p / 1500 - s, 0, None) / 50
    since, jump = after_step(c)
    if np.any(jump):
        for d in (0.4, 1, 2.5, 6):
            yield (
                "rate_state",
                np.stack([jump * np.exp(-np.clip(since, 0, 100) / d), np.log(c.load("v_rel"))], axis=1),
            )


def _table(c: Campaign) -> Iterator[tuple[str, Array]]:
    for column in METADATA:
        if column not in c.tests:
            continue
        values = c.of_test(column)
        levels = sorted(set(values), key=str)
        names = [
            f"factor:{column}",
            *{"batch": ["batch"], "Ra": ["tool_roughness"], "order": ["sensor_drift"]}.get(column, []),
        ]
        for name in names:
            if isinstance(values[0], str):
                yield name, np.stack([(values == level).astype(float) for level in levels[1:]], axis=1)
            else:
                x = values.astype(float)
                yield name, x
                if name != "tool_roughness":
                    yield name, -x


def rivals(c: Campaign) -> list[tuple[str, Array]]:
    """All rival shapes on this campaign, as matrices with a row a point."""
    out: list[tuple[str, Array]] = []
    for family in (_speed, _heat, _pressure_and_expansion, _path, _table):
        out += [(name, np.asarray(z, float).reshape(len(c.points), -1)) for name, z in family(c)]
    return out
