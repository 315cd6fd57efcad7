"""A friction model with physical effects added to it, each at a strength that is a parameter and starts at zero.

One FMU serves all sensitivities: its parameters ``strength_NAME`` add ``strength * basis`` of an effect to the
friction coefficient of the user's model, ``mu_factor`` scales it.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import onnx
from onnx import TensorProto, helper
from onnx.compose import add_prefix

import fmus
from fmus.archive.content import read_member, read_members
from fmus.user_onnx import looks_ours
from fmus.user_onnx.reading import parse
from friction_models.common import InputError, atomic_path
from friction_models.effects.base import Effect, EffectContext
from friction_models.expressions.onnx_graph import GraphBuilder, OnnxOps
from friction_models.expressions.ops import LoadColumns, Value
from friction_models.loads import LOAD_NAMES

from .causes import FACTOR, Cause

#: Where our friction FMUs keep their graph.
GRAPH = "resources/model.onnx"
#: Share of an effect's typical amplitude that a sensitivity uses.
SMALL = 0.5
_MAX_GRAPH = 256 * 1024**2


def strengths(effects: Sequence[Effect]) -> list[Cause]:
    """Return the causes that added effects are, one for each amplitude of each effect.

    Examples
    --------
    >>> from friction_models.effects import CATALOGUE
    >>> [(s.parameter, s.name, s.unit) for s in strengths([CATALOGUE["viscous"]])]
    [('strength_viscous_k_v', 'viscous', '1')]
    """
    return [
        Cause(
            effect.name,
            effect.title,
            "friction",
            amplitude.unit,
            SMALL * amplitude.start,
            amplitude.sign,
            amplitude.name if len(effect.amplitudes) > 1 else "",
            f"strength_{effect.name}_{amplitude.name}",
        )
        for effect in effects
        for amplitude in effect.amplitudes
    ]


def graph_of(fmu: Path) -> bytes:
    """Return the ONNX graph inside a friction FMU of this project.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> import onnx
    >>> from fmus import pack
    >>> from friction_models import ConstantFriction
    >>> with TemporaryDirectory() as place:
    ...     graph = graph_of(pack(ConstantFriction(mu=0.1), Path(place) / "law.fmu", target="python"))
    >>> [output.name for output in onnx.load_model_from_string(graph).graph.output]
    ['mu']
    """
    if GRAPH not in read_members(fmu):
        raise InputError(
            f"{fmu}: holds no {GRAPH}, so no effect can be added to it; allowed: a friction FMU that `pack` wrote"
        )
    return read_member(fmu, GRAPH, _MAX_GRAPH)


def pack_with_effects(
    fmu: Path, effects: Sequence[Effect], target: Path, nodes: int, fmi: str = "2.0"
) -> Path:
    """Write a friction FMU again, with effects added at strength 0; a graph that does not become C runs in Python.

    `effects` are physical ones without metadata, `nodes` the contact points, `fmi` the version of the interface of
    the user's FMU, so that start values of the system fit both.
    """
    model = with_effects(graph_of(fmu), effects, str(fmu))
    file = target.with_suffix(".onnx")
    with atomic_path(file) as temporary:
        temporary.write_bytes(model.SerializeToString(deterministic=True))
    try:
        return fmus.pack(file, target, nodes=nodes, fmi=fmi, arrays=fmi == "3.0")
    except InputError:
        return fmus.pack(file, target, nodes=nodes, fmi=fmi, target="python")


def addable(content: bytes, effects: Sequence[Effect], where: str) -> list[Effect]:
    """Return the effects that can be added: without metadata, and not remembering what the model remembers already."""
    held = _read(content, where)[1]
    taken = {str(s["name"]) for s in held.get("tribofmu.state", [])}
    return [
        e for e in effects if e.kind == "physics" and not e.metadata and not taken & {n for n, _ in e.states}
    ]


def _read(content: bytes, where: str) -> tuple[onnx.ModelProto, dict[str, list[Any]]]:
    """Return a checked graph with our signature, and its metadata."""
    model = parse(content, where)
    if not looks_ours(model):
        raise InputError(
            f"{where}: its graph does not take the five loads; allowed: a friction FMU that `pack` wrote"
        )
    try:
        held = {p.key: json.loads(p.value) for p in model.metadata_props if p.key.startswith("tribofmu.")}
    except (ValueError, RecursionError):
        raise InputError(f"{where}: metadata of the graph is not JSON; allowed: JSON") from None
    return model, held


def with_effects(content: bytes, effects: Sequence[Effect], where: str) -> onnx.ModelProto:
    """Return the graph of a friction model with `effects` added at strengths that are system variables."""
    user, held = _read(content, where)
    states, system = held.get("tribofmu.state", []), held.get("tribofmu.system", [])
    known = strengths(effects)
    own_states = [s for e in effects for s in e.state_variables(e.start_shape())]
    probe = _probe_graph(effects, known, len(own_states))
    parts = [add_prefix(user, "u/"), add_prefix(probe, "p/")]
    ode = not states or any(o.name == "state_der" for o in user.graph.output)
    nodes: list[Any] = []
    constants: list[Any] = []

    def gather(source: str, columns: range, name: str) -> None:
        index = helper.make_tensor(f"{name}#", TensorProto.INT64, [len(columns)], list(columns))
        constants.append(index)
        nodes.append(helper.make_node("Gather", [source, index.name], [name], axis=1))

    for prefix, count, width, offset, width_system in (
        ("u/", len(states), 0, 0, len(system)),
        ("p/", len(own_states), len(states), len(system), len(known) + 1),
    ):
        nodes.append(helper.make_node("Identity", ["loads"], [f"{prefix}loads"]))
        if count:
            gather("state", range(width, width + count), f"{prefix}state")
            nodes.append(helper.make_node("Identity", ["dt"], [f"{prefix}dt"]))
        if width_system:
            gather("system", range(offset, offset + width_system), f"{prefix}system")
    nodes += parts[0].graph.node
    nodes.append(helper.make_node("Identity", ["u/mu"], ["p/mu_in"]))
    nodes += parts[1].graph.node
    nodes.append(helper.make_node("Relu", ["p/mu"], ["mu"]))
    inputs: list[tuple[str, list[int | str | None]]] = [("loads", ["n", len(LOAD_NAMES)])]
    outputs: list[tuple[str, list[int | str | None]]] = [("mu", ["n", 1])]
    total = len(states) + len(own_states)
    inputs.append(("system", [1, len(system) + len(known) + 1]))
    if total:
        inputs += [("state", ["n", total]), ("dt", [1])]
        names = ["state_next", *(["state_der"] if ode else [])]
        for name in names:
            sources = [f"{p}{name}" for p, k in (("u/", len(states)), ("p/", len(own_states))) if k]
            nodes.append(helper.make_node("Concat", sources, [name], axis=1))
            outputs.append((name, ["n", total]))
    graph = helper.make_graph(
        nodes,
        "friction",
        [helper.make_tensor_value_info(n, TensorProto.DOUBLE, s) for n, s in inputs],
        [helper.make_tensor_value_info(n, TensorProto.DOUBLE, s) for n, s in outputs],
        [*constants, *parts[0].graph.initializer, *parts[1].graph.initializer],
    )
    opsets = {o.domain: o.version for part in parts for o in part.opset_import}
    merged = helper.make_model(
        graph,
        opset_imports=[helper.make_opsetid(d, v) for d, v in sorted(opsets.items())],
        producer_name="tribofmu",
        ir_version=user.ir_version,
    )
    extra = [{"name": s.parameter, "unit": s.unit, "start": 0.0, "min": -1e6, "max": 1e6} for s in known]
    extra.append({"name": FACTOR, "unit": "1", "start": 1.0, "min": 0.0, "max": 1e3})
    held["tribofmu.system"] = [*system, *extra]
    if total:
        held["tribofmu.state"] = [*states, *(s.to_dict() for s in own_states)]
    for key, value in sorted(held.items()):
        entry = merged.metadata_props.add()
        entry.key, entry.value = key, json.dumps(value)
    onnx.checker.check_model(merged, full_check=True)
    return merged


def _probe_graph(effects: Sequence[Effect], known: Sequence[Cause], states: int) -> onnx.ModelProto:
    """Return the graph of ``mu_factor * mu_in + sum of strength * basis``."""
    graph = GraphBuilder("probe")
    x = OnnxOps(graph)
    loads = graph.input("loads", ["n", len(LOAD_NAMES)])
    mu_in = graph.input("mu_in", ["n", 1])
    system = graph.input("system", [1, len(known) + 1])
    L = LoadColumns.from_matrix(x, loads)
    held: dict[str, Value] = {}
    if states:
        state, dt = graph.input("state", ["n", states]), graph.input("dt", [1])
        names = [n for e in effects for n, _ in e.states]
        held = {n: x.column(state, j) for j, n in enumerate(names)}
    mu = mu_in * x.column(system, len(known))
    column = 0
    following: list[Any] = []
    rates: list[Any] = []
    for effect in effects:
        shape = effect.start_shape()
        memory = EffectContext(mu_in, held, {})
        for basis in effect.basis(x, L, shape, memory):
            mu = mu + x.column(system, column) * basis
            column += 1
        if effect.states:
            following += effect.advance(x, L, shape, memory, dt)
            rates += effect.rate(x, L, shape, memory)
    graph.output("mu", mu, ["n", 1])
    if states:
        graph.output("state_next", x.concat(following), ["n", states])
        graph.output("state_der", x.concat(rates), ["n", states])
    return graph.build()
