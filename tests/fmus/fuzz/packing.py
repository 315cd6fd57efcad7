"""FMUs for the fuzzers: the small models packed with or without their binaries."""

from __future__ import annotations

from pathlib import Path
from unittest import mock

from fmus import pack

from .models import MODELS


def packed(kind: str, nodes: int, fmi: str, folder: Path, binaries: bool = False) -> Path:
    """Pack a small model into `folder`; without binaries where only the sources are wanted, which is quicker."""
    model = MODELS[kind]()
    source: object = model
    if isinstance(model, bytes):
        source = folder / f"{kind}.onnx"
        (folder / f"{kind}.onnx").write_bytes(model)
    path = folder / f"{kind}-{nodes}-{fmi}.fmu"
    if binaries:
        return pack(source, path, nodes=nodes, fmi=fmi)
    with mock.patch("fmus.native.compile.build", return_value={}):
        return pack(source, path, nodes=nodes, fmi=fmi)
