"""Ejection and stripping: against the closed form of a shrink fit, and for both processes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from forming import BackwardCupExtrusion, ForwardRodExtrusion, Upsetting
from forming.fe.body import Body
from forming.fe.mesh.mesher import grid_mesh
from forming.fe.simulation import Simulation
from forming.fe.tooling import Tool, flat_punch, line
from forming.materials.materials import steel_16MnCr5
from forming.processes.base import FormingProcess
from forming.processes.ejection import Ejection
from forming.results.ejection_result import load_ejection
from forming.results.files import load_result
from forming.results.pictures.page import report_page
from forming.tools.ejection_tools import Stage, ejector, opened
from friction_models.common import InputError

RADIUS, LENGTH, START = 10.0, 20.0, 100.0
COARSE = {"mesh_size": 0.8, "n_points": 40, "tool_heating": False}


class ShrinkFit(FormingProcess):
    """An elastic cylinder that presses on a bore with a pressure `START` [MPa] all along."""

    name = "shrink fit"
    ejections = ("ejector",)
    n_points = 30
    T_billet = 20.0
    max_stroke = 1.0

    def __init__(self) -> None:
        self.speed = 5.0

    def _build(self) -> Simulation:
        mesh = grid_mesh(np.linspace(0.0, RADIUS, 13), np.linspace(0.0, LENGTH, 25))
        chain = np.ascontiguousarray(mesh.loop[: 2 * 12 + 24 + 1])
        body = Body.at_rest(mesh.x, mesh.quads, chain, 20.0)
        bore = Tool("container", np.array([line((RADIUS, -40.0), (RADIUS, 60.0))]))
        tools = [bore, flat_punch(LENGTH + 5.0, 5.0, widest=RADIUS)]
        arc = np.linspace(0.0, 2.0 * RADIUS + LENGTH, self.n_points)
        simulation = Simulation(body, tools, steel_16MnCr5(), arc, isothermal=True)
        body.x[:, 0] *= 1.0 + START / simulation.settings.penalty / RADIUS
        body.stress[:, :, [0, 2]] = -START
        # The force and the stroke that stand for a forming stroke.
        simulation.state.forces = np.array([[0.0, 0.0], [0.0, 1e5]])
        simulation.state.stroke = 1.0
        return simulation

    def ejection_stage(self, how, number, state):
        if number:
            return None
        pin = ejector(0.98 * RADIUS, state.body.surface, 5.0, 20.0)
        tools = (opened(state.tools[0], RADIUS, 30.0), pin)
        return Stage("eject", tools, "ejector", longest=1.0, opening=28.0)


@pytest.mark.parametrize("mu", [0.05, 0.15])
def test_push_out_force_of_a_shrink_fit(mu):
    """Shear-lag of a rod in a stiff bore: F = pi R2 p0 / b (exp(2 mu b L / R) - 1), from equilibrium and Hooke.

    The pressure grows with the axial stress q that the ejector brings in, by b q; the contact of stiffness c
    [MPa/mm] gives way: b = nu / (1 - nu + E / (c R)). At q = 0 it is 2 pi R L mu p0.
    """
    process = ShrinkFit()
    process.start(mu)
    result = Ejection(process).run(mu)
    material, penalty = process.simulation.material, process.simulation.settings.penalty
    K, G = material.bulk_modulus, material.shear_modulus
    E, nu = 9.0 * K * G / (3.0 * K + G), (3.0 * K - 2.0 * G) / (2.0 * (3.0 * K + G))
    b = nu / (1.0 - nu + E / (penalty * RADIUS))
    expected = math.pi * RADIUS**2 * START / b * (math.exp(2.0 * mu * b * LENGTH / RADIUS) - 1.0)
    assert expected > 2.0 * math.pi * RADIUS * LENGTH * mu * START
    steady = result.force[result.travel > 0.5]
    assert result.status == "ok" and steady == pytest.approx(expected * 1e-3, rel=0.01)
    assert result.grip[-1] == pytest.approx(steady[-1], rel=2e-3)


@pytest.fixture(scope="module")
def rods():
    """Two millimetres are enough to press the billet against die and container."""
    rigid = ForwardRodExtrusion(**COARSE, billet_length=16.0)
    elastic = ForwardRodExtrusion(**COARSE, billet_length=16.0, die_outer_diameter=60.0)
    return [(process, process.run(0.08, 2.0, eject=True)) for process in (rigid, elastic)]


def test_rod_is_pushed_out_against_the_friction_of_what_grips_it(rods):
    process, result = rods[0]
    found = result.ejection
    assert found.status == "ok" and found.how == "ejector" and set(found.phase) == {"withdraw", "eject"}
    back, out = found.of_phase("withdraw"), found.of_phase("eject")
    # The punch starts from the forming force and ends free.
    assert found.force[back][0] == pytest.approx(-result.force[-1], rel=0.05)
    assert abs(found.force[back][-1]) < 0.01 * result.force[-1] and found.work[back][-1] < 0.0
    assert found.travel[back][-1] < 0.02 * 16.0
    sliding = out & (found.travel > 0.5)
    assert np.median(np.abs(found.force / found.grip - 1.0)[sliding]) < 0.01
    # The rounding of the die lets go at once, the container goes on gripping: the largest force is that of the first moment.
    held = sum(patch.friction for patch in found.patches)
    then = out & (found.travel > 0.2)
    assert found.force[then].max() == pytest.approx(found.grip[then].max(), rel=0.01)
    assert 0.5 * held < found.force[then].max() <= found.max_force < 1.1 * held
    # The end is where the head, 16 mm long, stands in the opening of the container only.
    assert 12.0 < found.travel[-1] < 20.0
    assert {patch.tool for patch in found.patches} == {"die"}
    assert found.total_work == pytest.approx(found.work[out][-1], rel=0.02)
    assert abs(found.energy_balance) < 5e-3
    # The process stands where the stroke ended.
    assert process.stroke == 2.0 and process.force == result.force[-1]


def test_a_die_that_springs_back_grips_harder(rods):
    rigid, elastic = (result.ejection for _, result in rods)
    assert elastic.max_force > 1.2 * rigid.max_force
    assert elastic.total_work > 1.2 * rigid.total_work


def test_result_files_keep_the_ejection(rods, tmp_path):
    result = rods[0][1]
    result.save(tmp_path / "run")
    read, _ = load_result(tmp_path / "run")
    assert read.ejection is not None
    assert read.ejection.patches == result.ejection.patches
    assert read.ejection.phase == result.ejection.phase
    assert read.ejection.force == pytest.approx(result.ejection.force, rel=1e-8)
    assert np.array_equal(read.ejection.contact.loads, result.ejection.contact.loads)
    assert read.ejection.to_frame().columns.tolist() == ["phase", "travel", "force", "work", "grip"]
    whole = {name: (tmp_path / "run" / name).read_text() for name in ("ejection.csv", "ejection.json")}
    for name, old, new, words in (
        ("ejection.csv", "travel", "way", "ejection.csv holds other columns"),
        ("ejection.csv", "withdraw,", "fly,", "ejection.csv holds a phase that is none of withdraw"),
        ("ejection.csv", "withdraw,", f"withdraw{'x' * 200_000},", "field larger than field limit"),
        ("ejection.csv", "eject,0", "eject,nan\nwithdraw,0", "other columns or rows"),
        ("ejection.json", '"pressure": ', f'"pressure": 1{"0" * 400}, "mean": ', "too large"),
        ("ejection.json", '"tool"', '"tol"', "'tool'"),
        ("ejection.json", '"pressure": ', '"pressure": 1e400, "mean": ', "mean"),
        (
            "ejection.json",
            '"energy_balance": ',
            '"energy_balance": NaN, "more": ',
            "numbers that are not finite",
        ),
        ("ejection.json", "{", "[", ""),
    ):
        (tmp_path / "run" / name).write_text(whole[name].replace(old, new, 1))
        with pytest.raises(InputError, match=f"cannot be read .*{words}"):
            load_result(tmp_path / "run")
        (tmp_path / "run" / name).write_text(whole[name])
    assert load_ejection(tmp_path) is None
    page = report_page(read)
    assert f"Largest force of the ejector {read.ejection.max_force:.1f} kN" in page
    assert page.count("punch withdrawn: travel") == 2 and page.count("ejector pushes: travel") == 2
    assert f"<td>{read.ejection.patches[0].friction:.2f}</td>" in page


def test_cup_is_stripped_and_ejected():
    process = BackwardCupExtrusion(**COARSE, billet_length=12.0)
    formed = process.run(0.08, 4.0, eject="ejector")
    ejected, stripped = formed.ejection, Ejection(process).run(0.08)
    assert ejected.status == stripped.status == "ok"
    assert list(dict.fromkeys(ejected.phase)) == ["withdraw", "release", "eject"]
    assert stripped.how == "stripper" and set(stripped.phase) == {"withdraw"}
    # Both begin alike: the wall that has sprung onto the shaft is dragged over the land.
    assert stripped.max_force == ejected.largest("withdraw") > 0.01 * formed.max_force
    assert stripped.force[-1] == pytest.approx(0.0, abs=0.05)
    sliding = ejected.of_phase("eject") & (ejected.travel > 0.5)
    assert np.median(np.abs(ejected.force / ejected.grip - 1.0)[sliding]) < 0.01
    assert {"container", "plate"} <= {patch.tool for patch in ejected.patches}
    # Without friction nothing holds.
    free = Ejection(process, "ejector").run(lambda loads, t: np.zeros(len(loads)))
    assert free.largest("eject") < 0.01 * ejected.max_force


def test_a_snapshot_goes_on_bit_by_bit_across_the_phases():
    process = ForwardRodExtrusion(**COARSE, billet_length=16.0)
    process.run(0.08, 1.5)
    ejection = Ejection(process)
    kept = ejection.snapshot()

    def go_on():
        while ejection.stage.name == "withdraw" or len(ejection.contact.stroke) < 8:
            assert ejection.advance(0.1), ejection.message
            ejection.set_mu(0.05 + 1e-3 * ejection.loads()[:, 3])
        found = ejection.result()
        return found.force, found.grip, found.phase, ejection.loads(), found.contact.mu

    first = go_on()
    assert set(first[2]) == {"withdraw", "eject"}
    ejection.restore(kept)
    for a, b in zip(first, go_on()):
        assert np.array_equal(a, b)


def test_what_stops_or_fails_keeps_what_there_is():
    process = ForwardRodExtrusion(**COARSE, billet_length=16.0)

    def law(loads, t):
        if t > 0.105:
            raise InputError("friction: no value here")
        return np.full(len(loads), 0.08)

    with pytest.raises(InputError, match="no value here"):
        process.run(law, 0.5, eject=True)
    kept = process.result
    assert kept is not None and kept.status == "ok" and kept.ejection is not None
    assert kept.ejection.status == "stopped" and "no value here" in kept.ejection.message
    assert len(kept.ejection.force) > 3 and np.isfinite(kept.ejection.force).all()
    ejection = Ejection(process)
    ejection.simulation.state.body.T[:] = np.nan
    assert not ejection.advance(0.1)
    assert ejection.status == "stopped" and "withdraw: stopped at travel" in ejection.message


def test_what_cannot_be_ejected_is_refused():
    process = ForwardRodExtrusion(**COARSE)
    with pytest.raises(InputError, match="did you mean 'ejector'"):
        process.run(0.08, 0.1, eject="ejektor")
    with pytest.raises(InputError, match=r"upsetting: eject = True; allowed: False"):
        Upsetting().run(0.08, 0.1, eject=True)
    process.start(0.08)
    with pytest.raises(InputError, match=r"eject at stroke 0 mm.*allowed: after a stroke"):
        Ejection(process)
    stopped = replace(process.simulation.state, status="stopped", stroke=1.0)
    process.simulation.state = stopped
    with pytest.raises(InputError, match="status 'stopped'"):
        Ejection(process)
    for kind, widest in ((ForwardRodExtrusion, "13.8572"), (BackwardCupExtrusion, "19.6")):
        with pytest.raises(InputError, match=rf"ejector_diameter = 30\.0 mm; allowed: .* to {widest} mm"):
            kind(ejector_diameter=30.0)
