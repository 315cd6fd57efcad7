"""Friction maps (`--target map`): parameters that can be calibrated, against SciPy; manifest and terminal of FMI-LS-STRUCT."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fmpy.validation import validate_fmu
from lxml import etree
from scipy.interpolate import RegularGridInterpolator

from fmus import pack
from fmus.archive.content import write_archive
from fmus.checks.report import Notes
from fmus.checks.trial_map import maps
from fmus.runtime.running import FmuError, RunningFmu, UnpackedFmu
from fmus.source.reading import read_source
from fmus.targets.friction_map import friction_map
from friction_models import ConstantFriction
from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES
from orchestrator.cli.main import run
from tests.fmus.graphs import BOX, graph_bytes, inside, node, runtime, save

STRUCT = "org.fmi-standard.fmi-ls-struct"
MANIFEST = f"extra/{STRUCT}/fmi-ls-manifest.xml"
TERMINALS = "terminalsAndIcons/terminalsAndIcons.xml"
V, T = LOAD_NAMES.index("v_rel"), LOAD_NAMES.index("T")


@pytest.fixture(scope="module")
def law(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """mu = 0.08 + 0.0005 T exp(-v_rel / 60) + 1e-6 sigma_n, trained on BOX."""
    nodes = [
        node("Gather", "loads iv", "v", axis=1),
        node("Gather", "loads it", "T", axis=1),
        node("Gather", "loads ip", "p", axis=1),
        node("Mul", "v slow", "x"),
        node("Exp", "x", "faded"),
        node("Mul", "T faded", "hot"),
        node("Mul", "hot a", "m1"),
        node("Mul", "p c", "m2"),
        node("Add", "m1 m2", "m3"),
        node("Add", "m3 b", "mu"),
    ]
    numbers = {"slow": -1.0 / 60.0, "a": 5e-4, "c": 1e-6, "b": 0.08}
    constants = {k: np.array(x) for k, x in numbers.items()}
    constants |= {k: np.array([i]) for k, i in (("iv", V), ("it", T), ("ip", 2))}
    model = {"family": "composed", "name": "fading", "formula": "fading"}
    content = graph_bytes(nodes, constants, metadata={"domain": BOX, "model": model})
    return save(content, tmp_path_factory.mktemp("law") / "model.onnx")


@pytest.fixture(scope="module")
def fmu(law: Path, tmp_path_factory: pytest.TempPathFactory) -> UnpackedFmu:
    path = tmp_path_factory.mktemp("map") / "map.fmu"
    return UnpackedFmu.of(pack(law, path, target="map", arrays=True, axes="v_rel,T", max_rows=24))


def shape_of(fmu: UnpackedFmu) -> tuple[int, int]:
    return len(fmu.resolve("v_rel_axis")), len(fmu.resolve("T_axis"))


def points_of(count: int, seed: int, beyond: float = 0.0) -> np.ndarray:
    box = np.array([BOX[n] for n in LOAD_NAMES])
    width = beyond * (box[:, 1] - box[:, 0])
    points = np.random.default_rng(seed).uniform(box[:, 0] - width, box[:, 1] + width, (count, 5))
    return np.maximum(points, [0.0, -200.0, 0.0, 0.0, 1.0])


def test_manifest_terminal_and_variables_are_those_of_the_standard(fmu: UnpackedFmu) -> None:
    root = etree.fromstring((fmu.folder / MANIFEST).read_bytes())
    space = "{http://fmi-standard.org/fmi-ls-manifest}"
    assert root.tag == "fmiLayeredStandardManifest" and len(root) == 0
    assert dict(root.attrib) == {
        f"{space}fmi-ls-name": STRUCT,
        f"{space}fmi-ls-version": "1.0.0-rc.1",
        f"{space}fmi-ls-description": "Layered standard for structuring of variables",
    }
    terminals = etree.fromstring((fmu.folder / TERMINALS).read_bytes()).find("Terminals")
    assert terminals is not None and [t.get("name") for t in terminals] == ["friction", "mu_map"]
    terminal = terminals[1]
    assert terminal.get("terminalKind") == f"{STRUCT}.map.rectilinearGrid"
    assert terminal.get("matchingRule") == f"{STRUCT}.map"
    roles = ["domain", "domainInput"] * 2 + ["codomain", "codomainOutput"]
    assert [m.get("variableKind") for m in terminal] == [f"{STRUCT}.map.{role}" for role in roles]
    names = [m.get("variableName") for m in terminal]
    assert names == ["v_rel_axis", "v_rel", "T_axis", "T", "mu_map", "mu"]
    found = {v.name: v for v in fmu.raw.modelVariables}
    sizes = {n: [d.start for d in found[n].dimensions] for n in ("v_rel_axis", "T_axis", "mu_map")}
    assert sizes["mu_map"] == sizes["v_rel_axis"] + sizes["T_axis"] == list(shape_of(fmu))
    assert {found[n].causality for n in sizes} == {"parameter"} and found["T_axis"].unit == "degC"
    assert len({v.valueReference for v in fmu.raw.modelVariables}) == len(fmu.raw.modelVariables)
    assert validate_fmu(str(fmu.path)) == []


@pytest.mark.parametrize("points", [1, 19])
def test_values_and_sampling_points_that_are_set_are_interpolated_as_scipy_does(
    fmu: UnpackedFmu, points: int
) -> None:
    shape = shape_of(fmu)
    rng = np.random.default_rng(3)
    values = rng.uniform(0.02, 0.3, shape)
    lines = [np.cumsum(rng.uniform(1.0, 40.0, n)) + 10.0 for n in shape]
    loads = points_of(points, seed=4, beyond=0.3)
    with RunningFmu(fmu, start={"n": points, "clamp_to_domain": False}) as running:
        before = running.get_real(["mu"])
        # As a calibration would: in step mode, in between two readings.
        for name, new in (("v_rel_axis", lines[0]), ("T_axis", lines[1]), ("mu_map", values)):
            running.set_real([name], new.ravel())
        running.set_real(LOAD_NAMES, loads.T)
        mu = running.get_real(["mu"])
        np.testing.assert_array_equal(running.get_real(["mu_map"]), values.ravel())
        state = running.save_state()
        running.set_real(["mu_map"], np.full(values.size, 0.1))
        np.testing.assert_allclose(running.get_real(["mu"]), 0.1, rtol=1e-14)
        running.restore_state(running.deserialize(running.serialize(state)))
        np.testing.assert_array_equal(running.get_real(["mu"]), mu)
        if points == 1:  # a reset brings back the number of points, too
            running.reset()
            np.testing.assert_array_equal(running.get_real(["mu"]), before)
    at = np.clip(loads[:, [V, T]], [x[0] for x in lines], [x[-1] for x in lines])
    np.testing.assert_allclose(mu, RegularGridInterpolator(lines, values)(at), rtol=1e-12)


def test_derivatives_by_the_values_are_the_weights_of_the_sampling_points(fmu: UnpackedFmu) -> None:
    loads = points_of(3, seed=5)
    shape = shape_of(fmu)
    with RunningFmu(fmu, start={"n": 3}) as running:
        running.set_real(LOAD_NAMES, loads.T)
        values = running.get_real(["mu_map"])
        lines = [running.get_real([n]) for n in ("v_rel_axis", "T_axis")]
        adjoint = np.array([running.adjoint(["mu"], ["mu_map"], seed) for seed in np.eye(3)])
        unit = np.eye(values.size).reshape(-1, *shape)
        weights = np.array([RegularGridInterpolator(lines, u)(loads[:, [V, T]]) for u in unit]).T
        np.testing.assert_allclose(adjoint, weights, atol=1e-12)
        direction = np.random.default_rng(6).normal(size=values.size)
        forward = running.derivative(["mu"], ["mu_map"], direction)
        np.testing.assert_allclose(forward, weights @ direction, rtol=1e-12)
        # A sampling point that moves, against a difference.
        seed = np.eye(len(lines[1]))[1]
        moved = []
        for h in (1e-4, -1e-4):
            running.set_real(["T_axis"], lines[1] + h * seed)
            moved.append(running.get_real(["mu"]))
        running.set_real(["T_axis"], lines[1])
        slope = running.derivative(["mu"], ["T_axis"], seed)
        np.testing.assert_allclose(slope, (moved[0] - moved[1]) / 2e-4, rtol=1e-5, atol=1e-10)


def test_what_cannot_be_a_map_is_refused_and_the_old_one_stays(fmu: UnpackedFmu) -> None:
    with RunningFmu(fmu) as running:
        axis, values = running.get_real(["v_rel_axis"]), running.get_real(["mu_map"])
    wrong = axis.copy()
    wrong[2] = wrong[1]
    for name, new, words in (
        ("v_rel_axis", wrong, rf"v_rel_axis\[3\] = {wrong[2]:g} is not above the sampling point before it"),
        (
            "v_rel_axis",
            np.where(axis == axis[1], np.nan, axis),
            r"v_rel_axis\[2\] = nan is not a finite number",
        ),
        ("mu_map", np.where(values == values[7], np.inf, values), r"mu_map\[\d+,\d+\] = inf is not a finite"),
    ):
        with RunningFmu(fmu) as running:
            with pytest.raises(FmuError, match=words):
                running.set_real([name], new)
            np.testing.assert_array_equal(running.get_real(["v_rel_axis"]), axis)
            np.testing.assert_array_equal(running.get_real(["mu_map"]), values)


def test_the_deviation_that_is_told_is_that_of_the_interpolated_values(law: Path) -> None:
    found = friction_map(read_source(law), axes="v_rel,T", max_rows=60)
    told = found.card["map"]
    largest = told["remaining"]["largest deviation"]
    assert found.note.startswith("map of ") and f"off by at most {largest:.3g} (" in found.note
    assert "sigma_n is held at" in found.note and found.note.splitlines()[0] == told["summary"]
    lines = [np.array(told["axes"][n]) for n in ("v_rel", "T")]
    starts = [p.start for p in found.system if p.name.startswith("mu_map")]
    table = RegularGridInterpolator(lines, np.reshape(starts, [len(x) for x in lines]))
    loads = points_of(8000, seed=9)
    off = np.abs(table(loads[:, [V, T]]) - runtime(law.read_bytes(), inside(loads))).max()
    assert 0.8 * largest < off < 1.2 * largest
    # sigma_n moves mu by 1e-6 a MPa, the map does not know it: by itself it takes the loads that matter.
    chosen = friction_map(read_source(law))
    assert list(chosen.card["map"]["axes"]) == ["v_rel", "T", "sigma_n"]
    assert chosen.card["map"]["remaining"]["largest deviation"] < largest


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"fmi": "2.0"}, "FMI version '2.0' of target 'map', allowed: FMI 3.0"),
        ({"interval": True}, "interval of target 'map'"),
        ({"axes": "v_rel,T,psi,sd"}, "4 loads, allowed: at most 3"),
        ({"axes": "speed"}, "axis of the table 'speed'"),
        ({"rows": 5}, "option of the target 'map' 'rows'.*max_rows"),
        ({"axes": "T", "points": {"T": 9}, "max_rows": 10**6}, "max_rows = 1000000"),
        ({"axes": "v_rel,T,psi", "points": {"v_rel": 20, "T": 20, "psi": 20}}, "20 x 20 x 20 values"),
        ({"axes": "T", "limits": {"T": [80.0, 80.0]}}, "'T' has the one value 80"),
    ],
)
def test_options_that_do_not_fit_are_refused(
    options: dict[str, object], words: str, law: Path, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=words):
        pack(law, tmp_path / "map.fmu", target="map", **options)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def test_a_law_without_a_range_needs_limits() -> None:
    bare = replace(read_source(ConstantFriction(0.1)), domain={})
    with pytest.raises(InputError, match="no trained range is recorded; allowed: give axes, and limits"):
        friction_map(bare)
    made = friction_map(bare, limits={"T": (20.0, 200.0)})
    assert list(made.card["map"]["axes"]) == ["T"] and made.domain == {}
    assert friction_map(made, axes="T", limits={"T": (20.0, 200.0)}).card["map"]["of"]["family"] == "map"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: text.replace("rectilinearGrid", "grid"), "terminalKind .*, allowed: "),
        (lambda text: text.replace('.map"', '.rule"'), "matchingRule .*, better: "),
        (lambda text: text.replace('"T_axis"', '"T_lines"'), "there is no variable 'T_lines'"),
        (lambda text: text.replace('Name="mu_map"', 'Name="T"'), r"codomain 'T' has the shape"),
        (lambda text: text.replace("map.domainInput", "map.input", 1), "variableKind 'input' of 'v_rel'"),
        (lambda text: text.replace("map.codomain", "map.domain"), "domain 'mu_map' has 2 dimensions"),
        (lambda text: "", "terminalsAndIcons.xml is missing"),
    ],
)
def test_check_finds_what_breaks_the_standard(
    change: Callable[[str], str], words: str, fmu: UnpackedFmu, tmp_path: Path
) -> None:
    def findings(fmu: UnpackedFmu) -> list[str]:
        result = tmp_path / "findings"
        result.write_text("")
        maps(fmu, Notes(result))
        return result.read_text().splitlines()

    (good,) = findings(fmu)
    assert '"passed"' in good and "mu_map over v_rel_axis, T_axis" in good
    folder = tmp_path / "changed"
    shutil.copytree(fmu.folder, folder)
    text = change((folder / TERMINALS).read_text())
    (folder / TERMINALS).write_text(text) if text else (folder / TERMINALS).unlink()
    files = {p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*") if p.is_file()}
    damaged = UnpackedFmu.of(write_archive(tmp_path / "damaged.fmu", files))
    found = "\n".join(findings(damaged))
    assert '"failed"' in found
    assert re.search(words, found), found


def test_the_command_tells_the_deviation(
    law: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "map.fmu"
    assert (
        run(
            [
                "pack",
                str(law),
                "--target",
                "map",
                "--set",
                "axes=v_rel,T",
                "--set",
                "max_rows=8",
                "-o",
                str(out),
            ]
        )
        == 0
    )
    said = capsys.readouterr().out
    assert "off by at most" in said and "at 10000 points of the domain" in said
    assert UnpackedFmu.of(out).raw.fmiVersion == "3.0"
