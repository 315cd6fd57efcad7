"""`check` on archives whose parts do not belong together: a replaced model, units with other factors; fast memory."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path

import onnx
import pytest

from fmus import check, pack
from fmus.archive.content import write_archive
from tests.fmus.graphs import save
from tests.fmus.memory_models import ageing_bytes

Pack = Callable[..., Path]
pytestmark = pytest.mark.usefixtures("trials_here")


def content_of(fmu: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(fmu) as archive:
        return {n: archive.read(n) for n in archive.namelist()}


@pytest.mark.parametrize("content", [None, b"not a model", "float32", "no mu"])
def test_a_replaced_model_is_found(
    content: bytes | str | None, packed: Pack, linear_onnx: Path, tmp_path: Path
) -> None:
    files = content_of(packed(linear_onnx))
    del files["resources/model.onnx"]
    if isinstance(content, bytes):
        files["resources/model.onnx"] = content
    elif content is not None:
        model = onnx.load_from_string(linear_onnx.read_bytes())
        if content == "float32":
            model.graph.input[0].type.tensor_type.elem_type = onnx.TensorProto.FLOAT
        else:
            model.graph.output[0].name = model.graph.node[-1].output[0] = "nu"
        files["resources/model.onnx"] = model.SerializeToString()
    report = check(write_archive(tmp_path / "replaced.fmu", files))
    assert not report.ok
    (told,) = (m for m in report.messages if "mu against ONNX Runtime" in m)
    assert told.startswith("failed: ") and "resources/model.onnx" in told


def test_another_tool_may_keep_what_it_likes(packed: Pack, linear_onnx: Path, tmp_path: Path) -> None:
    files = content_of(packed(linear_onnx)) | {"resources/model.onnx": b"weights of theirs"}
    name = "modelDescription.xml"
    files[name] = files[name].replace(b'generationTool="tribofmu"', b'generationTool="other"')
    report = check(write_archive(tmp_path / "other.fmu", files))
    assert report.ok and any(m.startswith("skipped: mu against ONNX Runtime") for m in report.messages)


@pytest.mark.parametrize(
    ("fmi", "right", "wrong", "said"),
    [
        ("3.0", b's="-1" factor="0.001"/>', b's="-1" factor="1.0"/>', "unit 'mm/s' is defined with factor '1.0', allowed: 0.001"),
        ("2.0", b's="-1" factor="0.001"/>', b's="-1"/>', "unit 'mm/s' is defined with factor '1.0', allowed: 0.001"),
        ("3.0", b'offset="273.15"', b'offset="0"', "unit 'degC' is defined with offset '0', allowed: 273.15"),
        ("2.0", b'm="-1" s="-2"', b'm="-2" s="-2"', "unit 'MPa' is defined with exponent of m '-2', allowed: -1"),
    ],
)  # fmt: skip
def test_a_unit_with_a_wrong_definition_is_found(
    fmi: str, right: bytes, wrong: bytes, said: str, linear_onnx: Path, tmp_path: Path
) -> None:
    files = content_of(pack(linear_onnx, tmp_path / "good.fmu", fmi=fmi))
    assert right in files["modelDescription.xml"]
    files["modelDescription.xml"] = files["modelDescription.xml"].replace(right, wrong)
    report = check(write_archive(tmp_path / "wrong.fmu", files))
    assert not report.ok and any(m.startswith(f"failed: {said}") for m in report.messages)


def test_fast_memory_is_told(tmp_path: Path) -> None:
    path = pack(save(ageing_bytes(distance=2.5), tmp_path / "fast.onnx"), tmp_path / "fast.fmu")
    told = "time constants down to about 0.005 s: explicit solvers diverge with steps above about 0.01 s"
    assert any(m.startswith("noted: ") and told in m for m in check(path).messages)
    with zipfile.ZipFile(path) as archive:
        assert told in archive.read("documentation/index.html").decode()


def test_quick_memory_agrees_between_the_interfaces(tmp_path: Path) -> None:
    """Over 0.1 s in one step the memory of this graph (Euler's rule) is far from what a solver finds."""
    report = check(pack(save(ageing_bytes(distance=10.0), tmp_path / "x.onnx"), tmp_path / "x.fmu"))
    assert any(m.startswith("passed: mu is that of co-simulation") for m in report.messages), str(report)
