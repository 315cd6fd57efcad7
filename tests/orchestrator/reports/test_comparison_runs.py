"""`compare --system` and `simulate --swap`: one system, several friction models, against a process in closed form."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from fmus import pack
from friction_models import ConstantFriction, LinearFriction
from friction_models.common import InputError
from orchestrator import Run, System
from orchestrator.cli.main import run
from orchestrator.comparison.in_one_system import compare_in_system
from tests.friction_models.made_up import campaign
from tests.orchestrator.native_fmus import Real, native_fmu

UNITS = {"v_rel": "mm/s", "T": "degC", "sigma_n": "MPa", "sd": "mm", "psi": "1"}
LOADS = {"v_rel": 5.0, "T": 50.0, "sigma_n": 600.0, "sd": 1.0, "psi": 1.2}
#: Forces without friction [kN]: 40 times the stroke, and as much again for each 0.5 of mu.
GAIN, SHARE = 40.0, 0.5


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A forming process of two points whose force is GAIN (1 + mean mu / SHARE) stroke, its system, and models."""
    folder = tmp_path_factory.mktemp("runs")
    two = [f"{n}[{k}]" for n in LOADS for k in (1, 2)]
    start = {n: LOADS[n.partition("[")[0]] for n in two}
    variables = [Real(n, "output", start[n], UNITS[n.partition("[")[0]]) for n in two]
    variables += [Real("mu[1]", "input"), Real("mu[2]", "input")]
    variables += [Real("stroke", "output", unit="mm"), Real("force", "output", unit="kN")]
    force = f"V(force) = {GAIN} * (1.0 + 0.5 * (V(mu_1) + V(mu_2)) / {SHARE}) * V(stroke); V(sigma_n_2) = V(stroke) > 1.0 ? 300.0 : 0.0;"
    native_fmu(folder / "press.fmu", variables, outputs=force, step="V(stroke) += 5.0 * h;")
    pack(ConstantFriction(0.1), folder / "one.fmu")
    pack(ConstantFriction(0.1), folder / "two.fmu", nodes=2)
    LinearFriction().fit_frame(campaign(tests=6, points=20)).save(folder / "linear")
    supplier = [Real("p", "input", 5e8, "Pa"), Real("w", "input", 0.01, "m/s"), Real("rough", "input", 0.2), Real("cof", "output")]  # fmt: skip
    native_fmu(folder / "supplier.fmu", supplier, outputs="V(cof) = V(rough) * 1e8 / V(p);")
    content = {
        "name": "press",
        "communication_step": 0.1,
        "stop_time": 1.0,
        "components": {
            "friction": {"fmu": "two.fmu", "start": {"clamp_to_domain": True}},
            "press": {"fmu": "press.fmu"},
        },
        "connections": [f"press.{n} -> friction.{n}" for n in LOADS] + ["friction.mu -> press.mu"],
        "record": ["press.force", "friction.domain_distance"],
    }
    System.from_dict(content, folder).save(folder / "fre.yaml")
    (folder / "names.yaml").write_text(
        "supplier.fmu: {sigma_n: {variable: p, unit: Pa}, v_rel: w, mu: cof, set: {rough: 0.3}}\n"
    )
    return folder


def test_runs_are_laid_over_each_other(
    place: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    kept, page, answer = tmp_path / "kept", tmp_path / "page.html", tmp_path / "answer.json"
    models = [str(place / "one.fmu"), str(place / "linear"), "0.25", str(place / "supplier.fmu")]
    command = ["compare", "--system", str(place / "fre.yaml"), "--models", *models, "--names", str(place / "names.yaml")]  # fmt: skip
    command += ["--runs", str(kept), "--report", str(page), "--json", str(answer), "-j", "1"]
    assert run(command) == 0
    said = capsys.readouterr().out
    content = json.loads(answer.read_text())
    found = {m["label"]: m for m in content["models"]}
    assert list(found) == ["one", "linear", "0.25", "supplier"] and content["failed"] == []
    for label, mu in (("one", 0.1), ("0.25", 0.25)):
        # from 0 to 5 mm; the largest force is a mean over half a millimetre, narrower at the end
        work = 0.5 * GAIN * (1.0 + mu / SHARE) * 5.0**2
        assert found[label]["work_J"] == pytest.approx(work, rel=1e-9)
        assert found[label]["max_force_kN"] == pytest.approx(GAIN * (1.0 + mu / SHARE) * 5.0, rel=1e-9)
        assert found[label]["friction_share"] == pytest.approx(mu / (SHARE + mu), rel=1e-9)
        assert f"{100 * mu / (SHARE + mu):.1f} %" in said
    points = {p["point"]: p for p in found["supplier"]["points"]}
    assert points[1]["mu"][-1] == pytest.approx(0.3 * 100.0 / 600.0)
    assert points[2]["mu"][-1] == pytest.approx(0.3 * 100.0 / 300.0)
    assert points[2]["mu"][1] is None and points[2]["sigma_n"][1] is None, "no contact yet"
    text = page.read_text()
    assert all(word in text for word in ("Force over stroke", "point 2", "supplier", "By friction"))
    # A second call takes everything that is the same from before.
    folders = json.loads((kept / "runs.json").read_text())
    assert set(folders) == {*found, "without friction"}
    before = {n: (kept / f / "manifest.json").stat().st_mtime_ns for n, f in folders.items()}
    assert run([*command[:4], "0.3", *command[4:]]) == 0
    folders = json.loads((kept / "runs.json").read_text())
    after = {n: (kept / f / "manifest.json").stat().st_mtime_ns for n, f in folders.items()}
    assert set(after) - set(before) == {"0.3"} and {n: after[n] for n in before} == before
    assert Run.load(kept / folders["0.3"]).force_curve().force[-1] == pytest.approx(GAIN * 1.6 * 5.0)


def test_a_run_that_fails_leaves_the_others(
    place: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    loads = [Real(n, "input", LOADS[n], UNITS[n]) for n in LOADS]
    step = 'if (t > 0.45) { SAY("the film broke"); return 0; } V(mu) = 0.1;'
    broken = native_fmu(tmp_path / "broken.fmu", [*loads, Real("mu", "output")], step=step)
    answer = tmp_path / "answer.json"
    command = ["compare", "--system", str(place / "fre.yaml"), "--models", str(broken), "0.1"]
    assert run([*command, "--json", str(answer), "-j", "1"]) == 1
    said = capsys.readouterr()
    assert "the film broke" in said.err and "0.1" in said.out
    content = json.loads(answer.read_text())
    assert [m["label"] for m in content["models"]] == ["0.1"]
    assert "the film broke" in content["failed"][0]["error"]


def test_the_friction_fmu_that_every_model_replaces_need_not_exist(place: Path, tmp_path: Path) -> None:
    system = tmp_path / "none.yaml"
    text = (place / "fre.yaml").read_text().replace("fmu: press.fmu", f"fmu: {place / 'press.fmu'}")
    system.write_text(text.replace("two.fmu", "missing.fmu"))
    answer = tmp_path / "answer.json"
    command = ["compare", "--system", str(system), "--models", str(place / "one.fmu"), "0.25"]
    assert run([*command, "--json", str(answer), "-j", "1"]) == 0
    work = {m["label"]: m["work_J"] for m in json.loads(answer.read_text())["models"]}
    assert work["0.25"] / work["one"] == pytest.approx((1.0 + 0.25 / SHARE) / (1.0 + 0.1 / SHARE))


@pytest.mark.parametrize(("model", "mu"), [("0.25", 0.25), ("one.fmu", 0.1), ("supplier.fmu", None)])
def test_swap_takes_any_model(place: Path, tmp_path: Path, model: str, mu: float | None) -> None:
    given = str(place / model) if model.endswith(".fmu") else model
    names = ["--names", str(place / "names.yaml")] if mu is None else []
    command = ["simulate", str(place / "fre.yaml"), "--swap", f"friction={given}", *names]
    assert run([*command, "-o", str(tmp_path / "run")]) == 0
    force = Run.load(tmp_path / "run")["press.force"][-1]
    mean = mu if mu is not None else 0.5 * (0.3 / 6.0 + 0.3 / 3.0)
    assert force == pytest.approx(GAIN * (1.0 + mean / SHARE) * 5.0)
    # the run folder alone is enough to run it again
    again = System.load(tmp_path / "run" / "system.yaml")
    assert again.fmu_path("friction").is_file()
    if mu == 0.25:
        assert again.fmu_path("friction").is_relative_to(tmp_path / "run")
        assert run(["export", str(place / "fre.yaml"), "--swap", "friction=0.25", "-o", str(tmp_path / "x.ssp")]) == 0  # fmt: skip
        assert run(["simulate", str(tmp_path / "x.ssp"), "-o", str(tmp_path / "ssp")]) == 0
        assert Run.load(tmp_path / "ssp")["press.force"][-1] == pytest.approx(force)


@pytest.mark.parametrize("command", ["simulate", "export"])
def test_other_variables_are_told_what_helps(
    place: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    out = ["-o", str(tmp_path / ("x.ssp" if command == "export" else "run"))]
    swap = ["--swap", f"friction={place / 'supplier.fmu'}"]
    assert run([command, str(place / "fre.yaml"), *swap, *out]) == 2
    said = capsys.readouterr().err
    assert "'v_rel'" in said and "--names" in said and "each_point: true" in said


def test_what_cannot_be_compared_is_refused(place: Path, tmp_path: Path) -> None:
    assert run(["compare", "--models", "0.1"]) == 2
    assert run(["compare", "--models", "0.1", "--system", str(place / "fre.yaml"), "--mode", "jacoby"]) == 2
    alone = System.from_dict(
        {
            "communication_step": 0.1,
            "stop_time": 1.0,
            "components": {"press": {"fmu": str(place / "press.fmu"), "start": {"mu": 0.1}}},
        }
    )
    with pytest.raises(InputError, match="take loads and give mu: none does"):
        compare_in_system(alone, {"a": "0.1"})


def test_the_reference_is_not_shown_as_a_model(place: Path) -> None:
    result = compare_in_system(System.load(place / "fre.yaml"), {"low": "0.0", "high": "0.5"}, jobs=1)
    assert list(result.totals) == ["low", "high"]
    assert result.totals["low"].friction_share == pytest.approx(0.0, abs=1e-12)
    assert result.totals["high"].friction_share == pytest.approx(0.5)
    assert np.isfinite(result.curves["high"].force).all() and not result.synthetic
