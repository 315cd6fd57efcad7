"""Turns a user's own ONNX file into a friction model to pack: translated, then compared with the original."""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from friction_models.loads import LOAD_NAMES, LOADS

from ..interface.friction_source import FrictionSource
from .attempt import try_original
from .lowering import lower
from .operators.nodes import NotTranslated
from .parity import Agreement, compare, sample
from .reading import parse, pruned, read_graph
from .signature import Signature, choose_output, domain_of, read_signature
from .spec import Spec

if TYPE_CHECKING:
    import onnx

__all__ = ["NotTranslated", "Spec", "UserModel", "is_ours", "looks_ours", "read_user_model"]


@dataclass(frozen=True)
class UserModel(FrictionSource):
    """A foreign file, understood.

    Attributes
    ----------
    agreement : Agreement or None
        How our graph and the original compare; None where it has no translation and runs in Python only.
    """

    agreement: Agreement | None = None


def is_ours(model: onnx.ModelProto) -> bool:
    """Return whether a file is one of our own models: it says so in its metadata.

    Examples
    --------
    >>> import onnx
    >>> from friction_models import ConstantFriction
    >>> from fmus.source.reading import read_source
    >>> is_ours(onnx.load_model_from_string(read_source(ConstantFriction(mu=0.1)).onnx))
    True
    """
    return any(p.key.startswith("tribofmu.") for p in model.metadata_props)


def looks_ours(model: onnx.ModelProto) -> bool:
    """Return whether a file has the signature of our own models: `loads` double [n, 5] to `mu`.

    Examples
    --------
    >>> import onnx
    >>> from friction_models import ConstantFriction
    >>> from fmus.source.reading import read_source
    >>> looks_ours(onnx.load_model_from_string(read_source(ConstantFriction(mu=0.1)).onnx))
    True
    """
    from onnx import TensorProto

    stored = {t.name for t in model.graph.initializer}
    inputs = {i.name: i.type.tensor_type for i in model.graph.input if i.name not in stored}
    if "loads" not in inputs or "mu" not in {o.name for o in model.graph.output}:
        return False
    dims = inputs["loads"].shape.dim
    return (
        set(inputs) <= {"loads", "state", "dt", "system"}
        and inputs["loads"].elem_type == TensorProto.DOUBLE
        and len(dims) == 2
        and dims[1].dim_value == len(LOAD_NAMES)
        and not dims[0].HasField("dim_value")
    )


def read_user_model(
    content: bytes, where: str, spec: str | os.PathLike[str] | Spec | None = None, python: bool = False
) -> UserModel:
    """Translate a foreign ONNX file and compare the result with it.

    Parameters
    ----------
    content : bytes
        The file.
    where : str
        Its name, for messages and as the model's name.
    spec : path-like or Spec, optional
        YAML with names, units, ranges and places of the loads.
    python : bool
        Whether a graph without a translation is taken as it is, to run in Python.

    Raises
    ------
    NotTranslated
        An operator without translation, unless `python`.
    InputError
        A damaged or hostile file, inputs or outputs that do not fit, a YAML that does not fit.

    Examples
    --------
    A graph that takes the five loads and gives mu = 0.001 T:

    >>> from onnx import TensorProto, helper
    >>> loads = helper.make_tensor_value_info("x", TensorProto.DOUBLE, [None, 5])
    >>> mu = helper.make_tensor_value_info("mu", TensorProto.DOUBLE, [None, 1])
    >>> weights = helper.make_tensor("w", TensorProto.DOUBLE, [5, 1], [0.0, 0.001, 0.0, 0.0, 0.0])
    >>> graph = helper.make_graph([helper.make_node("MatMul", ["x", "w"], ["mu"])], "law", [loads], [mu], [weights])
    >>> model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    >>> user = read_user_model(model.SerializeToString(), "law.onnx")
    >>> user.family, user.card["output of the original"], user.agreement.difference < 1e-12
    ('onnx', "'mu', mu = 1 * value + 0", True)
    """
    given = Spec() if spec is None else spec if isinstance(spec, Spec) else Spec.load(spec)
    place = where if spec is None or isinstance(spec, Spec) else f"{where} with {spec}"
    model = parse(content, where)
    output = choose_output([o.name for o in model.graph.output], given, place)
    graph = read_graph(model, output, where)
    signature = read_signature(graph.inputs, output, given, place)
    domain = domain_of(given, place)
    name = given.name or Path(where).stem or "friction"
    card = _card(content, name, given, signature)
    try:
        ours = lower(graph, signature)
        agreement = compare(ours, pruned(model, graph, output), signature, domain, where)
    except NotTranslated as error:
        if not python:
            raise
        try_original(content, signature, sample(domain)[::16], where)
        reason = str(error).removeprefix(f"{where}: ").partition("; pack it")[0].partition(", allowed")[0]
        card["runs"] = f"the original file in ONNX Runtime ({reason})"
        found = UserModel(b"", where, foreign=signature.to_dict())
    else:
        card["runs"] = (
            f"the graph in float64, compared with the original in ONNX Runtime at {agreement.points} random points"
        )
        metadata: dict[str, object] = {
            "tribofmu.model": {"family": given.family, "name": name, "formula": given.formula},
            "tribofmu.card": card,
        }
        if domain:
            metadata["tribofmu.domain"] = {k: list(v) for k, v in domain.items()}
        found = UserModel(_with_metadata(ours, metadata), where, note=str(agreement), agreement=agreement)
    return replace(
        found,
        family=given.family,
        name=name,
        formula=given.formula,
        domain=domain,
        card=card,
        original=content,
    )


def _with_metadata(content: bytes, metadata: dict[str, object]) -> bytes:
    import onnx

    model = onnx.load_model_from_string(content)
    for key, value in sorted(metadata.items()):
        model.metadata_props.add(key=key, value=json.dumps(value, allow_nan=False))
    return bytes(model.SerializeToString(deterministic=True))


def _card(content: bytes, name: str, spec: Spec, signature: Signature) -> dict[str, object]:
    entries: dict[str, object] = {"name": name, "family": spec.family}
    texts = {key: getattr(spec, key) for key in ("formula", "description", "author", "license")}
    entries |= {k: v for k, v in texts.items() if v}
    seen = {}
    for feed in signature.feeds:
        for j, k in enumerate(feed.loads):
            load = LOADS[k]
            seen[load.name] = (
                f"column {j} of {feed.name!r}: {feed.factor[j]:.12g} * {load.name} [{load.unit}] + {feed.offset[j]:.12g}"
            )
    entries["inputs of the original"] = {n: seen.get(n, "not used") for n in LOAD_NAMES}
    entries["output of the original"] = (
        f"{signature.output!r}, mu = {signature.multiply:g} * value + {signature.add:g}"
    )
    entries["SHA-256 of the original"] = hashlib.sha256(content).hexdigest()
    return entries
