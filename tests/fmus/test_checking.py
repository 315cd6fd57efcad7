"""Hostile, damaged and foreign archives; `check`; friction FMUs read as fixed models."""

from __future__ import annotations

import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from lxml import etree

from fmus import check, pack, read_friction_fmu
from fmus.archive.content import write_archive
from friction_models import LinearFriction
from friction_models.common import InputError
from friction_models.loads import TriboLoads
from tests.fmus.graphs import BOX, graph_bytes, node, random_loads, runtime, save
from tests.friction_models.made_up import campaign

Pack = Callable[..., Path]


def content_of(fmu: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(fmu) as archive:
        return {n: archive.read(n) for n in archive.namelist()}


def test_a_good_fmu_in_python_passes(packed: Pack, memory_onnx: Path) -> None:
    """Native ones: `test_check_limits`."""
    report = check(packed(memory_onnx, "python"))
    assert report.ok, str(report)
    text = str(report)
    for words in (
        "schema and semantics",
        "second instance",
        "exact replay",
        "ONNX Runtime",
        "memory over 10 steps",
    ):
        assert words in text


@pytest.mark.usefixtures("trials_here")
@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
@pytest.mark.parametrize("lacking", [("T",), ("T", "sd"), ("T", "sd", "psi"), ("v_rel",)])
def test_a_model_trained_without_some_loads_passes(
    lacking: tuple[str, ...], fmi: str, tmp_path: Path
) -> None:
    model = LinearFriction().fit_frame(campaign(8, 10).drop(columns=list(lacking)))
    fmu = pack(model, tmp_path / "less.fmu", fmi=fmi, nodes=1 if fmi == "3.0" else 2)
    report = check(fmu)
    assert report.ok, str(report)
    assert "in_domain is true inside" in str(report)
    xml = etree.fromstring(content_of(fmu)["modelDescription.xml"])
    said = {v.get("name").partition("[")[0]: v.get("description") for v in xml.iterfind("ModelVariables/*")}
    assert {n for n in BOX if "not measured in training, no influence" in said[n]} == set(lacking)


@pytest.mark.usefixtures("trials_here")
def test_a_binary_that_does_not_fit_the_packed_model_is_found(
    packed: Pack, linear_onnx: Path, tmp_path: Path
) -> None:
    files = content_of(packed(linear_onnx))
    other = graph_bytes([node("Gemm", "loads w", "mu")], {"w": np.full((5, 1), 1e-5)})
    files["resources/model.onnx"] = other
    report = check(write_archive(tmp_path / "swapped.fmu", files))
    assert not report.ok
    assert any(m.startswith("failed: mu against ONNX Runtime") for m in report.messages)


@pytest.mark.usefixtures("trials_here")
def test_wrong_unit_and_missing_platform_are_found(packed: Pack, linear_onnx: Path, tmp_path: Path) -> None:
    files = content_of(packed(linear_onnx))
    xml = (
        files["modelDescription.xml"]
        .replace(b'unit="degC"', b'unit="K"')
        .replace(b'<Unit name="degC">', b'<Unit name="K">')
    )
    files["modelDescription.xml"] = xml
    files = {n: c for n, c in files.items() if not n.startswith("binaries/")}
    report = check(write_archive(tmp_path / "unit.fmu", files))
    text = str(report)
    assert not report.ok
    assert "unit of 'T' is 'K', allowed: 'degC'" in text
    assert "failed: platforms: none, source code" in "\n".join(report.messages)


def bad_archives(good: Path, folder: Path) -> dict[str, tuple[Path, str]]:
    files = content_of(good)
    made: dict[str, tuple[Path, str]] = {}

    def make(name: str, words: str, content: bytes | dict[str, bytes]) -> None:
        path = folder / f"{name}.fmu"
        if isinstance(content, bytes):
            path.write_bytes(content)
        else:
            with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
                for member, data in content.items():
                    archive.writestr(member, data)
        made[name] = (path, words)

    whole = good.read_bytes()
    xml = files["modelDescription.xml"]
    make("text", "not a readable ZIP archive", b"not an FMU at all")
    make("empty", "not a readable ZIP archive", b"")
    make("truncated", "not a readable ZIP archive", whole[: len(whole) // 2])
    make("no_description", "there is no modelDescription.xml", {"readme.txt": b"hello"})
    make("not_xml", "not readable XML", files | {"modelDescription.xml": b"<fmi"})
    make("other_xml", "holds 'svg'", files | {"modelDescription.xml": b"<svg/>"})
    make("escape", "points outside the archive", files | {"../escaped.txt": b"gotcha"})
    make("absolute", "points outside the archive", files | {"/tmp/escaped.txt": b"gotcha"})
    entities = b'<!DOCTYPE x [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]>'
    make(
        "entities",
        "document type",
        files | {"modelDescription.xml": xml.replace(b"<fmiModel", entities + b"<fmiModel", 1)},
    )
    # The header of the central directory claims more than a gigabyte for the first member.
    bomb = bytearray(whole)
    start = bomb.index(b"PK\x01\x02")
    bomb[start + 24 : start + 28] = struct.pack("<I", 0xFFFFFFF0)
    make("bomb", "unpacks to", bytes(bomb))
    overlap = bytearray(whole)
    second = overlap.index(b"PK\x01\x02", start + 4)
    overlap[second + 42 : second + 46] = bytes(4)
    make("overlap", "lies in another one", bytes(overlap))
    for name, other in (
        ("capitals", "RESOURCES/model.ONNX"),
        ("folder", "resources"),
        ("reserved", "resources/nul.txt"),
        ("dot", "resources/readme."),
        ("drive", "c:readme.txt"),
        ("long", "resources/" + "a" * 300),
    ):
        words = {
            "capitals": "stands twice",
            "folder": "is a file and a folder",
            "drive": "points outside",
            "long": "has more than 240 bytes",
        }
        make(name, words.get(name, "cannot exist on Windows"), files | {other: b"hello"})
    link = zipfile.ZipInfo("resources/link")
    link.create_system, link.external_attr = 3, 0o120777 << 16
    squeezed = zipfile.ZipInfo("resources/zeros")
    squeezed.compress_type = zipfile.ZIP_BZIP2
    for name, member, words in (
        ("link", link, "is a link or a device"),
        ("bzip2", squeezed, "allowed: stored or deflate"),
    ):
        make(name, words, files)
        with zipfile.ZipFile(folder / f"{name}.fmu", "a") as archive:
            archive.writestr(member, b"/etc")
    hidden = b'<!DOCTYPE x [<!ENTITY a "aaaa">]><x>&a;</x>'
    make("terminals", "declares a document type", files | {"terminalsAndIcons/terminalsAndIcons.xml": hidden})
    damaged = bytearray(whole)
    damaged[60:400] = bytes(340)
    make("damaged", "modelDescription.xml", bytes(damaged))
    return made


NAMES = (
    "text",
    "empty",
    "truncated",
    "no_description",
    "not_xml",
    "other_xml",
    "escape",
    "absolute",
    "entities",
    "bomb",
    "damaged",
    "overlap",
    "capitals",
    "folder",
    "reserved",
    "dot",
    "drive",
    "long",
    "link",
    "bzip2",
    "terminals",
)


@pytest.mark.parametrize("name", NAMES)
def test_bad_archives_are_refused_with_one_sentence(
    name: str, packed: Pack, linear_onnx: Path, tmp_path: Path
) -> None:
    path, words = bad_archives(packed(linear_onnx), tmp_path)[name]
    before = sorted(p.name for p in tmp_path.rglob("*"))
    for act in (check, read_friction_fmu):
        with pytest.raises(InputError, match=words) as caught:
            act(path)
        assert str(path) in str(caught.value)
        assert "\n" not in str(caught.value)
    assert sorted(p.name for p in tmp_path.rglob("*")) == before
    assert not (tmp_path.parent / "escaped.txt").exists()


def test_an_fmu_that_is_no_friction_model_is_named(packed: Pack, linear_onnx: Path, tmp_path: Path) -> None:
    files = content_of(packed(linear_onnx))
    xml = files["modelDescription.xml"]
    files["modelDescription.xml"] = xml.replace(b'name="sigma_n"', b'name="sigmaN"')
    with pytest.raises(InputError, match=r"unknown variable 'sigma_n'.*did you mean 'sigmaN'"):
        read_friction_fmu(write_archive(tmp_path / "renamed.fmu", files))
    files["modelDescription.xml"] = xml.replace(b'unit="MPa"', b'unit="Pa"')
    with pytest.raises(InputError, match="variable 'sigma_n' has unit 'Pa', allowed: 'MPa'"):
        read_friction_fmu(write_archive(tmp_path / "pascal.fmu", files))
    files["modelDescription.xml"] = xml.replace(b'fmiVersion="2.0"', b'fmiVersion="1.0"')
    with pytest.raises(InputError, match=r"FMI version '1\.0', allowed"):
        read_friction_fmu(write_archive(tmp_path / "old.fmu", files))
    with pytest.raises(InputError, match="no such FMU"):
        read_friction_fmu(tmp_path / "none.fmu")


@pytest.mark.parametrize("nodes", [1, 4])
def test_a_friction_fmu_predicts(packed: Pack, linear_onnx: Path, nodes: int) -> None:
    loads = random_loads(7, seed=2, outside=False)
    model = read_friction_fmu(packed(linear_onnx, "native", nodes))
    np.testing.assert_allclose(model.predict(loads), runtime(linear_onnx.read_bytes(), loads), rtol=1e-12)
    assert model.domain.to_dict() == BOX
    assert model.formula_text() == "line"


@pytest.mark.parametrize("nodes", [1, 4])
def test_arrays_of_fmi_3_are_read(nodes: int, linear_onnx: Path, memory_onnx: Path, tmp_path: Path) -> None:
    """As many points at once as there are, whatever the default; memory and system variables test by test."""
    loads = random_loads(1500, seed=2, outside=False)
    model = read_friction_fmu(pack(linear_onnx, tmp_path / "line.fmu", fmi="3.0", nodes=nodes))
    assert model.nodes == nodes
    np.testing.assert_allclose(model.predict(loads), runtime(linear_onnx.read_bytes(), loads), rtol=1e-12)
    array = np.tile([100.0, 100.0, 1000.0, 0.0, 2.0], (6, 1))
    t = np.array([0.0, 0.5, 1.0, 0.0, 1.0, 3.0])
    points = TriboLoads(
        *array.T,
        t=t,
        test_id=np.array(["a", "a", "a", "b", "b", "b"]),
        context=pd.DataFrame({"Ra": [0.2, 0.7]}, index=["a", "b"]),
    )
    roughness = np.repeat([0.2, 0.7], 3)
    for fmi in ("2.0", "3.0"):
        fmu = pack(memory_onnx, tmp_path / f"memory{fmi[0]}.fmu", fmi=fmi, nodes=nodes)
        expected = 0.05 + 0.1 * roughness + 0.01 * (1.0 + t)
        np.testing.assert_allclose(read_friction_fmu(fmu).predict(points), expected, rtol=1e-12)
        still = TriboLoads(*array.T, test_id=points.test_id, context=points.context)
        expected = 0.05 + 0.1 * roughness + 0.01
        np.testing.assert_allclose(read_friction_fmu(fmu).predict(still), expected, rtol=1e-12)


@pytest.mark.parametrize("target", ["native", "python"])
def test_a_network_from_elsewhere_can_be_packed(target: str, tmp_path: Path) -> None:
    """Single precision, names of its own, no metadata: five inputs in the order of the contract."""
    from onnx import TensorProto, helper, numpy_helper

    rng = np.random.default_rng(1)
    weights = {
        "w": rng.normal(size=(5, 8)) * 1e-3,
        "b": rng.normal(size=8),
        "v": rng.normal(size=(8, 1)) * 0.02,
    }
    graph = helper.make_graph(
        [
            node("Gemm", "x w b", "h"),
            node("Relu", "h", "r"),
            node("MatMul", "r v", "a"),
            node("Abs", "a", "y"),
        ],
        "net",
        [helper.make_tensor_value_info("x", TensorProto.FLOAT, ["batch", 5])],
        [helper.make_tensor_value_info("y", TensorProto.FLOAT, ["batch", 1])],
        [numpy_helper.from_array(w.astype(np.float32), n) for n, w in weights.items()],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 20)], ir_version=10)
    path = pack(save(model.SerializeToString(), tmp_path / "net.onnx"), tmp_path / "net.fmu", target=target)
    loads = random_loads(5)
    hidden = np.maximum(loads @ weights["w"] + weights["b"], 0.0)
    expected = np.abs(hidden @ weights["v"])[:, 0]
    np.testing.assert_allclose(read_friction_fmu(path).predict(loads), expected, rtol=1e-4)


def test_memory_acts_where_the_data_has_time(packed: Pack, memory_onnx: Path) -> None:
    array = np.tile([100.0, 100.0, 1000.0, 0.0, 2.0], (6, 1))
    t = np.array([0.0, 0.5, 1.0, 0.0, 1.0, 3.0])
    loads = TriboLoads(*array.T, t=t, test_id=np.array(["a", "a", "a", "b", "b", "b"]))
    mu = read_friction_fmu(packed(memory_onnx)).predict(loads)
    np.testing.assert_allclose(mu, 0.05 + 0.02 + 0.01 * (1.0 + t), rtol=1e-12)


def test_the_names_of_the_package_are_functions(linear_onnx: Path, tmp_path: Path) -> None:
    import fmus.checks.checking
    import fmus.targets.packing

    assert callable(fmus.pack)
    assert callable(fmus.check)
    assert fmus.pack is pack


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("nowhere.onnx", "no such file or folder"),
        ("folder", "no model.onnx in this folder"),
        ("text.onnx", "not an ONNX"),
        ("six.onnx", "allowed: 5 columns"),
    ],
)
def test_models_that_cannot_be_packed(source: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "text.onnx").write_text("hello, this is no model")
    from onnx import TensorProto, helper

    wide = helper.make_graph(
        [node("ReduceSum", "x", "mu")],
        "g",
        [helper.make_tensor_value_info("x", TensorProto.DOUBLE, ["n", 6])],
        [helper.make_tensor_value_info("mu", TensorProto.DOUBLE, ["n", 1])],
    )
    save(helper.make_model(wide).SerializeToString(), tmp_path / "six.onnx")
    with pytest.raises(InputError, match=words):
        pack(tmp_path / source, tmp_path / "out.fmu")
    with pytest.raises(InputError, match=r"model is a dict; allowed"):
        pack({}, tmp_path / "out.fmu")
    assert not (tmp_path / "out.fmu").exists()


def test_a_folder_with_the_graph_of_another_model_is_refused(tmp_path: Path) -> None:
    frame = campaign(tests=4)
    LinearFriction().fit_frame(frame).save(tmp_path / "linear")
    LinearFriction().fit_frame(frame.assign(mu=frame["mu"] + 0.02)).save(tmp_path / "other")
    pack(tmp_path / "linear", tmp_path / "linear.fmu")
    (tmp_path / "linear" / "model.onnx").write_bytes((tmp_path / "other" / "model.onnx").read_bytes())
    # The FMU would say another mu than `predict`, which reads parameters.npz.
    with pytest.raises(InputError, match="are of two models"):
        pack(tmp_path / "linear", tmp_path / "mixed.fmu")
    for name in ("model.onnx", "parameters.npz"):
        original = (tmp_path / "linear.fmu").read_bytes()
        LinearFriction().fit_frame(frame).save(tmp_path / "linear")
        assert pack(tmp_path / "linear", tmp_path / "again.fmu").read_bytes() == original
        (tmp_path / "linear" / name).write_bytes((tmp_path / "other" / name).read_bytes())
        with pytest.raises(InputError, match=f"{name} and card.json are of two models"):
            pack(tmp_path / "linear", tmp_path / "mixed.fmu")
    # Without hashes, as earlier versions wrote them, what the card says of the graph is compared.
    card = tmp_path / "other" / "card.json"
    card.write_text(card.read_text().replace('"sha256"', '"told"').replace('"points": ', '"points": 1'))
    with pytest.raises(InputError, match="are of two models \\(data differs\\)"):
        pack(tmp_path / "other", tmp_path / "mixed.fmu")
    assert not (tmp_path / "mixed.fmu").exists()
