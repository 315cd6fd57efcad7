"""ONNX graph -> C99: one text `model.h` with the functions of one contact point and of a block of points."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from friction_models.models.intervals.prediction_interval import MARGIN

from ..interface.friction_source import FrictionSource
from ..interface.quantities import FrictionInterface
from . import ops
from .c_functions import WHOLE, chosen, function
from .emission import BLOCK, Writer
from .graph import read_graph
from .tables import Tables, interface_tables
from .tensors import Graph, refuse, rules_of

#: Largest buffers of a block on the stack; of a network that needs more, the points are run one by one.
_STACK_BYTES = 64 * 1024
_POINT = "const double *L, const double *S, const double *P"
_VALUE = f"{_POINT}, double *out"
_SEEDS = "const double *dL, const double *dS, const double *dP"

#: A block of points that is too wide or too long to be computed together.
_LOOP = (
    "double l[5], s[TF_STATES + 1];",
    "for (int i = 0; i < TF_BLOCK; ++i) {",
    "    for (int k = 0; k < 5; ++k) l[k] = L[k * TF_BLOCK + i];",
    "    for (int k = 0; k < TF_STATES; ++k) s[k] = S[k * TF_BLOCK + i];",
    "    if (fused) tf_model_mu_wide(l, s, P, out + i);",
    "    else tf_model_mu_plain(l, s, P, out + i);",
    "}",
)


def generate(source: FrictionSource, interface: FrictionInterface) -> str:
    """Return the C text of a model: constants of the interface, and the formulas.

    The text is complete in itself: the kernels it needs are part of it.
    Raises InputError: the graph holds something that is not translated; the message names it.

    Examples
    --------
    >>> from friction_models import ConstantFriction
    >>> from fmus.source.reading import read_source
    >>> source = read_source(ConstantFriction(mu=0.5))
    >>> "0x1.0000000000000p-1" in generate(source, source.interface(nodes=1))
    True
    """
    with rules_of(source.where):
        return _generate(source, interface)


def _generate(source: FrictionSource, interface: FrictionInterface) -> str:
    where = source.where
    graph = read_graph(source.onnx, where, len(source.states), len(source.system))
    ode = "state_der" in graph.outputs
    dt = graph.inputs.get("dt")
    roles = ("mu", "state_der", MARGIN) if interface.interval is not None else ("mu", "state_der")
    for role in roles:
        if role in graph.outputs and any(dt in s.inputs for s in graph.needed_for(role) if dt is not None):
            raise refuse(where, f"output {role!r} depends on the length of the step 'dt'")
    tables = Tables()
    functions = [
        function("tf_model_mu", _VALUE, Writer(graph, "mu", tables, where)),
        _block("tf_model_mu_block", graph, tables, where),
        _seeded("tf_model_mu_d", graph, "mu", tables, where),
    ]
    if source.states:
        writer = Writer(graph, "state_next", tables, where)
        functions.append(function("tf_model_step", f"{_POINT}, double dt, double *out", writer))
    if ode:
        functions.append(function("tf_model_der", _VALUE, Writer(graph, "state_der", tables, where)))
        functions.append(_seeded("tf_model_der_d", graph, "state_der", tables, where))
    if interface.interval is not None:
        functions.append(function("tf_model_margin", _VALUE, Writer(graph, MARGIN, tables, where)))
        functions.append(_seeded("tf_model_margin_d", graph, MARGIN, tables, where))
    text = "\n".join(functions)
    # Only the kernels that are called; those of the exponential functions also stand behind power and logarithm.
    parts = ["lanes.h"]
    if any(f in text for f in ops.FUNCTIONS.values()):
        parts.append("lanes_math.h")
    if "tf_dense" in text:
        parts.append("lanes_dense.h")
    if "tf_trees" in text:
        parts.append("lanes_trees.h")
    folder = Path(__file__).parent
    return "\n".join(
        [
            "/* Generated from the model's ONNX graph: constants of the interface, kernels, formulas. */",
            f"#define TF_NODES {interface.nodes}",
            *([] if interface.sized else ["#define TF_FIXED_NODES"]),
            f"#define TF_STATES {len(source.states)}",
            f"#define TF_SYSTEM {len(source.system)}",
            f"#define TF_HAS_DOMAIN {int(bool(interface.domain))}",
            f"#define TF_ODE {int(ode)}",
            *(["#define TF_INTERVAL 1"] if interface.interval is not None else []),
            f"#define TF_BLOCK {BLOCK}",
            f"#define TF_BLOCK_LEAST {_least(graph)} /* fewer points are quicker one by one */",
            f"typedef unsigned {_index_type(graph)} tf_index; /* of a node within its tree, of a feature */",
            "",
            *((folder / part).read_text(encoding="utf-8") for part in parts),
            interface_tables(source, interface),
            ops.PRELUDE,
            tables.text(),
            text,
        ]
    )


def _least(graph: Graph) -> int:
    """Return how many points make a block worth while, as measured on models of these kinds."""
    kinds = {s.op for s in graph.needed_for("mu")}
    layers = any(s.op in {"MatMul", "Gemm"} and s.output.size > 1 for s in graph.steps)
    # One point alone has vectors of neurons too, and walks many trees at once; powers are taken one by one.
    return 12 if layers or "TreeEnsemble" in kinds else 8 if "Pow" in kinds else 4


def _index_type(graph: Graph) -> str:
    trees = [s for s in graph.steps if s.op == "TreeEnsemble"]
    largest = max(
        (
            2 * s.attributes.array("nodes_splits").size
            + int(np.max(s.attributes.array("nodes_featureids"), initial=0))
            for s in trees
        ),
        default=0,
    )
    return "short" if largest < 1 << 16 else "int"


def _block(name: str, graph: Graph, tables: Tables, where: str) -> str:
    writer = Writer(graph, "mu", tables, where, lanes=True)
    if 8 * writer.buffers.total() <= _STACK_BYTES and len(writer.lines) <= WHOLE:
        return function(name, _VALUE, writer)
    return chosen(name, _VALUE, _LOOP)


def _seeded(name: str, graph: Graph, role: str, tables: Tables, where: str) -> str:
    """Return a function with forward derivatives."""
    writer = Writer(graph, role, tables, where, seeded=True)
    return function(name, f"{_POINT}, {_SEEDS}, double *out, double *dout", writer)
