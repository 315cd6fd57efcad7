"""A friction model as one float64 ONNX file; scaling, effects and the clip at 0 are inside the graph."""

from __future__ import annotations

import os
from pathlib import Path

import onnx

from ..common import atomic_path
from ..expressions.onnx_graph import GraphBuilder, OnnxOps
from ..expressions.ops import LoadColumns
from ..loads import LOAD_NAMES, MU
from .intervals.prediction_interval import MARGIN
from .law import FrictionLaw, System
from .model_card import package_version


def export(model: FrictionLaw, path: str | os.PathLike[str]) -> Path:
    """Write `model` to an ONNX file; the same model always gives the same bytes.

    Inputs: `loads` [n, 5]; with system variables `system` [1, m]; with memory `state` [n, k] and
    `dt` [1] in s. Outputs: `mu` [n, 1]; with memory `state_next` [n, k] and, where all states obey an
    ODE, `state_der` [n, k]. `mu` belongs to the states before the step. A model with a prediction interval
    has one output more, last: `mu_margin` [n, 1]; at the interval's level mu of a new test lies between
    ``max(mu - mu_margin, 0)`` and ``mu + mu_margin``.

    Raises InputError: the model is not fitted.
    """
    content = build_onnx(model).SerializeToString(deterministic=True)
    with atomic_path(path) as temporary:
        temporary.write_bytes(content)
    return Path(path)


def build_onnx(model: FrictionLaw) -> onnx.ModelProto:
    """Return the ONNX graph of a fitted model with its metadata."""
    model.require_fitted()
    graph = GraphBuilder("friction")
    x = OnnxOps(graph)
    states, variables = model.states, model.system_variables
    loads = graph.input("loads", ["n", len(LOAD_NAMES)])
    columns = LoadColumns.from_matrix(x, loads).without(x, model.domain.absent)
    system: System = None
    if variables:
        values = graph.input("system", [1, len(variables)])
        system = {v.name: x.column(values, j) for j, v in enumerate(variables)}
    if states:
        state = graph.input("state", ["n", len(states)])
        dt = graph.input("dt", [1])
        held = [x.column(state, j) for j in range(len(states))]
        mu = x.relu(model.formula(x, columns, held, system))
        following, derivative = model.state_update(x, columns, held, mu, dt)
        graph.output(MU.name, mu, ["n", 1])
        graph.output("state_next", x.concat(following), ["n", len(states)])
        if derivative is not None:
            graph.output("state_der", x.concat(derivative), ["n", len(states)])
    else:
        graph.output(MU.name, x.relu(model.formula(x, columns, None, system)), ["n", 1])
    if model.interval is not None:
        graph.output(MARGIN, model.interval.margin(x, columns, model.domain), ["n", 1])
    return graph.build(model_metadata(model))


def model_metadata(model: FrictionLaw) -> dict[str, object]:
    """Return what is stored in `metadata_props`, by key."""
    metadata: dict[str, object] = {
        "tribofmu.model": {
            "family": model.family,
            "name": model.name,
            "formula": model.formula_text(),
            "version": package_version("tribofmu") or "0",
        },
        "tribofmu.domain": model.domain.to_dict(),
        "tribofmu.card": model.card,
    }
    if model.interval is not None:
        metadata["tribofmu.interval"] = {"level": model.interval.level, "method": model.interval.method()}
    if model.states:
        metadata["tribofmu.state"] = [s.to_dict() for s in model.states]
    if model.system_variables:
        metadata["tribofmu.system"] = [v.to_dict() for v in model.system_variables]
    return metadata
