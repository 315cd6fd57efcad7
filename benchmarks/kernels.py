"""Generated C and ONNX Runtime's C library on the same points in one program: nanoseconds a point."""

from __future__ import annotations

import statistics
import subprocess
import tempfile
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import onnx
import onnxruntime

from fmus.interface.friction_source import parse_source
from fmus.native import compile as compiling
from fmus.native.generate import generate
from friction_models.families.registry import make_model
from friction_models.models.onnx_export import build_onnx
from tests.fmus.compiled import compiler
from tests.fmus.graphs import BOX, Array, campaign, graph_bytes, node

from .common import Section, Table, section

ROUNDS = 60
KINDS = ("baseline", "avx2", "runtime", "runtime32")


def network(widths: Sequence[int], activation: str) -> bytes:
    """Return a dense network on standardised loads with random weights."""
    rng = np.random.default_rng(1)
    low, high = np.array(list(BOX.values())).T
    constants: dict[str, Array] = {"m": (low + high)[None, :] / 2.0, "s": 4.0 / (high - low)[None, :]}
    nodes = [node("Sub", "loads m", "d"), node("Mul", "d s", "a0")]
    size = 5
    for k, width in enumerate(widths):
        constants[f"w{k}"] = rng.normal(size=(size, width)) / np.sqrt(size)
        constants[f"b{k}"] = rng.normal(scale=0.1, size=width)
        nodes += [
            node("Gemm", f"a{k} w{k} b{k}", f"h{k}"),
            node(activation, f"h{k}", f"a{k + 1}"),
        ]
        size = width
    constants |= {"w": rng.normal(size=(size, 1)) / size, "b": np.array([0.2])}
    nodes += [node("Gemm", f"a{len(widths)} w b", "y"), node("Relu", "y", "mu")]
    return graph_bytes(nodes, constants)


def models() -> dict[str, bytes]:
    """Return the measured models as ONNX files."""
    points, _ = campaign()
    boosting = make_model("gradient_boosting", trees=100).fit_frame(points)
    return {
        "network 32 x 32, tanh": network([32, 32], "Tanh"),
        "network 64 x 64 x 64, relu": network([64, 64, 64], "Relu"),
        "gradient boosting, 100 trees": build_onnx(boosting).SerializeToString(),
    }


def in_single_precision(content: bytes) -> bytes:
    """Return an ONNX file with all its numbers of double precision in single precision."""
    model = onnx.load_from_string(content)
    double, single = onnx.TensorProto.DOUBLE, onnx.TensorProto.FLOAT

    def rounded(tensor: onnx.TensorProto) -> None:
        if tensor.data_type == double:
            values = onnx.numpy_helper.to_array(tensor).astype(np.float32)
            tensor.CopyFrom(onnx.numpy_helper.from_array(values, tensor.name))

    for tensor in model.graph.initializer:
        rounded(tensor)
    for value in (*model.graph.input, *model.graph.output, *model.graph.value_info):
        if value.type.tensor_type.elem_type == double:
            value.type.tensor_type.elem_type = single
    for step in model.graph.node:
        for attribute in step.attribute:
            if attribute.type == onnx.AttributeProto.TENSOR:
                rounded(attribute.t)
            elif step.op_type == "Cast" and attribute.i == double:
                attribute.i = single
    return model.SerializeToString()


def timings(content: bytes, rounds: int = ROUNDS) -> dict[tuple[str, int], list[float]]:
    """Return nanoseconds a point of every round by kind and batch.

    Raises
    ------
    RuntimeError
        No compiler, or the program fails.
    """
    command = compiler()
    library = next((Path(onnxruntime.__file__).parent / "capi").glob("libonnxruntime.so*"), None)
    if command is None or library is None:
        raise RuntimeError("this benchmark needs a C compiler and ONNX Runtime's shared library")
    source = parse_source(content, "benchmark")
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "model.h").write_text(generate(source, source.interface(1)), encoding="utf-8")
        (folder / "model.onnx").write_bytes(content)
        (folder / "single.onnx").write_bytes(in_single_precision(content))
        program = str(Path(__file__).with_suffix(".c"))
        flags = [*compiling._FLAGS, "-I", str(folder), "-o", str(folder / "run")]
        build = [*command, *flags, program, "-lm", "-ldl"]
        files = [str(folder / name) for name in ("model.onnx", "single.onnx")]
        run = [str(folder / "run"), str(library), *files, str(rounds)]
        for step in (build, run):
            done = subprocess.run(step, capture_output=True, text=True, check=False)
            if done.returncode:
                raise RuntimeError(f"{step[0]} failed: {done.stderr[-2000:]}")
    found: dict[tuple[str, int], list[float]] = defaultdict(list)
    for line in done.stdout.splitlines():
        kind, batch, number = line.split()
        found[kind, int(batch)].append(float(number))
    return found


def measure(folder: Path) -> Section:
    """Time the kernels of both builds and ONNX Runtime at batches of 1, 64 and 1024 points."""
    table = Table(
        [
            "model",
            "batch",
            "baseline [ns a point]",
            "AVX2 + FMA [ns a point]",
            "ONNX Runtime, C [ns a point]",
            "ONNX Runtime in float32, C [ns a point]",
            "ONNX Runtime / chosen kernel",
            "ONNX Runtime in float32 / chosen kernel",
            "largest difference of mu",
            "in float32",
        ]
    )
    for name, content in models().items():
        found = timings(content)
        for batch in (1, 64, 1024):
            middle = {k: statistics.median(found[k, batch]) for k in KINDS if found[k, batch]}
            chosen = middle.get("avx2", middle["baseline"])
            table.rows.append(
                (
                    name,
                    batch,
                    *(f"{middle[k]:.0f}" if k in middle else "-" for k in KINDS),
                    *(f"{middle[k] / chosen:.1f}" for k in ("runtime", "runtime32")),
                    *(f"{found[k, batch][0]:.1e}" for k in ("difference", "difference32")),
                )
            )
    return section(
        "Generated C and ONNX Runtime's C library",
        "All in one C program, one thread, preallocated tensors, the same points; double precision but for the columns in float32, "
        "where ONNX Runtime gets the same model with all numbers rounded to single precision, and the loads, too: FMI exchanges double "
        "precision, so an FMU cannot choose that without losing digits. "
        f"Median of {ROUNDS} rounds in turns. The kernels are the two builds of the generated `model.h`; an FMU "
        "takes the one that fits the processor. Batches go point by point into blocks and back, as in an FMU. mu is compared with "
        "that of ONNX Runtime in double precision. A ratio below 1 means that ONNX Runtime is quicker. "
        f"ONNX {onnx.__version__}, ONNX Runtime {onnxruntime.__version__}.",
        table,
    )
