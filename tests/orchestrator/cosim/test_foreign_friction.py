"""Friction FMUs of other generators: names, units, one point, answers after a step; alone and in a forming process."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from fmus.runtime.fmu_files import describe
from fmus.runtime.fmu_variables import Variable
from fmus.runtime.foreign_friction import friction_model
from fmus.runtime.friction_names import FrictionNames, read_names
from fmus.runtime.ports import Port
from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES, DataSet, TriboLoads
from orchestrator import Master
from orchestrator.cli.main import run
from orchestrator.cosim.points_without_pressure import PointsWithoutPressure
from orchestrator.cosim.ready_made import extrusion_system
from orchestrator.cosim.setup.wiring import Link
from tests.orchestrator.native_fmus import Real, native_fmu

ENTRY = {
    "sigma_n": {"variable": "p", "unit": "Pa"},
    "v_rel": "slip",
    "T": "theta",
    "mu": "cof",
    "set": {"gain": 2.0},
}
POINTS = 3


def law(v_rel: np.ndarray, T: np.ndarray, sigma_n: np.ndarray) -> np.ndarray:
    return 2.0 * (0.04 - 1e-5 * v_rel + 1e-5 * sigma_n - 2e-5 * (T + 273.15))


@pytest.fixture(scope="module")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return a friction FMU in SI units that answers in its step, one with our names that answers at once, a process."""
    folder = tmp_path_factory.mktemp("foreign")
    formula = "V(gain) * (0.04 - 0.01*V(slip) + 1e-11*V(p) - 2e-5*V(theta))"
    loads = [
        ("v_rel", "mm/s", 10.0),
        ("T", "degC", 30.0),
        ("sigma_n", "MPa", 400.0),
        ("sd", "mm", 0.0),
        ("psi", "1", 1.0),
    ]
    signals = [Real(f"{n}[{k + 1}]", "output", at, unit) for n, unit, at in loads for k in range(POINTS)]
    signals += [Real(f"mu[{k + 1}]", "input", 0.1) for k in range(POINTS)]
    signals += [Real(f"active[{k + 1}]", "output", 1.0) for k in range(POINTS)]
    signals += [
        Real(n, "output", 0.0, u)
        for n, u in (("stroke", "mm"), ("force", "kN"), ("work", "J"), ("max_tau_over_k", "1"))
    ]
    grow = " ".join(
        f"V(sigma_n_{k}) = 400.0 + 100.0*{k}*(1.0 + t); V(T_{k}) = 30.0 + 10.0*t; V(v_rel_{k}) = 10.0*{k};"
        for k in range(1, POINTS + 1)
    )
    force = " + ".join(f"V(mu_{k})" for k in range(1, POINTS + 1))
    return {
        "late": native_fmu(
            folder / "late.fmu",
            [Real("p", "input", 1e8, "Pa"), Real("slip", "input", 0.01, "m/s"), Real("theta", "input", 300.0, "K"),
             Real("room", "input", 21.0, "degC"), Real("gain", "parameter", 1.0), Real("cof", "output")],
            step=f"V(cof) = {formula};",
        ),
        "ours": native_fmu(
            folder / "ours.fmu",
            [*(Real(n, "input", at, unit) for n, unit, at in loads), Real("mu", "output")],
            outputs="V(mu) = 2.0 * (0.04 - 1e-5*V(v_rel) + 1e-5*V(sigma_n) - 2e-5*(V(T) + 273.15));",
        ),
        "process": native_fmu(folder / "process.fmu", signals, outputs=f"{grow} V(stroke) = t; V(force) = {force};"),
    }  # fmt: skip


def points() -> np.ndarray:
    rng = np.random.default_rng(4)
    return rng.uniform([1.0, 20.0, 200.0, 0.0, 1.0], [300.0, 200.0, 2000.0, 20.0, 3.0], (25, 5))


def test_names_units_and_late_answers(fmus: dict[str, Path]) -> None:
    loads = points()
    expected = law(loads[:, 0], loads[:, 1], loads[:, 2])
    model = friction_model(fmus["late"], ENTRY)
    assert model.names is not None
    np.testing.assert_allclose(model.predict(loads), expected, rtol=1e-12)
    # In time, too, from the first point on.
    moving = replace(TriboLoads.from_array(loads), t=np.linspace(0.0, 1.0, len(loads)))
    np.testing.assert_allclose(model.predict(moving), expected, rtol=1e-12)
    same = friction_model(fmus["ours"])
    assert same.names is not None, "our names, but not one of our FMUs"
    np.testing.assert_allclose(same.predict(loads), expected, rtol=1e-12)


def test_one_instance_a_point_in_a_process_with_other_units(fmus: dict[str, Path], tmp_path: Path) -> None:
    names = FrictionNames.of(describe(fmus["late"]), ENTRY)
    assert names.each_point and names.loads == {
        "v_rel": ("slip", "m/s"),
        "T": ("theta", "K"),
        "sigma_n": ("p", "Pa"),
    }
    assert names.start == {"gain": 2.0, "room": 21.0} and not names.has_distance
    assert FrictionNames.from_dict(names.to_dict()) == names
    system = extrusion_system(fmus["late"], fmus["process"], 1.0, 0.5, names=names)
    run = Master(system).run(tmp_path / "run")
    assert run.manifest["components"]["friction"]["instances"] == POINTS
    before = {n: run[f"forming.{n}"][:-1] for n in LOAD_NAMES}
    expected = law(before["v_rel"], before["T"], before["sigma_n"])
    assert np.ptp(expected) > 1e-3
    np.testing.assert_allclose(run["friction.cof"][1:], expected, rtol=1e-12)
    np.testing.assert_allclose(run["forming.force"][1:], expected.sum(axis=1), rtol=1e-12)
    iterated = Master(system, "iterated").run(tmp_path / "iterated")
    now = {n: iterated[f"forming.{n}"][1:] for n in LOAD_NAMES}
    np.testing.assert_allclose(
        iterated["friction.cof"][1:], law(now["v_rel"], now["T"], now["sigma_n"]), rtol=1e-12
    )


def test_a_system_that_converts_units_is_no_archive(fmus: dict[str, Path], tmp_path: Path) -> None:
    names = FrictionNames.of(describe(fmus["late"]), ENTRY)
    system = extrusion_system(fmus["late"], fmus["process"], 1.0, 0.5, names=names)
    with pytest.raises(InputError, match=r"converts units, which an archive cannot hold"):
        system.export(tmp_path / "x.ssp")
    system.connections[0] = "forming.v_rel -> friction.slip"
    with pytest.raises(
        InputError, match=r"in 'mm/s', 'slip\[1\]' in 'm/s'.*\('forming.v_rel -> friction.slip \[m/s\]'\)"
    ):
        system.validate()
    system.connections[0] = "forming.v_rel -> friction.slip [K]"
    with pytest.raises(InputError, match=r"'slip\[1\]' is in 'm/s' and not in 'K'"):
        system.validate()


@pytest.mark.parametrize(
    ("change", "pattern"),
    [
        ({"mu": "coff"}, "did you mean 'cof'"),
        ({"sigma": "p"}, "did you mean 'sigma_n'"),
        ({"T": {"variable": "theta", "unit": "MPa"}}, "unknown unit of 'T' 'MPa'; allowed: K, degC"),
        ({"T": {"variable": "theta", "unit": "degC"}}, "'theta' is in 'K', not in 'degC'"),
        ({"T": {"variable": "theta", "units": "K"}}, "T: unknown key 'units'.*did you mean 'unit'"),
        ({"psi": {"variable": "room"}}, "unit of 'psi'"),
        ({"T": "cof"}, "causality 'output', allowed: input"),
        ({"T": 3}, "allowed: a variable, or"),
        ({"sd": "slip"}, "'slip' takes 'v_rel' and 'sd'"),
        ({"set": {"gian": 1.0}}, "did you mean 'gain'"),
        ({"set": {"p": 1.0}}, "set: unknown free input or parameter 'p'; allowed: gain, room"),
        ({"set": {"gain": [1.0]}}, "'gain' = .*allowed: a finite number"),
        ({"set": {"gain": "fast"}}, "'gain' = 'fast', allowed: a finite number"),
        ({"set": {"gain": True}}, "'gain' = 'True', allowed: a finite number"),
    ],
)
def test_bad_names(fmus: dict[str, Path], change: dict[str, object], pattern: str) -> None:
    with pytest.raises(InputError, match=pattern):
        FrictionNames.of(describe(fmus["late"]), ENTRY | change)


def test_an_fmu_that_refuses_loads_is_no_model(tmp_path: Path) -> None:
    fmu = native_fmu(
        tmp_path / "picky.fmu", [Real("T", "input", 20.0, "degC"), Real("mu", "output")], step="return 0;"
    )
    with pytest.raises(InputError, match=r"picky\.fmu: the FMU refuses ordinary loads"):
        friction_model(fmu, {})


def test_a_start_value_that_is_no_number_is_refused(fmus: dict[str, Path]) -> None:
    described = describe(fmus["late"])
    room = [replace(described.arrays["room"][0], starts=(float("nan"),), type="Integer")]
    broken = replace(described, arrays={**described.arrays, "room": room})
    with pytest.raises(InputError, match="'room' starts at nan; allowed: a finite number"):
        FrictionNames.of(broken, ENTRY)


def test_an_fmu_with_unknown_names_points_to_the_option(fmus: dict[str, Path]) -> None:
    with pytest.raises(InputError, match=r"'v_rel'.*--names FILE\.yaml says which takes which load"):
        friction_model(fmus["late"])


@pytest.mark.parametrize(
    ("text", "pattern"),
    [("", "not a mapping"), ("[a]", "not a mapping"), ("a.fmu: cof", "'a.fmu' is no mapping"), ("a: {b: &x 1, c: *x}", "alias")],
)  # fmt: skip
def test_files_that_hold_no_names(tmp_path: Path, text: str, pattern: str) -> None:
    (tmp_path / "n.yaml").write_text(text)
    with pytest.raises(InputError, match=pattern):
        read_names(tmp_path / "n.yaml")


def test_points_without_contact_get_loads_that_every_law_answers() -> None:
    def both(name: str, causality: str) -> tuple[Variable, ...]:
        return tuple(Variable(f"{name}[{k + 1}]", k, "Real", causality, "") for k in range(2))

    links = [
        Link("forming", both("sigma_n", "output"), "friction", both("p", "input"), 1e6),
        Link("forming", both("v_rel", "output"), "friction", both("slip", "input"), 1e-3),
        Link("forming", both("T", "output"), "friction", both("theta", "input"), 1.0, 273.15),
        Link("friction", both("cof", "output"), "forming", both("mu", "input")),
    ]
    outputs = {
        "forming": Port([v for link in links[:3] for v in link.sources]),
        "friction": Port(links[3].sources),
    }
    outputs["forming"].values[:] = [0.0, 300.0, 0.0, 20.0, 25.0, 60.0]
    untouched = PointsWithoutPressure.of("friction", links, outputs)
    assert untouched is not None
    values = np.array([0.0, 3e8, 0.0, 0.02, 298.15, 333.15])
    for first, link in zip((0, 2, 4), links):
        if patch := untouched.patch("friction", link, first):
            patch.apply(values, outputs)
    assert values == pytest.approx([5e8, 3e8, 1e-6, 0.02, 298.15, 333.15])
    mu = np.array([np.inf, np.nan])
    back = untouched.patch("friction", links[3], 0)
    assert back is not None
    back.apply(mu, outputs)
    assert mu[0] == 0.0 and np.isnan(mu[1])  # where there is contact, the error stays an error


def test_commands_take_an_fmu_of_others(
    fmus: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rng = np.random.default_rng(4)
    tests, n = 24, 40
    level = {
        name: np.repeat(rng.uniform(*limits, tests), n)
        for name, limits in (("v_rel", (5.0, 200.0)), ("T", (20.0, 200.0)), ("sigma_n", (300.0, 1500.0)))
    }
    points = pd.DataFrame(
        {
            "test_id": np.repeat([f"t{k}" for k in range(tests)], n),
            "t": np.tile(np.arange(n) * 0.05, tests),
            **level,
            "sd": np.tile(np.linspace(0.0, 40.0, n), tests),
            "psi": np.repeat(rng.uniform(1.0, 3.0, tests), n),
        }
    )
    mu = law(*(points[name].to_numpy() for name in ("v_rel", "T", "sigma_n")))
    points["mu"] = mu + np.repeat(rng.normal(0.0, 5e-4, tests), n) + rng.normal(0.0, 5e-4, n * tests)
    roles = pd.DataFrame({"test_id": [f"t{k}" for k in range(tests)], "role": "train"})
    DataSet(points, roles, {}).save(tmp_path / "data")
    names = tmp_path / "names.yaml"
    names.write_text(yaml.safe_dump({fmus["late"].name: ENTRY}), encoding="utf-8")
    fmu, data = str(fmus["late"]), str(tmp_path / "data")
    given = ["--data", data, "--names", str(names)]
    assert run(["predict", fmu, *given, "-o", str(tmp_path / "p.csv")]) == 0
    predicted = pd.read_csv(tmp_path / "p.csv")
    # Its answer follows the loads by one step; within a test they hardly change, between two tests they do.
    same = predicted["t"] > 0.0
    assert np.abs(predicted["mu_model"] - mu)[same].max() < 1e-9
    assert run(["evaluate", fmu, *given, "--json", str(tmp_path / "e.json")]) == 0
    assert json.loads((tmp_path / "e.json").read_text(encoding="utf-8"))["overall"]["outside_domain"] is None
    said = capsys.readouterr()
    # The loads that the law has no input for are named, and so is its free input.
    assert "not known" in said.out and "sd, psi do not enter it; room stays at" in said.err
    assert run(["diagnose", "--model", fmu, *given, "--json", str(tmp_path / "d.json")]) == 0
    assert json.loads((tmp_path / "d.json").read_text(encoding="utf-8"))["verdict"] == "nothing_missing"
    told = capsys.readouterr().out
    assert "NOTHING_MISSING: nothing " in told and "missing from the late.fmu model" in told
    capsys.readouterr()
    names.write_text(yaml.safe_dump({fmus["late"].name: ENTRY | {"mu": "coff"}}), encoding="utf-8")
    assert run(["evaluate", fmu, *given]) == 2
    assert f"{names}: late.fmu: unknown output for 'mu' 'coff'" in capsys.readouterr().err
    names.write_text(yaml.safe_dump({fmus["late"].name: ENTRY | {"set": {"gain": 30.0}}}), encoding="utf-8")
    assert run(["evaluate", fmu, *given]) == 0 and "outside 0 to 1" in capsys.readouterr().out
    assert run(["predict", fmu, "--data", data, "-o", str(tmp_path / "p.csv")]) == 2
    assert "--names FILE.yaml says which takes which load" in capsys.readouterr().err
    assert run(["predict", "0.08", *given, "-o", str(tmp_path / "p.csv")]) == 2
    assert "no FMU among the models" in capsys.readouterr().err
