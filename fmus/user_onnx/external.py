"""Brings weights that stand beside an ONNX file, as PyTorch writes them, into the file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from friction_models.common import InputError, check_readable

if TYPE_CHECKING:
    import onnx


def self_contained(content: bytes, path: Path, limit: int) -> bytes:
    """Return the file with the weights that stand in ``NAME.data`` beside it inside.

    Only an ordinary file in the same folder whose name begins with that of the ONNX file is read, and no
    more than `limit` bytes: what the ONNX file says about the place is not trusted. A file without such
    weights, or one that cannot be parsed, is returned as it is.
    Raises InputError: weights elsewhere, a missing or too large file, a part outside of it.
    """
    import onnx

    if b"location" not in content:
        return content
    try:
        model = onnx.load_model_from_string(content)
    except Exception:  # the reader behind says what is wrong
        return content
    outside = [t for t in model.graph.initializer if t.data_location == onnx.TensorProto.EXTERNAL]
    if not outside:
        return content
    files: dict[str, bytes] = {}
    left = limit - len(content)
    for tensor in outside:
        entries = {e.key: e.value for e in tensor.external_data}
        name = entries.get("location", "")
        if name not in files:
            files[name] = _read(name, path, left)
            left -= len(files[name])
        tensor.raw_data = _part(files[name], entries, tensor, path)
        del tensor.external_data[:]
        tensor.data_location = onnx.TensorProto.DEFAULT
        left -= len(tensor.raw_data)
        if left < 0:
            raise InputError(
                f"{path}: more than {limit} bytes with the weights beside it, allowed: at most that"
            )
    return bytes(model.SerializeToString())


def _read(name: str, path: Path, limit: int) -> bytes:
    plain = name and Path(name).name == name and "\\" not in name and name.startswith(path.stem)
    beside = path.parent / name if plain else path
    if not plain or name == path.name:
        raise InputError(
            f"{path}: weights are stored in {name!r:.80}; allowed: in the file itself (torch.onnx.export(..., "
            f"external_data=False)) or beside it in {path.name}.data"
        )
    if beside.is_symlink() or not beside.is_file():
        raise InputError(
            f"{path}: the file {name!r:.80} with its weights is not beside it; allowed: both together"
        )
    check_readable(beside, limit)
    return beside.read_bytes()


def _part(data: bytes, entries: dict[str, str], tensor: onnx.TensorProto, path: Path) -> bytes:
    try:
        offset = int(entries.get("offset", "0"))
        length = int(entries.get("length", str(len(data) - offset)))
    except ValueError:
        offset = length = -1
    if offset < 0 or length < 0 or offset + length > len(data):
        raise InputError(
            f"{path}: tensor {tensor.name!r:.60} is said to be {length} bytes from {offset} on of a file of {len(data)}; "
            "allowed: a part of the file"
        )
    return data[offset : offset + length]
