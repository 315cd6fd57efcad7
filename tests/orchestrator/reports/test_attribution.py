"""Forming attribution on synthetic press curves with a known cause, made by the solver at another mesh."""

from __future__ import annotations

import json
import re
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from fmus import pack, pack_forming
from fmus.runtime.fmu_files import describe
from forming import ForwardRodExtrusion
from forming.materials.materials import steel_16MnCr5
from forming.press import PressCurves, PressLevel
from friction_models import ConstantFriction, LinearFriction
from friction_models.common import InputError
from friction_models.effects import make_effect
from friction_models.models.onnx_export import export
from friction_models.models.onnx_model import OnnxModel
from orchestrator.attribution.attribute import attribute
from orchestrator.attribution.causes import MACHINE, Cause
from orchestrator.attribution.curves import LevelForces, on_common_stroke
from orchestrator.attribution.fit import attribution
from orchestrator.attribution.friction_with_effects import addable, strengths, with_effects
from orchestrator.attribution.sensitivities import Sensitivities
from orchestrator.cli.commands import attributing
from orchestrator.cosim.ready_made import extrusion_system
from orchestrator.cosim.system import System
from orchestrator.force_curves.forces import ForceCurve
from orchestrator.report.pages.attribution import attribution_page

LEVELS = ((20.0, 5.0), (150.0, 100.0))
STROKE = 5.0
BILLET_LENGTH, N_POINTS = 20.0, 30
CAUSES = ["flow_stress", "friction_level", "compliance", "stroke_zero", "force_gain", "stribeck"]

Pressed = Callable[..., PressCurves]


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("attribution")


@pytest.fixture(scope="module")
def system(place: Path) -> System:
    forming = pack_forming(
        place / "forming.fmu", stroke=STROKE, mesh_size=1.0, billet_length=BILLET_LENGTH, n_points=N_POINTS
    )
    friction = pack(ConstantFriction(0.08), place / "friction.fmu", nodes=30)
    return extrusion_system(friction, forming, 5.0, STROKE, synthetic=True)


@pytest.fixture(scope="module")
def pressed() -> Pressed:
    """Return synthetic curves of a press with a known cause; solver runs are shared."""
    known: dict[tuple[float, float], list[tuple[np.ndarray, np.ndarray]]] = {}

    def run(flow: float, mu: float) -> list[tuple[np.ndarray, np.ndarray]]:
        if (flow, mu) not in known:
            known[flow, mu] = []
            for T, speed in LEVELS:
                steel = steel_16MnCr5()
                solver = ForwardRodExtrusion(
                    mesh_size=0.95,
                    speed=speed,
                    T_tool=T,
                    material=replace(steel, A=steel.A * flow),
                    billet_length=BILLET_LENGTH,
                    n_points=N_POINTS,
                )
                result = solver.run(mu, stroke=STROKE)
                known[flow, mu].append((np.asarray(result.stroke), np.asarray(result.force)))
        return known[flow, mu]

    def curves(flow: float = 1.0, mu: float = 0.08, compliance: float = 0.0, repeats: int = 4) -> PressCurves:
        rng = np.random.default_rng(5)
        levels = []
        for (T, speed), (stroke, force) in zip(LEVELS, run(flow, mu), strict=True):
            parts = []
            for k in range(repeats):
                own = force * (1.0 + 0.006 * rng.standard_normal())
                travel = np.maximum.accumulate(stroke + compliance * own)
                at = np.arange(0.0, travel[-1], 0.02)
                noisy = np.interp(at, travel, own) + 0.5 * rng.standard_normal(len(at))
                parts.append(pd.DataFrame({"stroke": at, "force": noisy, "repeat": k + 1}))
            table = pd.concat(parts, ignore_index=True)
            levels.append(
                PressLevel("fre", T, speed, "made up", f"fre_{speed:g}_{T:g}.csv", table, synthetic=True)
            )
        return PressCurves(tuple(levels), {})

    return curves


@pytest.mark.nightly
def test_nothing_is_blamed_where_the_model_is_right(system: System, pressed: Pressed, place: Path) -> None:
    found = attribute(pressed(), system, CAUSES, place / "runs", jobs=1)
    assert not found.confusion_set and "no cause stands out" in found.sentence
    assert found.synthetic and found.sentence.startswith("Attribution, not proof")
    assert any({"flow_stress", "force_gain"} <= set(g) for g in found.groups)  # both scale the force


def test_a_level_of_friction_is_told(system: System, pressed: Pressed, place: Path) -> None:
    friction = attribute(pressed(mu=0.096), system, CAUSES, place / "runs", jobs=1)
    # one process, short and coarse: what scales the whole force may look like it, nothing else
    assert friction.ranking[0].cause == "friction_level"
    assert set(friction.confusion_set) <= {"friction_level", "flow_stress", "force_gain"}
    low, high = friction.ranking[0].to_dict()["strength"][0]["interval"]
    assert low < 0.2 < high
    assert friction.deviation["after"] < 0.3 * friction.deviation["before"]


@pytest.mark.nightly
def test_a_compliance_is_told(system: System, pressed: Pressed, place: Path) -> None:
    press = attribute(pressed(compliance=1e-3), system, CAUSES, place / "runs", jobs=1)
    assert press.confusion_set == ["compliance"] and not press.second
    assert press.ranking[0].values[0][1] == pytest.approx(1e-3, rel=0.1)


@pytest.mark.nightly
def test_a_flow_stress_is_told(system: System, pressed: Pressed, place: Path) -> None:
    flow = attribute(pressed(flow=1.03), system, CAUSES, place / "runs", jobs=1)
    assert "flow_stress" in flow.confusion_set
    strength = next(f for f in flow.ranking if f.cause == "flow_stress").to_dict()["strength"][0]
    assert strength["interval"][0] < 0.03 < strength["interval"][1]
    assert json.dumps(flow.to_dict(), allow_nan=False)


@pytest.mark.nightly
def test_friction_of_fmi_3_is_attributed_alike(system: System, pressed: Pressed, place: Path) -> None:
    friction = pack(ConstantFriction(0.08), place / "friction3.fmu", nodes=30, fmi="3.0")
    one = PressCurves(pressed(mu=0.096).levels[:1], {})
    causes = ["friction_level", "compliance", "stribeck"]
    two = attribute(one, system, causes, place / "runs", jobs=1)
    three = attribute(one, system.swap("friction", friction), causes, place / "runs", jobs=1)
    # one speed: an effect of the speed is a friction level like any other
    assert three.confusion_set == two.confusion_set and set(two.confusion_set) == {
        "friction_level",
        "stribeck",
    }
    for a, b in zip(two.ranking, three.ranking, strict=True):
        assert a.cause == b.cause and a.values[0][1:3] == pytest.approx(b.values[0][1:3], rel=1e-6)
    versions = {describe(p).raw.fmiVersion for p in (place / "runs").glob("probe-*.fmu")}
    assert versions == {"2.0", "3.0"}  # fingerprints come from FMUs of the user's version


def test_the_command_finds_its_runs_again(
    system: System, pressed: Pressed, place: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pressed().save(tmp_path / "press")
    system.save(tmp_path / "fre.yaml")
    app = attributing.app
    words = [
        "--press",
        str(tmp_path / "press"),
        "--system",
        str(tmp_path / "fre.yaml"),
        "--runs",
        str(place / "runs"),
    ]
    before = {p.name for p in (place / "runs").iterdir()}
    app(
        [*words, "--json", str(tmp_path / "a.json"), *(w for c in CAUSES for w in ("--causes", c))],
        standalone_mode=False,
    )
    said = capsys.readouterr()
    assert {p.name for p in (place / "runs").iterdir()} == before, "nothing was computed again"
    assert "Attribution, not proof" in said.out and "synthetic press curves" in said.out
    assert json.loads((tmp_path / "a.json").read_text())["label"] == "attribution, not proof"
    with pytest.raises(InputError, match="did you mean 'stribeck'"):
        app([*words, "--causes", "stribek"], standalone_mode=False)


def test_systems_that_cannot_be_varied_are_refused(
    system: System, pressed: Pressed, place: Path, tmp_path: Path
) -> None:
    alone = System.from_dict({**system.model_dump(mode="json", exclude_none=True), "connections": []})
    with pytest.raises(InputError, match="comes from 0 components"):
        attribute(pressed(), alone, CAUSES, tmp_path / "runs")
    cup = PressCurves(tuple(replace(v, process="bce") for v in pressed().levels), {})
    with pytest.raises(InputError, match="the systems form fre"):
        attribute(cup, system, CAUSES, tmp_path / "runs")
    foreign = system.swap("friction", without_graph(system.fmu_path("friction"), tmp_path / "foreign.fmu"))
    with pytest.raises(InputError, match=r"resources/model.onnx.*friction cannot be told"):
        attribute(pressed(), foreign, CAUSES, tmp_path / "runs")


def without_graph(fmu: Path, target: Path) -> Path:
    with zipfile.ZipFile(fmu) as source, zipfile.ZipFile(target, "w") as copy:
        for item in source.infolist():
            if item.filename != "resources/model.onnx":
                copy.writestr(item, source.read(item))
    return target


def test_a_probe_is_the_model_until_a_strength_is_set(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    loads = rng.uniform([1, 20, 300, 0, 1], [400, 300, 2500, 50, 2], (60, 5))
    frame = pd.DataFrame(loads, columns=["v_rel", "T", "sigma_n", "sd", "psi"]).assign(
        mu=0.08 - 1e-5 * loads[:, 0]
    )
    model = (LinearFriction() + "rate_state").fit_frame(frame.assign(test_id="a", t=np.arange(60.0)))
    content = export(model, tmp_path / "m.onnx").read_bytes()
    wanted = [make_effect(n) for n in ("stribeck", "rate_state", "work_exhaustion", "batch", "force_zero")]
    effects = addable(content, wanted, "m")
    assert [e.name for e in effects] == ["stribeck", "work_exhaustion"]  # the model has its own age already
    (tmp_path / "p.onnx").write_bytes(with_effects(content, effects, "m").SerializeToString())
    own, probe = OnnxModel(tmp_path / "m.onnx"), OnnxModel(tmp_path / "p.onnx")
    np.testing.assert_allclose(probe.predict(loads), own.predict(loads), rtol=0, atol=1e-14)
    start = [v["start"] for v in probe.system_variables]
    names = [v["name"] for v in probe.system_variables]
    for strength in strengths(effects[:1]):
        moved = list(start)
        moved[names.index(strength.parameter)] = 0.02
        law = make_effect("stribeck").start_shape()
        expected = 0.02 * np.exp(-((loads[:, 0] / law["v_s"]) ** law.get("delta", 1.0)))
        change = probe.predict(loads, system=moved) - own.predict(loads)
        assert np.corrcoef(change, expected)[0, 1] > 0.98 and change.max() > 0.005
    moved = list(start)
    moved[names.index("mu_factor")] = 1.5
    np.testing.assert_allclose(probe.predict(loads, system=moved), 1.5 * own.predict(loads), rtol=1e-12)
    state = probe.start_state(60)
    after = probe.step(loads, state, 0.1)[1]
    np.testing.assert_allclose(after[:, :1], own.step(loads, own.start_state(60), 0.1)[1])
    assert (after[:, 1] > 0.0).all()  # friction work


def made_up(repeats: int, shift: float = 0.0, seed: int = 0) -> tuple[list[LevelForces], Sensitivities]:
    """One level with a rising curve; causes: one like the force, one that fades along the stroke, one that is nothing."""
    rng = np.random.default_rng(seed)
    s = np.linspace(0.0, 10.0, 32)
    force = 100.0 * (1.0 - np.exp(-s / 2.0))
    fades = force * np.exp(-s / 4.0)
    noise = rng.standard_normal((max(repeats, 1), 1)) * 0.004 * force + 0.05 * rng.standard_normal(
        (max(repeats, 1), 32)
    )
    each = force + shift * fades + noise
    curve = ForceCurve(s, force)
    level = LevelForces("made up", s, 0.5, force, each.mean(axis=0), each - each.mean(axis=0), curve)
    causes = [
        Cause("flow_stress", "", "flow stress", "1", 0.05),
        Cause("running_in", "", "friction", "1", 0.1),
        Cause("wear_out", "", "friction", "1", 0.1, 1),
    ]
    moved = {"flow_stress": force * 1.05, "running_in": force + 0.1 * fades, "wear_out": force + 1e-6 * s}
    curves = {k: [ForceCurve(s, v)] for k, v in moved.items()}
    return [level], Sensitivities(causes, [ForceCurve(s, force)], curves, [], 0.0, [])


def test_false_alarms_and_the_right_cause_over_seeds() -> None:
    accused = right = 0
    for seed in range(40):
        accused += bool(attribution(*made_up(4, 0.0, seed), synthetic=True).confusion_set)
        found = attribution(*made_up(4, 0.15, seed), synthetic=True)
        right += found.confusion_set[:1] == ["running_in"]
        assert found.unseen == ["wear_out"]
    assert accused <= 2 and right >= 38


def test_one_curve_is_judged_with_caution() -> None:
    found = attribution(*made_up(1, 0.02), synthetic=True)
    assert not found.confusion_set and any("no level was repeated" in w for w in found.warnings)


def test_the_page_names_what_cannot_be_told_apart() -> None:
    (level,), found = made_up(4, 0.15)
    found.causes.append(Cause("force_gain", "gain", "machine", "1"))
    answer = attribution([level], found, synthetic=True)
    assert repr(answer) == f"Attribution({answer.sentence!r})"
    html = attribution_page(answer, "<b>press</b>")
    own = re.sub(r"<script.*?</script>", "", html, flags=re.DOTALL)
    assert "<b>" not in own and "attribution, not proof" in own and "synthetic data" in own
    assert "The curves point to running_in" in own
    assert "flow_stress, force_gain" in own and "Leaves no trace" in own and "wear_out" in own
    nothing = attribution_page(attribution(*made_up(4), synthetic=True), "press")
    assert "No cause stands out" in nothing


def test_a_give_of_the_press_is_followed_where_the_force_rises_steeply() -> None:
    s = np.linspace(0.0, 10.0, 400)
    force = 300.0 * (1.0 - np.exp(-((s / 1.2) ** 2)))
    curve = ForceCurve(s, force)
    for give in (3e-4, 1e-3, 3e-3):  # up to 0.9 mm of a rise that is over after 2 mm
        table = pd.concat(
            pd.DataFrame({"stroke": s + give * force * f, "force": force * f, "repeat": k})
            for k, f in enumerate((0.995, 1.0, 1.004, 1.001), 1)
        )
        level = PressLevel("fre", 20.0, 5.0, "made up", "l.csv", table, synthetic=True)
        sensitivities = Sensitivities(list(MACHINE), [curve], {}, [], 0.0, [])
        found = attribution([on_common_stroke(level, curve)], sensitivities, synthetic=True)
        assert found.confusion_set == ["compliance"]
        assert found.ranking[0].values[0][1] == pytest.approx(give, rel=0.05)


def test_a_cause_that_takes_the_curves_further_apart_is_not_named() -> None:
    (level,), found = made_up(4)
    s, force = level.stroke, level.simulated
    # A wave that the cause has, too, and one that nothing has; billets scatter by 2 %, which leaves the height open.
    wave, unknown = 2.0 * np.sin(2.0 * s), 1.5 * np.sin(5.0 * s)
    repeats = 0.02 * np.array([[-1.0], [-0.5], [0.5], [1.0]]) * force + level.deviations
    off = replace(level, measured=force + wave + unknown, deviations=repeats)
    found.causes[:] = [Cause("stribeck", "mixed to boundary transition", "friction", "1", 1.0)]
    found.moved["stribeck"] = [ForceCurve(s, force + wave + 0.08 * force)]
    answer = attribution([off], found, synthetic=True)
    assert not answer.confusion_set and answer.ranking[0].cause == "stribeck"
    assert answer.deviation["after"] == pytest.approx(answer.deviation["before"])
    assert any("stribeck would fit the course of the curves best" in w for w in answer.warnings)
    # Without the part that raises everything, it is named.
    found.moved["stribeck"] = [ForceCurve(s, force + wave)]
    answer = attribution([off], found, synthetic=True)
    assert answer.confusion_set == ["stribeck"] and answer.deviation["after"] < answer.deviation["before"]


def test_curves_outside_the_scatter_that_no_cause_explains_are_said_to_be() -> None:
    (level,), found = made_up(4)
    found.causes[:] = [c for c in found.causes if c.name == "running_in"]
    off = replace(level, measured=level.simulated + 3.0 * np.sin(5.0 * level.stroke))
    answer = attribution([off], found, synthetic=True)
    assert not answer.confusion_set and "outside the scatter" in answer.sentence
    assert "within the scatter" in attribution(*made_up(4), synthetic=True).sentence
