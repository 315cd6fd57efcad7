"""Models read back from the folders that `FrictionModel.save` writes; nothing in them is executed."""

from __future__ import annotations

import json
import os
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..common import InputError, check_readable, given_path, shown
from ..common.files import DAMAGED
from ..common.json_values import JsonObject
from ..expressions.parameters import first_line
from ..models.base import FrictionModel
from ..models.folder_members import ARRAYS, CARD, ONNX, TEXT, check_members
from .composed import ComposedFriction
from .registry import model_class

#: Limits against files that are not models; real ones stay far below.
MAX_CARD_BYTES = 16 * 1024**2
MAX_ARRAY_BYTES = 256 * 1024**2
MAX_ARRAYS = 1000

_SAVED = f"a saved model, which holds {CARD}, {TEXT}, {ARRAYS} and {ONNX}"


def load_model(folder: str | os.PathLike[str]) -> FrictionModel:
    """Read a model saved by `FrictionModel.save`.

    Raises
    ------
    InputError
        A file is missing, too large, not what it should be or of another model, or its content does not make a model.

    Examples
    --------
    >>> import tempfile
    >>> from friction_models import ConstantFriction, load_model
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     ConstantFriction(0.08).save(Path(folder) / "model").name
    ...     model = load_model(Path(folder) / "model")
    'model'
    >>> model.value
    0.08
    """
    source = given_path(folder, "a saved model")
    if not source.is_dir():
        raise InputError(f"{source}: no such folder; allowed: a folder written by save()")
    if not (source / CARD).exists():
        raise InputError(f"{source}: no {CARD} in this folder; allowed: {_SAVED}")
    card = read_card(source / CARD)
    content: JsonObject = card["model"]
    arrays = read_arrays(source / ARRAYS)
    try:
        family = str(content["family"])
        kind = ComposedFriction if family == ComposedFriction.family else model_class(family)
        model = kind.from_parts(content, arrays)
        model.check_alone()
    except InputError as error:
        raise InputError(f"{source}: {error}") from None
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, OverflowError) as error:
        raise InputError(
            f"{source / CARD}: does not describe a model ({type(error).__name__}: {first_line(error)})"
        ) from None
    check_members(source, card)
    return model


def read_card(file: Path) -> JsonObject:
    """Return what `card.json` holds; its part `model` makes the model."""
    check_readable(file, MAX_CARD_BYTES, _SAVED)
    try:
        card = json.loads(file.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{file}: not JSON ({first_line(error)})") from None
    if not isinstance(card, dict) or card.get("format") != "tribofmu-model":
        raise InputError(f"{file}: not the card of a friction model; allowed: a file written by save()")
    if card.get("format_version") != 1:
        raise InputError(f"{file}: format_version {card.get('format_version')!r:.40}, allowed: 1")
    if not isinstance(card.get("model"), dict):
        found = f"has the value {shown(json.dumps(card['model']), 40)}" if "model" in card else "is missing"
        raise InputError(f"{file}: key 'model' {found}; allowed: a file written by save()")
    return card


def read_arrays(file: Path) -> dict[str, npt.NDArray[Any]]:
    """Return the arrays of an `.npz` file of plain numbers; sizes are checked before anything is unpacked."""
    check_readable(file, MAX_ARRAY_BYTES, _SAVED)
    try:
        with zipfile.ZipFile(file) as archive:
            members = archive.infolist()
            if len(members) > MAX_ARRAYS or sum(m.file_size for m in members) > MAX_ARRAY_BYTES:
                raise InputError(
                    f"{file}: {len(members)} arrays of {sum(m.file_size for m in members)} bytes; allowed: "
                    f"{MAX_ARRAYS} arrays and {MAX_ARRAY_BYTES} bytes"
                )
            return {m.filename.removesuffix(".npy"): _read_array(archive, m) for m in members}
    except InputError:
        raise
    except DAMAGED as error:
        raise InputError(f"{file}: not an archive of arrays ({first_line(error)})") from None


def _read_array(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> npt.NDArray[Any]:
    """Read one `.npy` member; a header that promises more than the member holds is refused."""
    with archive.open(member) as stream:
        version = np.lib.format.read_magic(stream)
        reader = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
        if version not in reader:
            raise ValueError(f"array {member.filename!r} has format {version}")
        shape, _, dtype = reader[version](stream)
        if dtype.kind not in "fiu":
            raise ValueError(f"array {member.filename!r} holds {dtype}; allowed: numbers")
        if any(n < 0 for n in shape) or int(np.prod(shape, dtype=object)) * dtype.itemsize > member.file_size:
            raise ValueError(f"array {member.filename!r} of shape {shape} is larger than its file")
    with archive.open(member) as stream:
        return np.lib.format.read_array(stream, allow_pickle=False)
