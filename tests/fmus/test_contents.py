"""What a native FMU carries besides its library: sources that compile, pictures, terminals, licence, reference results."""

from __future__ import annotations

import csv
import os
import shutil
import struct
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
import pytest
from lxml import etree

from fmus import pack
from fmus.pages.presentation import licence_text
from fmus.runtime.running import RunningFmu, UnpackedFmu
from fmus.source.reading import read_source
from fmus.source.reference_results import FOLDER, MAX_POINTS, reference_files
from friction_models.loads import LOAD_NAMES
from tests.fmus.memory_models import ageing_bytes

Get = Callable[[str, int], Path]
#: The headers of the standard, which an FMU must not carry.
HEADERS = Path(fmpy.__file__).parent / "c-code"
SCHEMA = Path(fmpy.__file__).parent / "schema" / "fmi3"


@pytest.fixture(scope="module")
def ageing_onnx(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("contents") / "ageing.onnx"
    path.write_bytes(ageing_bytes())
    return path


@pytest.fixture(scope="module")
def ageing(ageing_onnx: Path) -> Get:
    made: dict[tuple[str, int], Path] = {}

    def get(fmi: str, nodes: int) -> Path:
        if (fmi, nodes) not in made:
            path = ageing_onnx.parent / f"{fmi}-{nodes}.fmu"
            made[fmi, nodes] = pack(ageing_onnx, path, fmi=fmi, nodes=nodes)
        return made[fmi, nodes]

    return get


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_sources_compile_with_fmpy(
    ageing: Get, fmi: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from fmpy.build import build_platform_binary

    # The CMake of the development requirements lies beside this interpreter.
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent), prepend=os.pathsep)
    if shutil.which("cmake") is None:
        pytest.skip("CMake is not installed")
    if shutil.which("make") is None and os.name == "posix":
        pytest.skip("make is not installed, which CMake's build needs")
    if not any(shutil.which(c) for c in ("cc", "gcc", "clang", "cl")):
        pytest.skip("no C compiler is installed, and CMake finds none inside the extra [cross]")
    own = UnpackedFmu.of(ageing(fmi, 1))
    folder = tmp_path / "unpacked"
    shutil.copytree(own.folder, folder)
    binaries = [b for b in (folder / "binaries").rglob("*") if b.is_file()]
    for binary in binaries:
        binary.unlink()
    build_platform_binary(folder, all_warnings=True)
    assert any(b.is_file() for b in binaries)
    archive = Path(shutil.make_archive(str(tmp_path / "again"), "zip", folder))
    again = archive.rename(tmp_path / "again.fmu")
    results = []
    for fmu in (own, UnpackedFmu.of(again)):
        with RunningFmu(fmu, start={"v_rel": 80.0}) as running:
            running.step(0.0, 0.1)
            results.append(running.get_real(["mu", "age", "der(age)"]))
    np.testing.assert_allclose(results[1], results[0], rtol=1e-13)


@pytest.mark.parametrize("main", ["fmi2.c", "fmi3.c"])
@pytest.mark.parametrize("memory", [True, False])
def test_sources_have_no_warnings(
    main: str, memory: bool, ageing: Get, linear_onnx: Path, tmp_path: Path
) -> None:
    compiler = shutil.which("gcc") or shutil.which("clang") or shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler is installed")
    version = f"{main[3]}.0"
    path = ageing(version, 1) if memory else pack(linear_onnx, tmp_path / "linear.fmu", fmi=version)
    fmu = UnpackedFmu.of(path)
    warnings = ["-Wall", "-Wextra", "-Wshadow", "-pedantic", "-Werror", "-isystem", str(HEADERS)]
    command = [compiler, "-std=c99", "-O1", *warnings, "-c", main, "-o", str(tmp_path / "x.o")]
    done = subprocess.run(command, cwd=fmu.folder / "sources", capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:2000]


@pytest.mark.parametrize(
    ("file", "schema"),
    [
        ("terminalsAndIcons/terminalsAndIcons.xml", "fmi3TerminalsAndIcons.xsd"),
        ("sources/buildDescription.xml", "fmi3BuildDescription.xsd"),
        ("modelDescription.xml", "fmi3ModelDescription.xsd"),
    ],
)
def test_xml_files_keep_to_their_schemas(file: str, schema: str, ageing: Get) -> None:
    checker = etree.XMLSchema(etree.parse(str(SCHEMA / schema)))
    with zipfile.ZipFile(ageing("3.0", 3)) as archive:
        root = etree.fromstring(archive.read(file))
    assert checker.validate(root), checker.error_log


def test_terminal_of_the_friction_port(ageing: Get) -> None:
    fmu = UnpackedFmu.of(ageing("3.0", 1))
    folder = fmu.folder / "terminalsAndIcons"
    terminal = etree.parse(str(folder / "terminalsAndIcons.xml")).find("Terminals/Terminal")
    assert (terminal.get("terminalKind"), terminal.get("matchingRule")) == ("org.tribofmu.friction", "plug")
    members = [m.get("variableName") for m in terminal.iter("TerminalMemberVariable")]
    assert members == [*LOAD_NAMES, "mu"]
    assert set(members) <= set(fmu.variables)
    base = terminal.find("TerminalGraphicalRepresentation").get("iconBaseName")
    for name in (f"{base}.png", f"{base}.svg", "icon.png", "icon.svg"):
        assert (folder / name).is_file()


def test_icon_is_a_picture(ageing: Get) -> None:
    for path, name in ((ageing("2.0", 1), "model.png"), (ageing("3.0", 1), "terminalsAndIcons/icon.png")):
        with zipfile.ZipFile(path) as archive:
            content = archive.read(name)
        assert content[:8] == b"\x89PNG\r\n\x1a\n"
        width, height = struct.unpack(">II", content[16:24])
        assert width == height >= 100


def test_licences(ageing: Get, ageing_onnx: Path) -> None:
    here = Path(__file__).parents[2] / "LICENSE"
    for fmi in ("2.0", "3.0"):
        with zipfile.ZipFile(ageing(fmi, 1)) as archive:
            text = archive.read("documentation/licenses/license.txt").decode()
            root = etree.fromstring(archive.read("modelDescription.xml"))
        assert here.read_text(encoding="utf-8").strip() in text
        assert "belongs to its author" in text
        assert "MIT" in root.get("license")
    source = read_source(ageing_onnx)
    source.card.update(author="A. Person", licence="CC-BY-4.0")
    assert "its author (A. Person). Licence: CC-BY-4.0" in licence_text(source)


@pytest.mark.parametrize(("fmi", "nodes"), [("2.0", 1), ("2.0", 3), ("3.0", 1), ("3.0", 3)])
def test_reference_results_are_what_the_fmu_computes(ageing: Get, fmi: str, nodes: int) -> None:
    fmu = UnpackedFmu.of(ageing(fmi, nodes))

    def read(name: str) -> tuple[list[str], np.ndarray]:
        with (fmu.folder / FOLDER / name).open(encoding="utf-8", newline="") as stream:
            rows = list(csv.reader(stream))
        return rows[0], np.array(rows[1:], dtype=float)

    inputs, stimuli = read("stimuli.csv")
    outputs, references = read("references.csv")
    assert inputs[0] == outputs[0] == "time"
    names = list(dict.fromkeys(n for n in outputs[1:] if n != "in_domain"))
    shown = outputs.index("in_domain")
    with RunningFmu(fmu) as running:
        for row, expected in zip(stimuli, references):
            assert row[0] == expected[0]
            running.set_real(list(dict.fromkeys(inputs[1:])), row[1:])
            got = running.get_real(names)
            np.testing.assert_allclose(got, np.delete(expected, [0, shown]), rtol=1e-9, atol=1e-12)
            assert running.get_boolean("in_domain") == bool(expected[shown])
            running.step(row[0], 0.1)
    assert {0.0, 1.0} == set(references[:, shown])
    assert len(np.unique(references[:, 1])) > 5


def test_manifest_names_what_is_there(ageing: Get, ageing_onnx: Path) -> None:
    fmu = UnpackedFmu.of(ageing("3.0", 1))
    folder = fmu.folder / FOLDER
    root = etree.parse(str(folder / "fmi-ls-manifest.xml")).getroot()
    space = "{http://fmi-standard.org/fmi-ls-manifest}"
    assert root.tag == "fmiReferences"
    assert root.get(f"{space}fmi-ls-name") == "org.fmi-standard.fmi-ls-ref"
    related = {r.get("role"): r for r in root.iter("Related")}
    assert {"experiment/smoke-test", "model", "result"} <= set(related)
    for r in root.iter("Related"):
        assert (folder / r.get("source")).resolve().is_file(), r.get("source")
    experiment = etree.parse(str(folder / related["experiment/smoke-test"].get("source"))).find("Experiment")
    assert [c.tag for c in experiment] == ["Stimuli", "References"]
    source = read_source(ageing_onnx)
    many = MAX_POINTS + 1
    assert reference_files(source, source.interface(many), "3.0") == {}
    header = reference_files(source, source.interface(many), "2.0")[f"{FOLDER}/stimuli.csv"].splitlines()[0]
    assert header.count(b'"v_rel[') == MAX_POINTS
