"""One virtual test: upsetting, waiting, sliding under the true law, and the signals of the sensors."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from friction_models.loads import FloatArray

from ..signals.filters import integral
from .contact.contact_state import LabContact
from .heating import LEAST_MU_WITH_SCATTER, Sliding, heat
from .law import LawInput, TrueLaw
from .plans import PlanRow
from .protocols import Schedule, schedule
from .rig.drive import RATE, commanded, on_elastic_drive
from .rig.instruments import Faults, Instruments, measured, wander
from .rig.specimen import DIAMETER, HEIGHT, TABLE_MU, Rig, SpecimenTable

#: Time in which the load is taken off after a test [s].
UNLOADING = 0.3
#: Friction over normal force for which an elastic drive is wound up: at most, and as a rule.
WIND_UP, USUAL_MU = 0.3, 0.08
#: Deceleration of the plate at the end of a test that is recorded up to unloading [mm/s2], and samples at rest after it.
BRAKING, STANDING = 40000.0, 30


@dataclass(frozen=True, eq=False)
class VirtualTest:
    """The record of a virtual test, and the truth behind it."""

    #: Channels in canonical names and units.
    frame: pd.DataFrame
    #: Loads and friction at equal distances.
    truth: dict[str, FloatArray]
    #: True values of this specimen, force cell and lubricant film.
    scatter: dict[str, float]


@dataclass(frozen=True)
class Specimen:
    """Diameter and height [mm] as they are and as the caliper says, and friction while it is upset."""

    diameter: float
    height: float
    diameter_measured: float
    height_measured: float
    upsetting_mu: float

    @classmethod
    def draw(cls, test_id: str, rig: Rig, instruments: Instruments, seed: int) -> Specimen:
        """Draw the specimen of a test, from a stream of its own."""
        z = np.clip(np.random.default_rng([seed, 7015, stream(test_id)]).standard_normal(5), -2.5, 2.5)
        diameter = float(DIAMETER + rig.diameter_scatter * z[0])
        height = float(HEIGHT + rig.height_scatter * z[1])
        read = instruments.caliper * z[2:4]
        mu = rig.upsetting_mu * (1.0 + rig.upsetting_scatter * float(z[4]))
        return cls(
            diameter, height, round(diameter + float(read[0]), 3), round(height + float(read[1]), 3), mu
        )


def contact_reading(diameter: float, test_id: str, instruments: Instruments, seed: int) -> float:
    """Return the contact diameter as measured after a test [mm]; its error has a random stream of its own."""
    z = np.clip(np.random.default_rng([seed, 7017, stream(test_id)]).standard_normal(), -2.5, 2.5)
    return round(diameter + instruments.contact_reading * float(z), 2)


def stream(test_id: str) -> int:
    """Return the number of the random stream of a test."""
    tail = test_id.removeprefix("sct")
    return int(tail) if tail.isdecimal() and len(tail) <= 9 else zlib.crc32(test_id.encode())


def run_test(
    row: PlanRow,
    law: TrueLaw,
    table: SpecimenTable,
    rig: Rig,
    instruments: Instruments,
    seed: int,
    faults: Faults | None = None,
) -> VirtualTest:
    """Carry out one test of the plan; `seed` is the campaign's, the test draws from a stream of its own.

    Raises InputError: a protocol that cannot be.
    """
    test_id = row["test_id"]
    rng = np.random.default_rng([seed, 7003, stream(test_id)])
    more = np.random.default_rng([seed, 7013, stream(test_id)])
    told = schedule(row, f"test {test_id}")
    flow_stress = float(1.0 + rig.flow_stress_scatter * np.clip(rng.standard_normal(), -2.5, 2.5))
    offset = float(instruments.offset * np.clip(rng.standard_normal(), -2.5, 2.5))
    if instruments.batch_scatter > 0.0:
        batch = np.random.default_rng([seed, 7016, *str(row["batch"]).encode()])
        offset += instruments.batch_scatter * float(batch.standard_normal())
    specimen = Specimen.draw(test_id, rig, instruments, seed)
    deviations = {
        "diameter": specimen.diameter - DIAMETER,
        "height": specimen.height - HEIGHT,
        "mu": specimen.upsetting_mu - TABLE_MU,
    }
    table = replace(table, deviations=deviations)
    T_tool, force = float(row["T_tool"]), float(row["F_set"])
    context = {
        "Ra": float(row["Ra"]),
        "batch_number": 1.0 if row["batch"] == "B" else 0.0,
        "t_wait": float(row["t_wait"]),
    }
    loading = _loading(table, force, T_tool, flow_stress, rig)
    state = table.state(force, T_tool, flow_stress)
    rise = table.rise(loading, T_tool, flow_stress)
    distance = float(row["sd_set"])
    # How long the rig records after the load is off [s].
    unloaded = max(told.zero_reading, instruments.unloaded_after)
    brakes = unloaded > 0.0
    # An elastic drive is ahead of the plate: it goes on until the plate has slid its way.
    share = USUAL_MU if brakes else WIND_UP
    ahead = share * force / instruments.stiffness if instruments.stiffness > 0.0 else 0.0
    command = _motion(told, distance, ahead, brakes, instruments, rng)
    plate_v, plate_sd, drive_force = _follow(command, force, state, law, context, T_tool, offset, instruments)
    if not brakes:
        last = int(np.searchsorted(plate_sd, distance)) + 1
        plate_v, plate_sd, drive_force = plate_v[:last], plate_sd[:last], drive_force[:last]
    free = round((0.12 + told.zero_reading) * RATE)
    wait = round(float(row["t_wait"]) * RATE)
    begin = free + len(loading) + wait
    F_n = _forces(told, force, loading, free, wait, plate_sd, distance, float(row["v_set"]))
    end = begin + len(plate_v)
    if unloaded > 0.0:
        standing = np.full(round(0.1 * RATE), F_n[-1])
        falling = np.linspace(F_n[-1], 0.0, round(UNLOADING * RATE))
        F_n = np.concatenate([F_n, standing, falling, np.zeros(round(unloaded * RATE))])
    n = len(F_n)
    wobble = wander(n, 0.4 * RATE, instruments.control, rng)
    wobble[:begin] *= np.clip((np.arange(begin) - free - len(loading)) / max(wait, 1), 0.0, 1.0)
    F_n = F_n * (1.0 + wobble)
    v, sd = np.zeros(n), np.zeros(n)
    v[begin:end], sd[begin:end], sd[end:] = plate_v, plate_sd, plate_sd[-1]
    grain = wander(int(plate_sd[-1] / 0.1) + 3, instruments.drift_length / 0.1, instruments.drift, rng)
    scatter = np.interp(plate_sd, 0.1 * np.arange(len(grain)), grain) + offset
    static = np.zeros(len(plate_sd))  # by how much friction is higher at break-away
    if instruments.stiffness > 0.0:
        static += instruments.static / (1.0 + (plate_sd / instruments.static_length) ** 2)
    sliding = Sliding(F_n[begin:end], plate_v, plate_sd, scatter)
    T, work, slip = heat(state, law, context, rig, T_tool, rise, float(row["t_wait"]), sliding)
    sigma_n = state.sigma_n(sliding.F_n)
    psi = np.full(len(plate_sd), state.psi)
    law_mu = law.mu(LawInput(plate_v, T, sigma_n, plate_sd, psi, work, context, slip))
    mu = np.maximum(law_mu + scatter, LEAST_MU_WITH_SCATTER) + static
    friction = np.zeros(n)
    friction[begin:end] = mu * sliding.F_n
    if instruments.stiffness > 0.0:
        friction[begin:end] = np.where(plate_v > 0.0, friction[begin:end], drive_force)
    friction[end:] = friction[end - 1] * F_n[end:] / max(F_n[end - 1], 1.0)
    true = {
        "F_n": F_n,
        "friction": friction,
        "a": np.gradient(v, 1.0 / RATE),
        "sd": sd,
        "T_plate": np.full(n, T_tool),
    }
    if instruments.plate_capacity > 0.0:
        true["T_plate"] += integral(friction * v, 1.0 / RATE) * 1e-3 / instruments.plate_capacity
    # Calibrations of the force cells, the same in all tests of a campaign.
    gains = 1.0 + instruments.gain * np.random.default_rng([seed, 7014]).standard_normal(2)
    frame = measured(true, v > 0.0, instruments, gains, rng, more)
    if faults is not None and faults.happen_to(test_id):
        frame = faults.apply(frame, free, more)
    columns = {
        "t": np.arange(len(plate_sd)) / RATE,
        "v_rel": plate_v,
        "T": T,
        "sigma_n": sigma_n,
        "psi": psi,
        "mu_law": law_mu,
        "mu": mu,
    }
    grid = 0.1 * np.arange(1, int(plate_sd[-1] / 0.1 - 0.5) + 1)
    truth = {name: np.interp(grid, plate_sd, values) for name, values in columns.items()} | {"sd": grid}
    known = {
        "offset": offset,
        "flow_stress": flow_stress,
        "diameter": specimen.diameter,
        "height": specimen.height,
        "upsetting_mu": specimen.upsetting_mu,
        "contact_diameter": 2.0 * state.radius,
    }
    return VirtualTest(frame, truth, known)


def _loading(table: SpecimenTable, force: float, T_tool: float, flow_stress: float, rig: Rig) -> FloatArray:
    """Return the normal force while the ram closes at constant speed, one value a sample."""
    forces = force * np.linspace(0.0, 1.0, 201)
    travel = table.stroke(forces, T_tool, flow_stress) + rig.compliance * forces
    count = int(np.ceil(float(travel[-1]) / rig.ram_speed * RATE)) + 1
    return np.interp(np.arange(count) * rig.ram_speed / RATE, travel, forces)


def _motion(
    told: Schedule,
    distance: float,
    ahead: float,
    brakes: bool,
    instruments: Instruments,
    rng: np.random.Generator,
) -> FloatArray:
    """Return the speed of the drive from rest, with a slight ripple, up to the sliding distance or to rest."""
    v = commanded(told.speeds, distance, instruments.acceleration, told.hold)
    if ahead > 0.0:
        v = np.concatenate([v, np.full(int(np.ceil(ahead / v[-1] * RATE)), v[-1])])
    t = np.arange(len(v)) / RATE
    frequency, phase = float(rng.uniform(3.0, 8.0)), float(rng.uniform(0, 6.28))
    v = v * (1.0 + 0.003 * np.sin(2.0 * np.pi * frequency * t + phase))
    v = v[: int(np.searchsorted(integral(v, 1.0 / RATE), distance + ahead)) + 1]
    if not brakes:
        return np.asarray(v)
    count = int(np.ceil(max(0.5 * np.pi * float(v[-1]) / BRAKING, 0.02) * RATE))
    falling = 0.5 * (1.0 + np.cos(np.pi * np.arange(1, count + 1) / count))
    return np.concatenate([v, v[-1] * falling, np.zeros(STANDING)])


def _follow(
    command: FloatArray,
    force: float,
    state: LabContact,
    law: TrueLaw,
    context: Mapping[str, float],
    T_tool: float,
    offset: float,
    instruments: Instruments,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return speed and distance of the plate, and the force in the drive, from the command."""
    drive = integral(command, 1.0 / RATE)
    if instruments.stiffness == 0.0:
        return command, drive, np.zeros(len(command))
    one = np.ones(1)
    start = LawInput(
        0.0 * one, T_tool * one, state.sigma_n(force) * one, 0.0 * one, state.psi * one, 0.0 * one, context
    )
    mu = max(float(law.mu(start)[0]) + offset, LEAST_MU_WITH_SCATTER)
    mass = instruments.moving_mass * 1e-3
    damping = 2.0 * instruments.damping * float(np.sqrt(instruments.stiffness * mass))
    static = instruments.static, instruments.static_length
    sd, pull = on_elastic_drive(drive, force, mu, *static, instruments.stiffness, damping, mass)
    v = np.gradient(sd, 1.0 / RATE)
    v[sd <= 0.0] = 0.0
    return np.maximum(v, 0.0), sd, pull


def _forces(
    told: Schedule,
    force: float,
    loading: FloatArray,
    free: int,
    wait: int,
    sd: FloatArray,
    distance: float,
    v_set: float,
) -> FloatArray:
    """Return the normal force up to the end of sliding: the specimen is upset under the largest one."""
    first = told.forces[0]
    waiting = np.full(wait, force)
    if first != 1.0:
        waiting = force * np.interp(np.arange(wait) / max(wait, 1), [0.1, 0.6], [1.0, first])
    sliding = force * told.force(sd, distance, v_set)
    return np.concatenate([np.zeros(free), loading, waiting, sliding])
