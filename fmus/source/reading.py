"""Reads the model to be packed: a model object, a saved folder, or an ONNX file, ours or a user's own."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from friction_models.common import InputError, check_readable
from friction_models.common.files import read_json
from friction_models.models.folder_members import CARD, ONNX, check_members

from ..interface.friction_source import MAX_ONNX_BYTES, FrictionSource, parse_source


def read_source(
    model: object, spec: str | os.PathLike[str] | None = None, target: str = "native"
) -> FrictionSource:
    """Take a model object, a card (``card:NAME``), a saved folder or an ONNX file, ours or a user's own.

    A `FrictionSource` is returned as it is. `spec` is the YAML for a user's own ONNX file (`fmus.user_onnx.spec.Spec`). For
    the target ``python`` a user's graph that has no translation is taken as it is (`FrictionSource.foreign`).
    Raises InputError: no such file or folder, not an ONNX file, metadata or a YAML that cannot be used, a graph that has no
    translation.

    Examples
    --------
    >>> from friction_models import ConstantFriction
    >>> source = read_source(ConstantFriction(mu=0.1))
    >>> source.family, source.states, source.synthetic
    ('constant', (), False)
    >>> read_source("no-such-model.onnx")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: no-such-model.onnx: no such file or folder; allowed: a saved model folder or an ONNX file
    """
    if isinstance(model, FrictionSource):
        if model.foreign is not None and target != "python":
            raise InputError(
                f"{model.where}: the graph runs in Python only; allowed: target 'python', not {target!r}"
            )
        return model
    if isinstance(model, str) and model.startswith("card:"):
        from friction_models.cards import load_card

        model = load_card(model).model()
    if isinstance(model, str | os.PathLike):
        path = Path(model)
        home: Path | None = None
        if path.is_dir():
            if not (path / ONNX).is_file():
                raise InputError(
                    f"{path}: no model.onnx in this folder; allowed: a folder written by save(), or an ONNX file"
                )
            home, path = path, path / ONNX
        if not path.is_file():
            raise InputError(f"{path}: no such file or folder; allowed: a saved model folder or an ONNX file")
        check_readable(path, MAX_ONNX_BYTES)
        from ..user_onnx.external import self_contained

        content = self_contained(path.read_bytes(), path, MAX_ONNX_BYTES)
        source = _file_source(content, str(path), spec, target)
        if home is not None and (home / CARD).is_file():
            _check_card(source, home)
        return source
    if spec is not None:
        raise InputError(f"{spec}: a YAML is for a user's own ONNX file; allowed: with an ONNX file only")
    export = getattr(model, "to_onnx", None)
    if export is None:
        raise InputError(
            f"model is a {type(model).__name__}; allowed: a friction model, a folder it was saved to, or an ONNX file"
        )
    with tempfile.TemporaryDirectory(prefix="tribofmu-") as folder:
        written = Path(folder) / ONNX
        export(written)
        return parse_source(written.read_bytes(), type(model).__name__)


def _check_card(source: FrictionSource, folder: Path) -> None:
    """Raise InputError: the graph in a model folder is that of another model than the one that commands predict with."""
    card = read_json(folder / CARD)
    check_members(folder, card)
    for key in ("family", "formula", "domain", "data"):
        if key in source.card and key in card and source.card[key] != card[key]:
            raise InputError(
                f"{folder}: model.onnx and card.json are of two models ({key} differs); allowed: a folder as save() writes it"
            )


def _file_source(
    content: bytes, where: str, spec: str | os.PathLike[str] | None, target: str
) -> FrictionSource:
    from ..user_onnx import is_ours, looks_ours, read_user_model
    from ..user_onnx.reading import parse

    model = parse(content, where)
    if is_ours(model):
        if spec is not None:
            raise InputError(
                f"{spec}: {where} is one of our own models and holds names, units and domain itself; "
                "allowed: a YAML with a user's own ONNX file"
            )
        return parse_source(content, where)
    if spec is not None or not looks_ours(model):
        return read_user_model(content, where, spec, python=target == "python")
    # Without metadata but with our signature: as it is where the generator reads it, else redrawn.
    from ..native.graph import read_graph
    from ..native.tensors import rules_of

    source = parse_source(content, where)
    try:
        with rules_of(where):
            read_graph(content, where, len(source.states), len(source.system))
    except InputError as error:
        try:
            return read_user_model(content, where, spec, python=target == "python")
        except InputError:
            raise error from None
    return source
