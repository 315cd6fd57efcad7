"""Set-up errors: all at once, with names, values, what is allowed and the nearest valid name."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

from fmus import check
from fmus.runtime.fmu_files import describe, unpack
from forming.results.files import load_result
from friction_models.common import InputError
from orchestrator import System
from orchestrator.cosim.run_folders import Run
from tests.orchestrator.tiny_fmus import system_content


def write(folder: Path, content: object) -> Path:
    path = folder / "system.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    return path


def test_a_sound_system_loads_and_validates(tiny: dict[str, Path], tmp_path: Path) -> None:
    system = System.load(write(tmp_path, system_content(tiny["law"], tiny["process"])))
    system.validate()
    assert system.steps == 10
    assert system.evaluation_order() == ["friction", "forming"]
    copy = System.load(system.save(tmp_path / "elsewhere" / "copy.yaml"))
    copy.validate()
    assert copy.fmu_path("friction") == tiny["law"]


@pytest.mark.parametrize(
    ("change", "pattern"),
    [
        ({"stop_tme": 1.0}, "unknown key 'stop_tme'.*did you mean 'stop_time'"),
        ({"communication_step": -1.0}, "communication_step.*greater than 0.*-1.0"),
        ({"stop_time": 1e300}, "allowed: at most 10000000"),
        ({"stop_time": 1.05}, "not a whole number of communication steps"),
        ({"stop_time": float("nan")}, "stop_time"),
        ({"components": {}}, "components"),
        ({"order": ["friction", "forging"]}, "unknown component 'forging'.*did you mean 'forming'"),
        ({"order": ["friction"]}, "must name every component once"),
        ({"record": ["forming.forse"]}, "'forse'.*did you mean 'force'"),
        ({"connections": ["forming.load -> friction.load"]}, r"input forming\.mu is not connected.*friction\.mu -> forming\.mu"),
        ({"connections": ["forming.lode -> friction.load", "friction.mu -> forming.mu"]}, "did you mean 'load'"),
        ({"connections": ["forming.load > friction.load"]}, "not of the form"),
        ({"connections": ["friction.load -> forming.mu"]}, "causality 'input', allowed: 'output'"),
        ({"connections": ["forming.high -> friction.load[1]"]}, "type Boolean"),
    ],
)  # fmt: skip
def test_what_does_not_hold_is_said(
    tiny: dict[str, Path], tmp_path: Path, change: dict[str, object], pattern: str
) -> None:
    path = write(tmp_path, system_content(tiny["law"], tiny["process"], **change))
    with pytest.raises(InputError, match=pattern) as caught:
        System.load(path).validate()
    assert str(caught.value).startswith(str(path))


def test_all_problems_are_shown_at_once(tiny: dict[str, Path], tmp_path: Path) -> None:
    content = system_content(
        tiny["law"],
        tiny["process"],
        connections=["forming.lod -> friction.load", "friction.mu -> forming.my"],
        record=["forming.strok"],
    )
    content["components"]["friction"]["start"] = {"ofset": 0.2, "offset": "high"}  # type: ignore[index]
    with pytest.raises(InputError, match="5 problems") as caught:
        System.from_dict(content).validate()
    for hint in ("'load'", "'mu'", "'stroke'", "'offset'", "allowed: Real"):
        assert hint in str(caught.value)


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_a_start_value_that_is_no_number_is_refused(value: float, tiny: dict[str, Path]) -> None:
    content = system_content(tiny["law"], tiny["process"])
    content["components"]["friction"]["start"] = {"offset": value}  # type: ignore[index]
    with pytest.raises(InputError, match=rf"start value 'offset' is {value}; allowed: Real, a finite number"):
        System.from_dict(content).validate()


def test_vectors_of_different_length_do_not_connect(tiny: dict[str, Path]) -> None:
    with pytest.raises(InputError, match=r"forming\.load has 2 elements, friction\.load has 1.*--nodes 2"):
        System.from_dict(system_content(tiny["scalar_law"], tiny["process"])).validate()


def test_units_must_fit(tiny: dict[str, Path], tmp_path: Path) -> None:
    for name, unit in (("law", "MPa"), ("process", "Pa")):
        with zipfile.ZipFile(tiny[name]) as source, zipfile.ZipFile(tmp_path / f"{name}.fmu", "w") as target:
            for item in source.infolist():
                data = source.read(item)
                if item.filename == "modelDescription.xml":
                    units = f'<UnitDefinitions><Unit name="{unit}"/></UnitDefinitions><ModelVariables>'
                    text = data.decode().replace("<ModelVariables>", units)
                    parts = text.split("<ScalarVariable ")
                    parts = [
                        p.replace("<Real", f'<Real unit="{unit}"', 1) if 'name="load' in p else p
                        for p in parts
                    ]
                    data = "<ScalarVariable ".join(parts).encode()
                target.writestr(item, data)
    with pytest.raises(InputError, match="'load\\[1\\]' is in 'Pa', 'load\\[1\\]' in 'MPa'"):
        System.from_dict(system_content(tmp_path / "law.fmu", tmp_path / "process.fmu")).validate()


def test_swap_of_an_unknown_component(tiny: dict[str, Path]) -> None:
    system = System.from_dict(system_content(tiny["law"], tiny["process"]))
    with pytest.raises(InputError, match="did you mean 'friction'"):
        system.swap("fricton", tiny["law"])


@pytest.mark.parametrize(
    ("text", "pattern"),
    [("", "empty"), ("- a\n- b\n", "mapping"), ("a: [1", "not YAML"), ("!!python/object/apply:os.getcwd []", "not YAML"), ("a: &x [1]\nb: [*x, *x]\n", "alias"), ("a: " + "[" * 40, "nested deeper")],
)  # fmt: skip
def test_files_that_are_no_system(tmp_path: Path, text: str, pattern: str) -> None:
    path = tmp_path / "system.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=pattern):
        System.load(path)
    with pytest.raises(InputError, match="no such file"):
        System.load(tmp_path / "nowhere.yaml")


def archive(path: Path, members: dict[str, bytes | str]) -> Path:
    with zipfile.ZipFile(path, "w") as file:
        for name, data in members.items():
            file.writestr(name, data)
    return path


XML = '<?xml version="1.0"?><fmiModelDescription fmiVersion="{}" modelName="x" guid="g"/>'


@pytest.mark.parametrize(
    ("members", "pattern"),
    [
        ({"readme.txt": "no FMU"}, "no modelDescription.xml"),
        ({"modelDescription.xml": "<not xml"}, "not readable XML"),
        ({"modelDescription.xml": XML.format("1.0")}, "FMI version '1.0'"),
        ({"modelDescription.xml": XML.format("3.0")}, "FMI 3.0"),
        ({"modelDescription.xml": XML.format("2.0")}, "FMI 2.0|co-simulation"),
        ({"modelDescription.xml": '<!DOCTYPE a [<!ENTITY b "c">]><a/>'}, "document type"),
        ({"modelDescription.xml": XML.format("2.0"), "../../evil.sh": "rm"}, "points outside the archive"),
        ({"modelDescription.xml": XML.format("2.0"), "/etc/evil": "rm"}, "points outside the archive"),
    ],
)  # fmt: skip
def test_hostile_and_foreign_archives_are_refused(
    tmp_path: Path, members: dict[str, bytes | str], pattern: str
) -> None:
    with pytest.raises(InputError, match=pattern):
        describe(archive(tmp_path / "x.fmu", members))


def test_corrupt_archives_are_refused(tiny: dict[str, Path], tmp_path: Path) -> None:
    garbage = tmp_path / "garbage.fmu"
    garbage.write_bytes(b"\x00\x01\x02" * 100)
    with pytest.raises(InputError, match="not a readable ZIP archive"):
        describe(garbage)
    data = bytearray(tiny["law"].read_bytes())
    cut = tmp_path / "cut.fmu"
    cut.write_bytes(data[: len(data) // 2])
    with pytest.raises(InputError, match="not a readable ZIP archive"):
        describe(cut)
    with zipfile.ZipFile(tiny["law"]) as file:
        binary = next(i for i in file.infolist() if i.filename.endswith(".so"))
    for k in range(binary.header_offset + 200, binary.header_offset + 400):
        data[k] ^= 0xFF
    flipped = tmp_path / "flipped.fmu"
    flipped.write_bytes(data)
    (tmp_path / "out").mkdir()
    with pytest.raises(InputError, match=r"cannot be unpacked|damaged"):
        unpack(describe(flipped), tmp_path / "out")


def test_an_fmu_without_this_platform_is_refused(tiny: dict[str, Path], tmp_path: Path) -> None:
    with zipfile.ZipFile(tiny["law"]) as source:
        only = {"modelDescription.xml": source.read("modelDescription.xml"), "binaries/vax/x.so": b""}
    (tmp_path / "out").mkdir()
    with pytest.raises(InputError, match=r"no binary for the platform.*present: vax"):
        unpack(describe(archive(tmp_path / "x.fmu", only)), tmp_path / "out")


@pytest.mark.parametrize("name", ["../../evil", "/abs", "a.b", "a->b", "", " x", "x ", "x" * 101, "a\\b"])
def test_component_names_are_no_paths(tiny: dict[str, Path], name: str) -> None:
    content = system_content(tiny["law"], tiny["process"], connections=[])
    content["components"] = {name: {"fmu": str(tiny["law"])}}
    with pytest.raises(InputError, match="component name"):
        System.from_dict(content)


@pytest.mark.parametrize(
    ("exchange", "limits"),
    [
        ("fmi2Integer", (-(2**31), 2**31 - 1)),
        ("fmi3UInt8", (0, 255)),
        ("fmi3Int16", (-32768, 32767)),
        ("fmi3UInt64", (0, 2**53)),
    ],
)
def test_whole_numbers_fit_their_type(exchange: str, limits: tuple[int, int]) -> None:
    from fmus.runtime.fmu_variables import integer_limits

    assert integer_limits(exchange) == limits


@pytest.mark.parametrize("read", [System.load, check, Run.load, load_result])
def test_what_is_no_path_is_refused(read: Callable[[Any], object]) -> None:
    for nonsense in (None, 5, b"system.yaml"):
        with pytest.raises(InputError, match="is no path; allowed: the path of a"):
            read(nonsense)
