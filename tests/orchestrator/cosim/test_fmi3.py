"""FMI 3.0 friction FMUs in the master: they take the place of FMI 2.0 ones without a change of the system."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fmus import pack
from fmus.runtime.fmu_files import describe
from friction_models import LinearFriction, effects
from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES
from orchestrator import Master, System
from tests.friction_models.made_up import campaign
from tests.orchestrator.native_fmus import Real, native_fmu

POINTS, STEPS, STEP = 7, 12, 0.01


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return one model with memory as FMUs of both versions, and a process with POINTS markers."""
    folder = tmp_path_factory.mktemp("fmi3")
    points = campaign(tests=6, points=20)
    worn = points.assign(mu=points["mu"] + 0.03 * (1.0 - np.exp(-points["sd"] / 3.0)))
    model = (LinearFriction() + effects.WorkExhaustion(W_c=0.4, n=1.0)).fit_frame(worn)
    names = [f"[{k + 1}]" for k in range(POINTS)]
    units = {"v_rel": "mm/s", "T": "degC", "sigma_n": "MPa", "sd": "mm", "psi": "1"}
    variables = [Real(f"{q}{i}", "output", unit=units[q]) for q in LOAD_NAMES for i in names]
    variables += [Real(f"mu{i}", "input", 0.05) for i in names]
    variables += [Real("force", "output", unit="kN"), Real("T_all", "output", unit="degC")]
    lines = []
    for k in range(1, POINTS + 1):
        lines += [
            f"V(v_rel_{k}) = {40.0 + 10.0 * k!r} - 100.0 * V(mu_{k});",
            f"V(T_{k}) = 60.0 + {5.0 * k!r} * t;",
            # the last point comes into contact later
            f"V(sigma_n_{k}) = {'t < 0.055 ? 0.0 : 900.0' if k == POINTS else 900.0};",
            f"V(psi_{k}) = 1.2 + 0.02 * V(sd_{k});",
        ]
    lines += [
        "V(T_all) = 70.0;",
        "V(force) = " + " + ".join(f"V(mu_{k})" for k in range(1, POINTS + 1)) + ";",
    ]
    step = "\n".join(f"V(sd_{k}) += V(v_rel_{k}) * h;" for k in range(1, POINTS + 1))
    return {
        "one": pack(model, folder / "one.fmu"),
        "all": pack(model, folder / "all.fmu", nodes=POINTS),
        "three": pack(model, folder / "three.fmu", fmi="3.0", arrays=True),
        "scalars": pack(model, folder / "scalars.fmu", fmi="3.0"),
        "long": pack(model, folder / "long.fmu", fmi="3.0", nodes=9),
        "process": native_fmu(folder / "process.fmu", variables, "\n".join(lines), step),
    }


def system(fmu: dict[str, Path], friction: str, **changes: object) -> System:
    connections = [f"process.{q} -> friction.{q}" for q in LOAD_NAMES] + ["friction.mu -> process.mu"]
    content: dict[str, object] = {
        "communication_step": STEP,
        "stop_time": STEP * STEPS,
        "components": {"friction": {"fmu": str(fmu[friction])}, "process": {"fmu": str(fmu["process"])}},
        "connections": connections,
        "record": ["process.force", "process.sd", "friction.mu"],
    }
    return System.from_dict(content | changes)


@pytest.mark.parametrize(
    "mode", ["iterated", *(pytest.param(m, marks=pytest.mark.nightly) for m in ("gauss_seidel", "jacobi"))]
)
def test_swapping_versions_changes_nothing(fmu: dict[str, Path], tmp_path: Path, mode: str) -> None:
    base = system(fmu, "all")
    runs = {
        which: Master(base.swap("friction", fmu[which]), mode).run(tmp_path / which)
        for which in ("all", "one", "three", "long", "scalars")
    }
    assert np.ptp(runs["all"]["friction.mu"][-1]) > 1e-4, "points must differ"
    for which in ("one", "three", "long", "scalars"):
        for name in ("process.force", "process.sd", "friction.mu"):
            np.testing.assert_allclose(runs[which][name], runs["all"][name], rtol=1e-13)
    assert runs["three"]["friction.mu"].shape == (STEPS + 1, POINTS)
    assert runs["three"].manifest["components"]["friction"]["instances"] == 1


def test_a_vector_of_one_is_a_scalar(fmu: dict[str, Path]) -> None:
    description = describe(fmu["three"])
    assert description.version == "3.0" and description.is_scalar_friction
    assert [v.name for v in description.resolve("mu")] == ["mu"]
    sized = description.sized({"n": 3})
    assert [v.name for v in sized.resolve("mu")] == ["mu[1]", "mu[2]", "mu[3]"]
    assert len({v.reference for v in sized.resolve("mu")}) == 1
    assert sized.resolve("mu")[0].type == "Real"


def test_length_by_start_value_and_what_is_refused(fmu: dict[str, Path]) -> None:
    parts = {"process": {"fmu": str(fmu["process"])}}

    def friction(n: object) -> dict[str, object]:
        return {"components": parts | {"friction": {"fmu": str(fmu["three"]), "start": {"n": n}}}}

    system(fmu, "three", **friction(POINTS)).validate()
    with pytest.raises(InputError, match=r"7 elements, friction\.v_rel has 3"):
        system(fmu, "three", **friction(3)).validate()
    with pytest.raises(InputError, match=r"'n' = 2.5, allowed: a whole number"):
        system(fmu, "three", **friction(2.5)).validate()
    with pytest.raises(InputError, match="structural parameter 'n' = 0, allowed: 1 to"):
        system(fmu, "three", **friction(0)).validate()


@pytest.mark.parametrize("which", ["one", "three", "long", "scalars"])
def test_one_value_for_all_points(fmu: dict[str, Path], tmp_path: Path, which: str) -> None:
    connections = [
        "process.T_all -> friction.T" if q == "T" else f"process.{q} -> friction.{q}" for q in LOAD_NAMES
    ]
    connections.append("friction.mu -> process.mu")
    base = system(fmu, which, connections=connections, record=["friction.T"])
    run = Master(base).run(tmp_path / "run")
    np.testing.assert_array_equal(run["friction.T"], np.full((STEPS + 1, POINTS), 70.0))


def test_a_long_array_becomes_a_scalar(fmu: dict[str, Path], tmp_path: Path) -> None:
    connections = [f"process.{q}[1] -> friction.{q}" for q in LOAD_NAMES] + ["friction.mu -> process.mu[1]"]
    parts = {
        "friction": {"fmu": str(fmu["one"])},
        "process": {"fmu": str(fmu["process"]), "start": {"mu": 0.1}},
    }
    base = system(fmu, "one", components=parts, connections=connections)
    one = Master(base).run(tmp_path / "one")
    long = Master(base.swap("friction", fmu["long"])).run(tmp_path / "long")
    np.testing.assert_allclose(long["friction.mu"], one["friction.mu"], rtol=1e-13)
    assert long["friction.mu"].shape == (STEPS + 1,)
    with pytest.raises(InputError, match=r"more than one element by default.*--nodes 1"):
        base.swap("friction", fmu["long"]).export(tmp_path / "x.ssp")


def test_part_of_an_array_is_connected(fmu: dict[str, Path], tmp_path: Path) -> None:
    """Elements that nothing feeds keep what was set at the start; an index makes the array grow."""
    connections = [f"process.{q}[{k}] -> friction.{q}[{k}]" for q in LOAD_NAMES for k in (1, 3)]
    start = {"v_rel": 20.0, "T": 33.0, "sigma_n": 500.0, "sd": 1.0, "psi": 1.5}
    parts = {
        "friction": {"fmu": str(fmu["three"]), "start": start},
        "process": {"fmu": str(fmu["process"]), "start": {"mu": 0.1}},
    }
    run = Master(
        system(fmu, "three", connections=connections, components=parts, record=["friction.T", "process.T"])
    ).run(tmp_path / "run")
    assert run["friction.T"].shape == (STEPS + 1, 3)
    np.testing.assert_array_equal(run["friction.T"][:, 1], 33.0)
    np.testing.assert_array_equal(run["friction.T"][1:, [0, 2]], run["process.T"][:-1, [0, 2]])


def test_errors_of_fmi3_name_variable_and_component(fmu: dict[str, Path], tmp_path: Path) -> None:
    from orchestrator import SimulationError

    parts = {
        "friction": {"fmu": str(fmu["three"])},
        "process": {"fmu": str(fmu["process"]), "start": {"mu": 1e308}},
    }
    connections = [f"process.{q} -> friction.{q}" for q in LOAD_NAMES]
    with pytest.raises(SimulationError, match=r"component 'friction' failed at t = .*v_rel"):
        Master(system(fmu, "three", components=parts, connections=connections)).run(tmp_path / "run")


def test_booleans_in_and_out(fmu: dict[str, Path], tmp_path: Path) -> None:
    """Outside the domain mu depends on the switch, and in_domain says no, in both versions."""
    names = ("friction.mu", "friction.in_domain", "friction.domain_distance")
    connections = [f"process.{q} -> friction.{q}" for q in LOAD_NAMES if q != "T"]
    runs = {}
    for which in ("all", "three"):
        for clamp in (True, False):
            parts = {
                "friction": {"fmu": str(fmu[which]), "start": {"clamp_to_domain": clamp, "T": 900.0}},
                "process": {"fmu": str(fmu["process"])},
            }
            wired = system(
                fmu, which, components=parts, connections=[*connections, "friction.mu -> process.mu"]
            )
            wired.record = list(names)
            runs[which, clamp] = Master(wired).run(tmp_path / f"{which}-{clamp}")
    for clamp in (True, False):
        for name in names:
            np.testing.assert_allclose(runs["three", clamp][name], runs["all", clamp][name], rtol=1e-13)
        assert not runs["three", clamp]["friction.in_domain"][1:].any()
        assert (runs["three", clamp]["friction.domain_distance"][1:] > 1.0).all()
    assert (runs["three", False]["friction.mu"][1:] != runs["three", True]["friction.mu"][1:]).all()
