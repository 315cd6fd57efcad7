"""Damage that only shows when a graph is run or a member unpacked: refused where it comes in, not by the next command."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnx
import pytest
from onnx import numpy_helper

from fmus import pack
from fmus.ssp.systems import SspComponent, Structure
from fmus.ssp.writing import write_ssp
from friction_models import ConstantFriction, LinearFriction
from friction_models.common import InputError
from tests.orchestrator.cli.test_command_line import points


@pytest.fixture(scope="module")
def graph(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("model") / "model.onnx"
    LinearFriction().fit_frame(points(3, 12)).to_onnx(path)
    return path


@pytest.mark.parametrize("target", ["native", "python"])
def test_a_graph_of_no_numbers_is_refused(graph: Path, tmp_path: Path, target: str) -> None:
    model = onnx.load(graph)
    for tensor in model.graph.initializer:
        values = numpy_helper.to_array(tensor)
        if values.dtype == np.float64:
            tensor.CopyFrom(numpy_helper.from_array(np.full_like(values, np.nan), tensor.name))
    onnx.save(model, tmp_path / "nan.onnx")
    with pytest.raises(InputError, match=r"nan\.onnx: mu is nowhere a finite number"):
        pack(tmp_path / "nan.onnx", tmp_path / "nan.fmu", target=target)
    assert not (tmp_path / "nan.fmu").exists()


def test_a_graph_that_onnx_runtime_refuses_is_not_packed_to_run_in_it(graph: Path, tmp_path: Path) -> None:
    model = onnx.load(graph)
    model.graph.node[-1].op_type = "Nonsense"
    onnx.save(model, tmp_path / "bad.onnx")
    with pytest.raises(InputError, match=r"bad\.onnx: ONNX Runtime cannot run the graph"):
        pack(tmp_path / "bad.onnx", tmp_path / "bad.fmu", target="python")


def test_a_damaged_fmu_is_not_put_into_an_ssp(tmp_path: Path) -> None:
    fmu = pack(ConstantFriction(0.08), tmp_path / "friction.fmu")
    content = bytearray(fmu.read_bytes())
    # The last member's content lies before the table of contents.
    content[content.index(b"PK\x01\x02") - 40] ^= 0xFF
    fmu.write_bytes(bytes(content))
    structure = Structure("one", [SspComponent("friction", "resources/friction.fmu", [], {})], [])
    with pytest.raises(InputError, match=r"friction\.fmu: .*cannot be unpacked"):
        write_ssp(tmp_path / "one.ssp", structure, {"resources/friction.fmu": fmu})
