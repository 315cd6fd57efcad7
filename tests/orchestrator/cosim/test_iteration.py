"""The iterated mode where repetitions swing, are noisy, do not agree, or cannot be made."""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from fmus.runtime.fmu_variables import Variable
from fmus.runtime.ports import Port
from friction_models.common import InputError
from friction_models.loads import FloatArray
from orchestrator import Master, SimulationError, System
from orchestrator.cosim.iteration import DAMPED_AFTER, PATIENCE, FixedPointIteration
from orchestrator.cosim.setup.wiring import Link, Wiring
from tests.orchestrator import tiny_fmus
from tests.orchestrator.tiny_fmus import system_content

H, OFFSET = 0.1, 0.1


@pytest.fixture(scope="module")
def swinging(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Friction that falls steeply with the load: the second point swings to twice the other side."""
    return tiny_fmus.law(tmp_path_factory.mktemp("swinging"), "SwingingLaw", slope=-10.0)


def test_a_step_that_swings_is_damped(swinging: Path, tiny: dict[str, Path], tmp_path: Path) -> None:
    system = System.from_dict(system_content(swinging, tiny["process"], stop_time=0.2))
    master = Master(system, mode="iterated")
    run = master.run(tmp_path / "run")
    gain = np.array([1.0, 2.0]) * H
    loads = [np.ones(2)]
    for _ in range(2):
        loads.append((loads[-1] + gain * OFFSET) / (1.0 + 10.0 * gain))
    np.testing.assert_allclose(run["forming.load"], loads, rtol=1e-6)
    assert min(master.course.iterations) > DAMPED_AFTER
    made = run.manifest["iterations"]
    assert (
        made["total"] == sum(master.course.iterations) and made["largest_change"] <= made["tolerance"] == 1e-8
    )


def test_a_wider_tolerance_needs_fewer_repetitions(tiny: dict[str, Path], tmp_path: Path) -> None:
    system = System.from_dict(system_content(tiny["law"], tiny["process"], stop_time=0.2))
    masters = [Master(system, "iterated", tolerance=t) for t in (1e-3, 1e-10)]
    runs = [m.run(tmp_path / str(k)) for k, m in enumerate(masters)]
    assert sum(masters[0].course.iterations) < sum(masters[1].course.iterations)
    assert max(masters[1].course.changes) <= 1e-10 < max(masters[0].course.changes) <= 1e-3
    np.testing.assert_allclose(runs[0]["forming.load"], runs[1]["forming.load"], rtol=1e-3)
    with pytest.raises(InputError, match=r"tolerance = 0\.0, allowed: more than 0"):
        Master(system, "iterated", tolerance=0.0)


def test_repetitions_that_never_agree_are_reported(tiny: dict[str, Path], tmp_path: Path) -> None:
    steep = tiny_fmus.law(tmp_path, "SteepLaw", slope=-20.0)
    system = System.from_dict(system_content(steep, tiny["process"]))
    with pytest.raises(
        SimulationError,
        match=r"step at t = 0 s did not converge in 50 repetitions: \w+\.\w+ -> \w+\.\w+ still changes by .* %",
    ):
        Master(system, "iterated").run(tmp_path / "run")


def test_an_fmu_without_states_is_named(tiny: dict[str, Path], tmp_path: Path) -> None:
    with zipfile.ZipFile(tiny["process"]) as source, zipfile.ZipFile(tmp_path / "p.fmu", "w") as target:
        for item in source.infolist():
            data = source.read(item)
            if item.filename == "modelDescription.xml":
                assert b'canGetAndSetFMUstate="true"' in data
                data = data.replace(b'canGetAndSetFMUstate="true"', b'canGetAndSetFMUstate="false"')
            target.writestr(item, data)
    system = System.from_dict(system_content(tiny["law"], tmp_path / "p.fmu"))
    with pytest.raises(
        InputError, match=r"component 'forming' cannot save its state.*allowed for it: gauss_seidel"
    ):
        Master(system, mode="iterated")
    Master(system)


class Settling:
    """A step of friction, which follows the loads as they are passed on, and forming, whose loads a test makes."""

    def __init__(
        self, tiny: dict[str, Path], law: Callable[[FloatArray], FloatArray] = lambda loads: 0.1 * loads + 1.0
    ) -> None:
        wiring = Wiring.of(System.from_dict(system_content(tiny["law"], tiny["process"])))
        outputs = {link.source: Port(link.sources) for link in wiring.links}
        self.follows = FixedPointIteration(wiring.links, outputs, ["friction", "forming"])
        self.law, self.loads, self._mu = law, outputs["forming"].values, outputs["friction"].values

    def repetitions(self, most: int) -> Iterator[int]:
        """Count the repetitions of a step; what comes of one is passed on before the next."""
        self._mu[:] = self.law(self.loads)
        self.follows.begin()
        for repetition in range(1, most + 1):
            if repetition > 1:
                self.follows.pass_on()
            self._mu[:] = self.law(self.loads)
            yield repetition


def test_what_a_solver_cannot_resolve_counts_as_agreement(tiny: dict[str, Path]) -> None:
    step = Settling(tiny)
    for repetition in step.repetitions(29):
        # The solver stops somewhere within 1e-6 of the solution.
        step.loads[:] = 100.0 * (1.0 + 1e-6 * (-1) ** repetition)
        if step.follows.converged():
            break
    assert 2 + PATIENCE <= repetition < 2 + 2 * PATIENCE
    assert step.follows.change == pytest.approx(2e-6 * 10.0 / 11.0, rel=1e-3)
    assert step.follows.where.startswith("friction.mu -> ")


def test_a_coarse_swing_does_not_count_as_agreement(tiny: dict[str, Path]) -> None:
    step = Settling(tiny)
    for repetition in step.repetitions(29):
        step.loads[:] = 100.0 * (1.0 + 1e-3 * (-1) ** repetition)
        assert not step.follows.converged()


def test_loads_may_change_where_friction_does_not(tiny: dict[str, Path]) -> None:
    """A point whose speed the solver leaves open by half a per cent, with a law that hardly follows it."""
    step = Settling(tiny, lambda loads: 1e-4 * loads + 1.0)
    for repetition in step.repetitions(29):
        step.loads[:] = 100.0 * (1.0 + 2.5e-3 * (-1) ** repetition)
        if step.follows.converged():
            break
    assert repetition < DAMPED_AFTER
    assert step.follows.change < 1e-4


def test_the_same_from_two_means_does_not_count_as_agreement(tiny: dict[str, Path]) -> None:
    """Up to 76 all gives 100, and 100 gives nothing: the means 50 and 75 give the same, and the solution is 85.88."""
    step = Settling(tiny)
    for _ in step.repetitions(50):
        step.loads[:] = np.interp(step.loads, [76.0, 90.0, 100.0], [100.0, 80.0, 0.0])
        if step.follows.converged():
            break
    assert step.follows.repetitions > DAMPED_AFTER
    np.testing.assert_allclose(step.loads, (100.0 + 76.0 / 0.7) / (1.0 + 1.0 / 0.7), rtol=1e-7)


def test_a_point_that_touches_in_every_other_repetition_keeps_the_friction_of_the_start(
    tiny: dict[str, Path],
) -> None:
    step = Settling(tiny, lambda loads: np.where(loads < 55.0, 1.0, 0.5))
    step.loads[:] = [80.0, 0.0]
    for _ in step.repetitions(50):
        # The second point touches where its friction is that of no load; the first one, where it touches, is pressed less.
        touches = step.loads[1] < 55.0
        step.loads[:] = [90.0 if touches else 100.0, 100.0 if touches else 0.0]
        if step.follows.converged():
            break
    assert step.loads.tolist() == [90.0, 100.0]
    assert step.follows.repetitions <= DAMPED_AFTER + 2 * PATIENCE


@pytest.mark.parametrize("closed", [True, False])
def test_what_reaches_the_last_component_after_several_repetitions_is_waited_for(closed: bool) -> None:
    """Components a, b and c hand a number on, and run the wrong way round; where the loop is closed, half of it comes back to a."""
    variable = {name: Variable(name, 1, "Real", "output", "1") for name in "abc"}
    ways = ["ab", "bc", *(["ca"] if closed else [])]
    links = [Link(s, (variable[s],), t, (variable[s],)) for s, t in ways]
    outputs = {name: Port([variable[name]]) for name in "abc"}
    follows, (a, b, c) = (
        FixedPointIteration(links, outputs, ["c", "b", "a"]),
        (outputs[n].values for n in "abc"),
    )
    follows.begin()
    for repetition in range(50):
        if repetition:
            follows.pass_on()
        c[:], b[:] = b, a
        a[:] = 1.0 + (0.5 * c if closed else 0.0)
        if follows.converged():
            break
    np.testing.assert_allclose(np.r_[a, b, c], 2.0 if closed else 1.0, rtol=1e-3)


def several(
    points: int, law: Callable[[FloatArray, int], FloatArray]
) -> tuple[FixedPointIteration, FloatArray, FloatArray]:
    """Repeat a step whose loads follow a law of those that friction heard; return the iteration, the loads and what was heard."""
    loads, mu = (
        [Variable(f"{n}[{k}]", k, "Real", "output", "1") for k in range(points)] for n in ("p", "mu")
    )
    ways = [("forming", tuple(loads), "friction"), ("friction", tuple(mu), "forming")]
    outputs = {"forming": Port(loads), "friction": Port(mu)}
    follows = FixedPointIteration([Link(*way, way[1]) for way in ways], outputs, ["friction", "forming"])
    carried = outputs["forming"].values
    carried[:] = outputs["friction"].values[:] = 50.0
    follows.begin()
    for repetition in range(50):
        if repetition:
            follows.pass_on()
        heard = outputs["friction"].values[:] = carried.copy()
        carried[:] = law(heard, repetition)
        if follows.converged():
            break
    return follows, carried, heard


def test_few_values_that_never_settle_lag_and_are_counted() -> None:
    """One point of 20 has no solution, and moves its neighbours: what it hears is never what it says."""

    def law(heard: FloatArray, repetition: int) -> FloatArray:
        loads = 60.0 + 0.1 * heard + 0.01 * heard[3]
        loads[3] = 90.0 if heard[3] < 60.0 else 30.0 + 0.01 * repetition
        return loads

    follows, loads, heard = several(20, law)
    assert follows.repetitions < 45
    assert follows.lagging == 1
    assert heard[3] == 50.0
    np.testing.assert_allclose(np.delete(loads, 3), (60.0 + 0.5) / 0.9, rtol=1e-3)


def test_many_values_that_never_settle_are_no_solution() -> None:
    follows, _, _ = several(
        20, lambda heard, repetition: np.where(heard < 60.0, 90.0 + 0.01 * repetition, 30.0)
    )
    assert follows.repetitions == 50
    assert follows.change > 0.1


def test_a_step_that_settles_slowly_is_taken_where_repetitions_end() -> None:
    follows, loads, _ = several(
        2, lambda heard, repetition: 100.0 - 2.5 * np.clip(heard - 100.0, -20.0, 13.0)
    )
    assert follows.repetitions == 50
    assert 1e-8 < follows.change < 1e-4
    np.testing.assert_allclose(loads, 100.0, rtol=1e-3)
