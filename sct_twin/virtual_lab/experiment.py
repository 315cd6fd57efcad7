"""One virtual test: upsetting, waiting, sliding under the true law, and what the sensors make of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.signal import lfilter

from friction_models.loads import FloatArray

from ..record import SctRecord
from ..signals import integral
from ..sliding import rest, step_ends
from ..upsetting import ContactState
from .law import LawInput, TrueLaw
from .specimen import Rig, SpecimenTable

RATE = 1000.0


@dataclass(frozen=True)
class Instruments:
    """Sensors and specimen scatter; standard deviations unless said otherwise.

    Attributes
    ----------
    moving_mass : float
        Mass between force cell and contact [kg].
    offset : float
        Of mu from test to test: specimen and lubricant.
    drift, drift_length : float
        Slow change of mu within a test, and the distance over which it forgets [mm].
    roughness : float
        Fast fluctuation of mu from sample to sample.
    F_n_noise, F_r_noise, zero : float
        Force cells: noise and unloaded reading [N].
    position_noise : float
        Of the plate position [mm].
    acceleration_noise : float
        Of the plate acceleration [mm/s2].
    temperature_noise : float
        Of the plate thermocouple [K].
    control : float
        Relative wobble of the force control.
    acceleration : float
        With which the plate is set in motion [mm/s2]; not a standard deviation.
    """

    moving_mass: float = 25.0
    offset: float = 0.0042
    drift: float = 0.0016
    drift_length: float = 15.0
    roughness: float = 0.0012
    F_n_noise: float = 90.0
    F_r_noise: float = 35.0
    zero: float = 40.0
    position_noise: float = 0.0015
    acceleration_noise: float = 150.0
    temperature_noise: float = 0.15
    control: float = 0.002
    acceleration: float = 12000.0


@dataclass(frozen=True, eq=False)
class VirtualTest:
    """The record that is handed out, and the truth that is not."""

    record: SctRecord
    truth: dict[str, FloatArray]
    scatter: dict[str, float]


def run_test(
    row: Mapping[str, Any],
    law: TrueLaw,
    table: SpecimenTable,
    rig: Rig,
    instruments: Instruments,
    seed: int,
) -> VirtualTest:
    """Carry out one test of the plan.

    Parameters
    ----------
    row : mapping
        The test's row of the plan.
    law : TrueLaw
        Friction.
    table : SpecimenTable
        Upsetting of this specimen shape.
    rig, instruments : Rig, Instruments
        Reality and sensors.
    seed : int
        Of the campaign; the test draws from its own stream.
    """
    rng = np.random.default_rng([seed, 7003, int(str(row["test_id"])[3:])])
    flow_stress = float(1.0 + rig.flow_stress_scatter * np.clip(rng.standard_normal(), -2.5, 2.5))
    offset = float(instruments.offset * np.clip(rng.standard_normal(), -2.5, 2.5))
    T_tool, force = float(row["T_tool"]), float(row["F_set"])
    context = {
        "Ra": float(row["Ra"]),
        "batch_number": 1.0 if row["batch"] == "B" else 0.0,
        "t_wait": float(row["t_wait"]),
    }
    loading = _loading(table, force, T_tool, flow_stress, rig)
    state = table.state(force, T_tool, flow_stress)
    free, wait = round(0.12 * RATE), round(float(row["t_wait"]) * RATE)
    slide_v = _motion(float(row["v_set"]), float(row["sd_set"]), instruments, rng)
    slide_sd = integral(slide_v, 1.0 / RATE)
    before = free + len(loading) + wait
    F_n = np.concatenate([np.zeros(free), loading, np.full(wait + len(slide_v), force)])
    wobble = _wander(before + len(slide_v), 0.4 * RATE, instruments.control, rng)
    wobble[:before] *= np.clip((np.arange(before) - free - len(loading)) / max(wait, 1), 0.0, 1.0)
    F_n = F_n * (1.0 + wobble)
    v = np.concatenate([np.zeros(before), slide_v])
    sd = np.concatenate([np.zeros(before), slide_sd])
    drift = _wander(int(slide_sd[-1] / 0.1) + 3, instruments.drift_length / 0.1, instruments.drift, rng)
    drift_at = np.interp(sd, 0.1 * np.arange(len(drift)), drift) + offset
    sliding = slice(before, None)
    T, work = _heat(
        state,
        law,
        context,
        rig,
        T_tool,
        float(row["t_wait"]),
        F_n[sliding],
        slide_v,
        slide_sd,
        drift_at[sliding],
    )
    sigma_n = state.sigma_n(F_n[sliding])
    psi = np.full(len(slide_sd), state.psi)
    law_mu = law.mu(LawInput(slide_v, T, sigma_n, slide_sd, psi, work, context))
    mu = np.zeros(len(F_n))
    mu[sliding] = np.maximum(law_mu + drift_at[sliding], 0.002)
    record = _measure(row, F_n, mu, v, sd, T_tool, instruments, rng)
    grid = 0.1 * np.arange(1, int(slide_sd[-1] / 0.1 - 0.5) + 1)
    time = np.arange(len(slide_sd)) / RATE
    columns = {
        "t": time,
        "v_rel": slide_v,
        "T": T,
        "sigma_n": sigma_n,
        "psi": psi,
        "mu_law": law_mu,
        "mu": mu[sliding],
    }
    truth = {name: np.interp(grid, slide_sd, values) for name, values in columns.items()}
    truth["sd"] = grid
    return VirtualTest(record, truth, {"offset": offset, "flow_stress": flow_stress})


def _loading(table: SpecimenTable, force: float, T_tool: float, flow_stress: float, rig: Rig) -> FloatArray:
    """Return the normal force while the ram closes at constant speed, one value a sample."""
    forces = force * np.linspace(0.0, 1.0, 201)
    travel = table.stroke(forces, T_tool, flow_stress) + rig.compliance * forces
    count = int(np.ceil(float(travel[-1]) / rig.ram_speed * RATE)) + 1
    return np.interp(np.arange(count) * rig.ram_speed / RATE, travel, forces)


def _motion(v_set: float, distance: float, instruments: Instruments, rng: np.random.Generator) -> FloatArray:
    """Return the plate speed from rest: half a cosine up to the set value, then a slight ripple."""
    ramp = max(0.5 * np.pi * v_set / instruments.acceleration, 0.02)
    count = int(np.ceil((ramp + distance / v_set) * RATE)) + 1
    t = np.arange(count) / RATE
    phase = np.clip(t / ramp, 0.0, 1.0)
    ripple = 1.0 + 0.003 * np.sin(
        2.0 * np.pi * float(rng.uniform(3.0, 8.0)) * t + float(rng.uniform(0, 6.28))
    )
    v = v_set * 0.5 * (1.0 - np.cos(np.pi * phase)) * ripple
    sd = integral(v, 1.0 / RATE)
    return np.asarray(v[: int(np.searchsorted(sd, distance)) + 1])


def _heat(
    state: ContactState,
    law: TrueLaw,
    context: Mapping[str, float],
    rig: Rig,
    T_tool: float,
    wait: float,
    F_n: FloatArray,
    v: FloatArray,
    sd: FloatArray,
    scatter: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return contact temperature and friction work per area at the samples; mu is fed back step by step."""
    contact = state.sliding(float(v.max()), T_tool, T_tool, rig.thermal)
    rest(contact, wait)
    stops = step_ends(contact.cell, float(sd[-1]))
    t = np.interp(stops, sd, np.arange(len(sd)) / RATE)
    middle = 0.5 * (stops[1:] + stops[:-1])
    at = {
        "F_n": np.interp(middle, sd, F_n),
        "v": np.interp(middle, sd, v),
        "scatter": np.interp(middle, sd, scatter),
    }
    T, work = np.empty(len(stops)), np.zeros(len(stops))
    T[0] = contact.contact.mean
    slope = 0.0
    for k in range(len(middle)):
        step = stops[k + 1] - stops[k]
        sigma = float(at["F_n"][k]) / state.area
        ahead = T[k] + 0.5 * slope * step
        load = LawInput(
            np.array([at["v"][k]]),
            np.array([ahead]),
            np.array([sigma]),
            np.array([middle[k]]),
            np.array([state.psi]),
            np.array([work[k]]),
            context,
        )
        mu = max(float(law.mu(load)[0] + at["scatter"][k]), 0.002)
        dt = max(float(t[k + 1] - t[k]), 1e-9)
        T[k + 1] = contact.advance(dt, step, mu * float(at["F_n"][k]) * step / dt).mean
        slope = (T[k + 1] - T[k]) / step
        work[k + 1] = work[k] + mu * sigma * step
    return np.interp(sd, stops, T), np.interp(sd, stops, work)


def _measure(
    row: Mapping[str, Any],
    F_n: FloatArray,
    mu: FloatArray,
    v: FloatArray,
    sd: FloatArray,
    T_tool: float,
    instruments: Instruments,
    rng: np.random.Generator,
) -> SctRecord:
    """Return what the sensors record: zeros, noise, and the inertia of the plate in the friction force."""
    n = len(F_n)
    a = np.gradient(v, 1.0 / RATE)
    zeros = instruments.zero * rng.standard_normal(2)
    friction = (mu + instruments.roughness * rng.standard_normal(n) * (v > 0)) * F_n
    plate = T_tool + _wander(n, 3.0 * RATE, 0.4, rng) + instruments.temperature_noise * rng.standard_normal(n)
    return SctRecord(
        test_id=str(row["test_id"]),
        t=np.arange(n) / RATE,
        F_n=F_n + zeros[0] + instruments.F_n_noise * rng.standard_normal(n),
        F_r=friction
        + instruments.moving_mass * 1e-3 * a
        + zeros[1]
        + instruments.F_r_noise * rng.standard_normal(n),
        s=sd + 12.0 + instruments.position_noise * rng.standard_normal(n),
        a=a + 30.0 * float(rng.standard_normal()) + instruments.acceleration_noise * rng.standard_normal(n),
        T_plate=plate,
        metadata=dict(row),
    )


def _wander(count: int, memory: float, deviation: float, rng: np.random.Generator) -> FloatArray:
    """Return a stationary process that forgets over `memory` samples (Ornstein-Uhlenbeck)."""
    keep = float(np.exp(-1.0 / memory))
    shocks = deviation * float(np.sqrt(1.0 - keep**2)) * rng.standard_normal(count)
    shocks[0] = deviation * float(rng.standard_normal())
    return np.asarray(lfilter([1.0], [1.0, -keep], shocks))
