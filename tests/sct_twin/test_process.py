"""The incremental process: what a simulator drives step by step."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fmus.slaves.state_bytes import from_bytes, to_bytes
from fmus.slaves.twin_solver import TwinSolver
from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES
from sct_twin import RawCampaign, SctProcess, TwinResult
from sct_twin.twin.heat.thermal_settings import ThermalBody, ThermalSettings
from sct_twin.twin.process_uncertainty import process_uncertainties


@pytest.fixture(scope="module")
def process() -> SctProcess:
    return SctProcess(F_max=330e3, T_tool=100.0, speed=200.0)


def test_loads_of_a_test_that_is_driven_from_outside(process: SctProcess) -> None:
    start = process.snapshot()
    assert process.loads._fields == LOAD_NAMES
    process.advance(0.3, 330e3, 0.0, 100.0, 0.07)
    for _ in range(20):
        loads = process.advance(0.005, 330e3, 200.0, 100.0, 0.07)
    assert loads.sd == pytest.approx(20.0)
    assert loads.v_rel == 200.0
    assert loads.sigma_n == pytest.approx(330e3 / (np.pi / 4 * 15.51**2), rel=0.01)
    # A filled bore has the area ratio (15.51 / 15)^2; the mean by area now is a little more where psi varies.
    assert 1.069 < loads.psi < 1.074
    assert 200.0 < loads.T < process.T_max
    process.restore(start)


def test_a_rest_is_kept_under_a_wobbling_force_and_as_a_parameter() -> None:
    stepped = SctProcess(F_max=330e3, T_tool=100.0, T_specimen=120.0, speed=200.0)
    at_once = SctProcess(F_max=330e3, T_tool=100.0, T_specimen=120.0, speed=200.0, t_wait=5.0)
    start = stepped.advance(0.0, 330e3, 0.0, 100.0, 0.0)
    for k in range(100):
        stepped.advance(0.05, 330e3 * (1.0 + 0.003 * (-1) ** k), 0.0, 100.0, 0.0)
    rested = at_once.advance(0.0, 330e3, 0.0, 100.0, 0.0)
    # Upsetting has heated the specimen; plate and punch take that away while it lies there.
    assert start.T - 100.0 > 5.0
    assert stepped.loads.T < start.T - 2.0
    assert pytest.approx(stepped.loads.T - 100.0, rel=0.05) == rested.T - 100.0


def test_contact_belongs_to_the_highest_force_so_far() -> None:
    process = SctProcess(F_max=330e3, bore=20.0, T_tool=20.0, speed=100.0)
    small = process.advance(0.0, 150e3, 100.0, 20.0, 0.07)
    process.advance(0.01, 150e3, 100.0, 20.0, 0.07)
    unloaded = process.advance(0.01, 75e3, 100.0, 20.0, 0.07)
    assert unloaded.sigma_n == pytest.approx(0.5 * small.sigma_n, rel=1e-12)
    assert unloaded.psi == small.psi
    loaded = process.advance(0.01, 165e3, 100.0, 20.0, 0.07)
    assert loaded.psi > small.psi
    assert small.sigma_n < loaded.sigma_n < 1.1 * small.sigma_n


def test_driven_by_a_measurement_it_gives_the_loads_of_the_twin(
    tiny: RawCampaign, twinned: tuple[TwinResult, Path]
) -> None:
    result, _ = twinned
    tests = result.tests.set_index("test_id")
    for test_id in ("sct002", "sct005"):
        points = result.points[result.points["test_id"] == test_id]
        row = tests.loc[test_id]
        process = SctProcess(
            bore=row["bore"],
            tip=0.0 if np.isnan(row["tip"]) else row["tip"],
            F_max=float(points["F_n"].max()),
            T_tool=row["T_tool"],
            speed=float(points["v_rel"].max()),
            t_wait=row["t_wait"],
        )
        T, sigma_n = [], []
        t = sd = 0.0
        force = float(points["F_n"].iloc[0])
        process.advance(0.0, force, 0.0, row["T_tool"], 0.0)
        for point in points.itertuples():
            loads = process.advance(
                point.t - t, point.F_n, (point.sd - sd) / (point.t - t), row["T_tool"], point.mu
            )
            t, sd = point.t, point.sd
            T.append(loads.T)
            sigma_n.append(loads.sigma_n)
            assert loads.sd == pytest.approx(point.sd)
        rise = points["T"].to_numpy() - row["T_tool"]
        assert np.abs(np.array(T) - points["T"].to_numpy()).mean() < 0.01 * rise.mean()
        assert np.abs(np.array(sigma_n) / points["sigma_n"].to_numpy() - 1.0).max() < 0.005
        assert process.loads.psi == pytest.approx(points["psi"].iloc[-1], rel=0.005)
        inputs = np.diff(points[["t", "sd"]].to_numpy(), axis=0, prepend=0.0)
        dt, v = inputs[:, 0], inputs[:, 1] / inputs[:, 0]
        T_tool = np.full(len(dt), row["T_tool"])
        stated = process_uncertainties(
            process, dt, points["F_n"].to_numpy(), v, T_tool, points["mu"].to_numpy()
        )
        late = points["sd"].to_numpy() > 1.0
        for name, u in stated.items():
            assert u[1:][late] == pytest.approx(points[name].to_numpy()[late], rel=0.1), name


def test_snapshot_is_exact_and_can_be_used_again(process: SctProcess) -> None:
    start = process.snapshot()
    runs = []
    for _ in range(2):
        process.restore(start)
        runs.append([process.advance(0.002, 3e5 + 100.0 * k, 10.0 * k, 100.0, 0.06) for k in range(15)])
    assert runs[0] == runs[1]
    process.restore(start)
    assert process.time == 0.0 and process.loads.sd == 0.0


def test_state_as_bytes_is_exact_with_heat_data_that_vary() -> None:
    plate = ThermalBody(((20.0, 20.0), (400.0, 23.0)), ((20.0, 3.5), (400.0, 4.4)))
    process = SctProcess(F_max=330e3, speed=200.0, thermal=ThermalSettings(plate=plate))
    process.advance(0.0, 330e3, 0.0, 20.0, 0.0)
    for _ in range(4):
        process.advance(0.005, 330e3, 200.0, 20.0, 0.07)
    content = to_bytes(process.snapshot(), "twin", TwinSolver.snapshot_classes)
    going_on = [process.advance(0.005, 320e3, 150.0, 20.0, 0.08) for _ in range(4)]
    process.restore(from_bytes(content, "twin", TwinSolver.snapshot_classes))
    assert [process.advance(0.005, 320e3, 150.0, 20.0, 0.08) for _ in range(4)] == going_on
    # The same plate at the data of 20 degC is hotter: both grow with temperature.
    steady = SctProcess(F_max=330e3, speed=200.0, thermal=ThermalSettings(plate=plate).constant())
    steady.advance(0.0, 330e3, 0.0, 20.0, 0.0)
    for _ in range(4):
        hotter = steady.advance(0.005, 330e3, 200.0, 20.0, 0.07)
    for _ in range(4):
        hotter = steady.advance(0.005, 320e3, 150.0, 20.0, 0.08)
    assert hotter.T > going_on[-1].T + 2.0


def test_less_friction_less_heat(process: SctProcess) -> None:
    start = process.snapshot()
    hot = [process.advance(0.01, 330e3, 200.0, 100.0, 0.10) for _ in range(10)][-1]
    process.restore(start)
    cool = [process.advance(0.01, 330e3, 200.0, 100.0, 0.05) for _ in range(10)][-1]
    process.restore(start)
    assert pytest.approx(2.0 * (cool.T - 100.0), rel=0.05) == (hot.T - 100.0)


def test_impossible_inputs(process: SctProcess) -> None:
    with pytest.raises(InputError, match="mu = nan; allowed: 0 to 10"):
        process.advance(0.01, 1e5, 100.0, 20.0, float("nan"))
    with pytest.raises(InputError, match=r"t_wait = -1 s; allowed: 0 to 100000 s"):
        SctProcess(t_wait=-1)
    with pytest.raises(InputError, match="F_max = -1"):
        SctProcess(F_max=-1.0)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"mesh_size": float("inf")}, r"mesh_size = inf mm; allowed: 0\.1 to 5 mm"),
        ({"speed": 1e30}, r"speed = 1e\+30 mm/s; allowed: 1e-06 to 100000 mm/s"),
        ({"F_max": "much"}, r"F_max = 'much' N; allowed: 1000 to 5e\+06 N"),
        ({"T_tool": None}, r"T_tool = None degC; allowed: -273\.15 to 2000 degC"),
        ({"thermal": -1}, "thermal = -1; allowed: ThermalSettings, or None"),
    ],
)
def test_numbers_that_are_none_are_refused(given: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=f"SCT process: {words}"):
        SctProcess(**given)


def test_a_force_beyond_that_of_upsetting_is_refused_and_up_to_it_the_contact_grows() -> None:
    small, large = (SctProcess(F_max=F_max, bore=0.0) for F_max in (200e3, 300e3))
    with pytest.raises(
        InputError, match=r"F_n = 250000\.0 N; allowed: 0 to 220000 N, as .* F_max = 200000 N"
    ):
        small.advance(0.2, 250e3, 50.0, 20.0, 0.08)
    found, wanted = (p.advance(0.2, 215e3, 50.0, 20.0, 0.08) for p in (small, large))
    assert found.sigma_n == pytest.approx(wanted.sigma_n, rel=0.01)
    assert found.psi == pytest.approx(wanted.psi, rel=0.01)


def test_loads_before_the_force_are_not_those_of_the_force() -> None:
    """A schedule may start unloaded: surface and temperature follow the force up, and never go back."""
    process = SctProcess(F_max=400e3, bore=29.0)
    forces = [0.0, 10.0, 900.0, 5e4, 2e5, 4e5, 4e5]
    loads = [process.advance(0.05, F_n, 0.0, 20.0, 0.0) for F_n in forces]
    psi, T = [x.psi for x in loads], [x.T for x in loads]
    assert psi[:3] == pytest.approx([1.0] * 3, abs=0.01)
    assert T[:3] == pytest.approx([20.0] * 3, abs=0.01)
    assert np.all(np.diff(psi) >= 0.0)
    assert psi[-1] > 2.0
    assert np.all(np.diff(T[:-1]) >= -1e-9)  # then it cools


def test_friction_of_upsetting_that_cannot_be_is_refused_by_its_name() -> None:
    with pytest.raises(InputError, match=r"SCT process: upsetting_mu = -1\.0; allowed: 0 to 10"):
        SctProcess(upsetting_mu=-1.0)
