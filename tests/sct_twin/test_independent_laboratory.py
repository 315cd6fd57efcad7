"""The twin against the laboratory, which shares no reading and no heat kernel with it: faults of the twin show."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
import pytest

from forming import PowerLaw, PunchGeometry
from forming.fe.contact import PRESSURE
from forming.fe.simulation import Simulation
from forming.processes import plate_contact, specimen_upsetting
from friction_models.loads import FloatArray
from sct_twin.twin import upsetting
from sct_twin.twin.heat import contact_temperature
from sct_twin.twin.heat.thermal_settings import ThermalSettings
from sct_twin.twin.upsetting import ContactState, UpsettingCase, UpsettingHeat, UpsettingRun, robust_upset
from sct_twin.virtual_lab.contact.contact_state import LabContact, contact_under
from sct_twin.virtual_lab.contact.specimen_run import FRACTION, SpecimenCase, upset_specimen
from sct_twin.virtual_lab.heat.bodies import HeatBody, LabHeat

STEEL = PowerLaw(K=700.0, n=0.15, prestrain=0.005)
FORCE, MESH = 250e3, 0.7
#: How far the twin may be from the laboratory [%]: area, expansion, pressure over the radius (root mean square),
#: temperatures of their rise, where it slides (both surfaces) and after a wait, where the rise is 4 K.
BARS = {"area": 0.15, "psi": 0.15, "pressure": 0.8, "T_plate": 1.2, "T_specimen": 1.2, "T_rest": 6.0}


class Specimen(NamedTuple):
    """A specimen, and what the laboratory says of it under `FORCE`."""

    case: UpsettingCase
    lab: LabContact
    rise: float
    seconds: float


def specimen(punch: PunchGeometry, mu: float) -> Specimen:
    highest = 1.15 * FORCE
    run = upset_specimen(SpecimenCase(punch, highest, MESH, STEEL, mu, 20.0, 20.0, 10.0))
    seconds = (punch.specimen_height - float(np.interp(FORCE, run.force, run.height))) / 10.0
    rise = float(np.interp(FORCE, run.force, run.rise))
    case = UpsettingCase(punch, highest, MESH, STEEL, mu, 20.0, 20.0)
    return Specimen(case, contact_under(run, FORCE), rise, seconds)


@pytest.fixture(scope="module")
def free() -> Specimen:
    """A specimen that spreads without friction: psi is its area ratio, 2.110."""
    return specimen(PunchGeometry(), 0.0)


@pytest.fixture(scope="module")
def filled() -> Specimen:
    """A specimen with friction that fills its bore: psi and pressure vary over the radius."""
    return specimen(PunchGeometry(bore_diameter=15.51), 0.1)


def shape_errors(of: Specimen) -> dict[str, float]:
    """Return the differences of the contact, twin less laboratory [%]."""
    result = robust_upset(of.case)
    twin, lab = ContactState.from_result(result, FORCE, of.case), of.lab
    inside = FRACTION < 0.97
    there = np.interp(FRACTION, twin.radius_fraction, twin.pressure)
    weight = FRACTION * inside
    rms = np.sqrt(float(weight @ (there - lab.pressure) ** 2) / float(weight @ lab.pressure**2))
    return {
        "area": 100.0 * (twin.area / lab.area - 1.0),
        "psi": 100.0 * (twin.psi / lab.psi - 1.0),
        "pressure": 100.0 * rms,
    }


def beyond(errors: dict[str, float]) -> set[str]:
    return {name for name, error in errors.items() if abs(error) > BARS[name]}


def test_the_twin_reads_what_the_laboratory_reads(free: Specimen, filled: Specimen) -> None:
    assert of_area_ratio(free) == pytest.approx(1.0, abs=0.002)
    for which in (free, filled):
        assert beyond(shape_errors(which)) == set()


def of_area_ratio(free: Specimen) -> float:
    """Return the laboratory's expansion without friction over its closed form, A / A0."""
    return free.lab.psi / (free.lab.area / (np.pi * 7.5**2))


Row = dict[str, FloatArray | float]
Reading = Callable[[Simulation, PunchGeometry, np.ndarray], Row]


def edge_counts_twice(real: Reading) -> Reading:
    def read(sim: Simulation, punch: PunchGeometry, fraction: np.ndarray) -> Row:
        row, weight = real(sim, punch, fraction), np.gradient(fraction) * fraction
        return row | {"psi_mean": float(weight @ row["psi"] / weight.sum())}

    return read


def corner_averages_face_and_side(sim: Simulation, edge: float, fraction: np.ndarray) -> np.ndarray:
    markers, surface = sim.state.markers, sim.state.body.surface
    now, start = markers.areas(surface), markers.start_areas
    psi = (np.append(0.0, now) + np.append(now, 0.0)) / (np.append(0.0, start) + np.append(start, 0.0))
    nodes, touches = np.arange(len(surface)), markers.track <= edge + 1e-9
    r = np.interp(markers.track, nodes, surface[:, 0])
    return np.interp(fraction * np.interp(edge, nodes, surface[:, 0]), r[touches], psi[touches])


def pressure_is_smeared(real: Reading) -> Reading:
    def read(sim: Simulation, punch: PunchGeometry, fraction: np.ndarray) -> Row:
        tables = sim.state.tables
        if tables is None:
            return real(sim, punch, fraction)
        table = tables[0].copy()
        under = np.where(table[:, PRESSURE] > 0.0, 0, -1)
        table[:, PRESSURE] = averaged(table[:, PRESSURE], sim.state.weights, under)
        sim.state.tables = [table, *tables[1:]]
        try:
            return real(sim, punch, fraction)
        finally:
            sim.state.tables = tables

    return read


def averaged(values: np.ndarray, weights: np.ndarray, under: np.ndarray) -> np.ndarray:
    """Return the pressure smeared over neighbours of the same contact, 1:2:1 by area: the fault that is planted."""
    smeared = values.copy()
    for k in np.flatnonzero(under >= 0):
        near = [j for j in (k - 1, k, k, k + 1) if 0 <= j < len(values) and under[j] == under[k]]
        smeared[k] = np.average(values[near], weights=weights[near])
    return smeared


@pytest.mark.parametrize(
    ("fault", "seen"), [("double edge", "psi"), ("corner", "psi"), ("smeared", "pressure")]
)
def test_a_fault_of_the_contact_shows(
    filled: Specimen, fault: str, seen: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = specimen_upsetting.plate_contact
    if fault == "corner":
        monkeypatch.setattr(plate_contact, "_expansion", corner_averages_face_and_side)
    else:
        planted = edge_counts_twice if fault == "double edge" else pressure_is_smeared
        monkeypatch.setattr(specimen_upsetting, "plate_contact", planted(real))
    assert seen in beyond(shape_errors(filled))


#: Sliding speeds [mm/s], distance [mm], friction and wait [s] of the thermal comparison.
SPEEDS, DISTANCE, MU, WAIT = (50.0, 500.0), 45.0, 0.08, 0.5


@pytest.fixture(scope="module")
def lab_warmth(filled: Specimen) -> dict[str, np.ndarray]:
    """The laboratory's temperatures of plate and specimen: after the wait, and at the speeds."""
    usual = ThermalSettings().constant()
    plate, steel = (HeatBody(body.conductivity, body.capacity) for body in (usual.plate, usual.specimen))
    rows = {}
    for speed in SPEEDS:
        contact = filled.lab.rubbed(20.0, LabHeat(16, usual.heat_transfer, plate, steel))
        for _ in range(12):
            contact.warm(filled.rise / 12.0)
            contact.advance(filled.seconds / 12.0, 0.0, 0.0)
        for dt in np.diff(np.append(0.0, WAIT * np.geomspace(1e-3, 1.0, 14))):
            contact.advance(float(dt), 0.0, 0.0)
        rows["rest"] = np.array(contact.means[1:3])
        step, means = 0.25 * contact.size, []
        for _ in range(round(DISTANCE / step)):
            means.append(contact.advance(step / speed, step, MU * FORCE * speed)[1:3])
        rows[f"{speed:g}"] = np.mean(means, axis=0)
    return rows


def heat_errors(of: Specimen, run: UpsettingRun, lab: dict[str, np.ndarray]) -> dict[str, float]:
    """Return the differences of the temperatures, twin less laboratory, of the rise; the larger of both speeds [%]."""
    state, found = run.at(FORCE), dict[str, contact_temperature.ContactTemperature]()
    errors: dict[str, float] = {}
    for speed in SPEEDS:
        contact = state.sliding(speed, 20.0, 20.0, ThermalSettings().constant())
        upsetting.rest(contact, WAIT)
        found["rest"] = contact.contact
        step, means = 0.25 * contact.cell, []
        for _ in range(round(DISTANCE / step)):
            means.append(contact.advance(step / speed, step, MU * FORCE * speed))
        mean = np.mean([(m.plate, m.specimen) for m in means], axis=0)
        for name, value, true in zip(("T_plate", "T_specimen"), mean, lab[f"{speed:g}"]):
            error = 100.0 * (value - true) / (true - 20.0)
            errors[name] = max(errors.get(name, 0.0), error, key=abs)
    rest = float(lab["rest"].mean())
    errors["T_rest"] = 100.0 * (found["rest"].mean - rest) / (rest - 20.0)
    return errors


@pytest.fixture(scope="module")
def run(filled: Specimen) -> UpsettingRun:
    return UpsettingRun(robust_upset(filled.case), filled.case)


def test_the_twin_is_as_warm_as_the_laboratory(
    filled: Specimen, run: UpsettingRun, lab_warmth: dict[str, np.ndarray]
) -> None:
    assert beyond(heat_errors(filled, run, lab_warmth)) == set()


def heat_error(of: Specimen) -> float:
    """Return the difference of the heat of upsetting, twin less laboratory, of the rise [%]."""
    state = UpsettingRun(robust_upset(of.case), of.case).at(FORCE)
    return 100.0 * ((state.T_specimen - of.case.T0) / of.rise - 1.0)


def test_heat_of_upsetting_is_that_of_the_laboratory_and_a_twentieth_less_shows(
    free: Specimen, monkeypatch: pytest.MonkeyPatch
) -> None:
    # without friction: the twin counts the work of friction as heat of the specimen, the laboratory leaves it out
    assert heat_error(free) == pytest.approx(0.0, abs=0.5)
    real = upsetting.heat_of_upsetting

    def lost(*arguments: Any) -> UpsettingHeat:
        heat = real(*arguments)
        return heat._replace(temperature=20.0 + 0.95 * (heat.temperature - 20.0))

    monkeypatch.setattr(upsetting, "heat_of_upsetting", lost)
    assert heat_error(free) < -4.0


@pytest.fixture
def planted(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """Plant a fault of the heat in the twin."""
    fault = str(request.param)
    real_layers, real_sweep = contact_temperature.layers, contact_temperature.sweep_depth
    if fault == "coarse layer":
        monkeypatch.setattr(
            contact_temperature, "layers", lambda first, growth, depth: real_layers(0.2, growth, depth)
        )
    elif fault == "start at the surface temperature":
        cold = UpsettingHeat(2.0 * 22.5 - 20.0, 0.0)
        monkeypatch.setattr(upsetting, "heat_of_upsetting", lambda *_: cold)
    else:
        factor = 2.0 if fault == "twice h" else 0.5

        def sweep(*arguments: Any) -> None:
            *others, h, share, punch = arguments
            real_sweep(*others, factor * h, share, punch)

        monkeypatch.setattr(contact_temperature, "sweep_depth", sweep)
    yield fault


@pytest.mark.parametrize(
    "planted", ["coarse layer", "twice h", "half h", "start at the surface temperature"], indirect=True
)
def test_a_fault_of_the_heat_shows(
    planted: str, filled: Specimen, run: UpsettingRun, lab_warmth: dict[str, np.ndarray]
) -> None:
    seen = beyond(heat_errors(filled, run, lab_warmth))
    assert ({"T_rest"} if planted.startswith("start") else {"T_plate", "T_specimen"}) & seen
