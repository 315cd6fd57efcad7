"""ONNX graph -> C99: `model.h` with the functions that the FMI wrapper calls for one contact point."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from friction_models.loads import LOADS

from ..interface import FrictionInterface
from ..source import FrictionSource
from . import ops
from .graph import Array, Graph, Step, Tensor, read_graph, refuse

#: C names of the graph's inputs, and of their derivatives' seeds.
_INPUTS = {"loads": "L", "state": "S", "system": "P"}

#: Columns of a matrix product that are summed at a time: 16 doubles fill half the vector registers of x86-64.
_BLOCK = 16

_UNUSED = """\
#if defined(__GNUC__)
#define TF_UNUSED __attribute__((unused)) /* a program need not use everything */
#else
#define TF_UNUSED
#endif
"""

_MU_BLOCK = """\
TF_UNUSED static void tf_model_mu_block(const double *L, const double *S, const double *P, double *out) {
    for (int i = 0; i < TF_BLOCK; ++i) {
        double l[5], s[TF_STATES + 1];
        for (int k = 0; k < 5; ++k) l[k] = L[k * TF_BLOCK + i];
        for (int k = 0; k < TF_STATES; ++k) s[k] = S[k * TF_BLOCK + i];
        tf_model_mu(l, s, P, out + i);
    }
    (void)S;
}
"""

_PRELUDE = """\
TF_UNUSED static double tf_max(double a, double b) { return (a != a || a > b) ? a : b; }
TF_UNUSED static double tf_min(double a, double b) { return (a != a || a < b) ? a : b; }
TF_UNUSED static double tf_pow(double a, double b) { return b == 2.0 ? a * a : b == 1.0 ? a : pow(a, b); }
TF_UNUSED static double tf_pow_da(double a, double b) {
    return a == 0.0 ? (b == 1.0 ? 1.0 : 0.0) : b * tf_pow(a, b - 1.0);
}
TF_UNUSED static double tf_pow_db(double a, double y) { return a > 0.0 ? y * log(a) : 0.0; }
"""


def literal(value: float) -> str:
    """Return a C constant that is exactly `value` (hexadecimal)."""
    if np.isnan(value):
        return "NAN"
    if np.isinf(value):
        return "INFINITY" if value > 0 else "(-INFINITY)"
    text = float(value).hex()
    return f"({text})" if text.startswith("-") else text


def table(name: str, values: Sequence[float] | Array, kind: str = "double") -> str:
    """Return the definition of a constant array, about eight values a line."""
    texts = [literal(v) if kind == "double" else str(int(v)) for v in np.ravel(values)]
    rows = [", ".join(texts[i : i + 8]) for i in range(0, len(texts), 8)]
    return f"TF_UNUSED static const {kind} {name}[{len(texts)}] = {{\n    " + ",\n    ".join(rows) + "};\n"


class _Writer:
    """Writes one C function for one output of the graph."""

    def __init__(self, graph: Graph, where: str, tables: dict[str, str], seeded: bool) -> None:
        self.where = where
        self.seeded = seeded
        self.tables = tables
        self.values: dict[int, str] = {}
        self.seeds: dict[int, str] = {}
        self.lines: list[str] = []
        for role, tensor in graph.inputs.items():
            self.values[id(tensor)] = "dt" if role == "dt" else _INPUTS[role]
            if seeded and role != "dt":
                self.seeds[id(tensor)] = f"d{_INPUTS[role]}"

    def constant(self, values: Array, kind: str = "double") -> str:
        """Return the name of a constant table, shared between the functions."""
        definition = table("@", values, kind)
        return self.tables.setdefault(definition, f"c{len(self.tables)}")

    def element(self, tensor: Tensor, index: str, seed: bool = False) -> str:
        """Return one element's value, or its derivative."""
        if tensor.constant is not None and not seed:
            flat = np.ravel(tensor.constant).astype(float)
            return literal(flat[0]) if flat.size == 1 else f"{self.constant(flat)}[{index}]"
        name = (self.seeds if seed else self.values)[id(tensor)]
        is_scalar = name == "dt" or (tensor.size == 1 and name[-1] not in "LSP")
        return name if is_scalar else f"{name}[{'0' if tensor.size == 1 else index}]"

    def seed_of(self, tensor: Tensor | None, index: str) -> str | None:
        """Return the derivative of one element, None when it is zero."""
        if tensor is None or id(tensor) not in self.seeds:
            return None
        return self.element(tensor, index, seed=True)

    def assign(self, name: str, size: int, expression: str) -> None:
        """Write ``name = expression`` for every element; the expression uses the index i."""
        if size == 1:
            self.lines.append(f"const double {name} = {expression};")
        else:
            self.lines.append(f"double {name}[{size}];")
            self.lines.append(f"for (int i = 0; i < {size}; ++i) {name}[i] = {expression};")

    def step(self, step: Step) -> None:
        """Write the statements of one node."""
        name = f"t{len(self.values)}"
        self.values[id(step.output)] = name
        if step.op in ops.ELEMENTWISE or step.op == "Cast":
            self._elementwise(step, name)
        elif step.op in {"MatMul", "Gemm"}:
            self._product(step, name)
        elif step.op == "ReduceSum":
            self._reduce(step, name)
        elif step.op == "TreeEnsemble":
            self._trees(step, name)
        else:
            self._pick(step, name)

    def _seed(self, step: Step) -> str:
        name = f"d{self.values[id(step.output)]}"
        self.seeds[id(step.output)] = name
        return name

    def _index(self, tensor: Tensor, step: Step) -> str:
        if tensor.size == 1:
            return "0"
        if tensor.size != step.output.size:
            raise refuse(self.where, f"{step.op} spreads {tensor.shape} over {step.output.shape}")
        return "i"

    def _elementwise(self, step: Step, name: str) -> None:
        tensors = [t for t in step.inputs if t is not None]
        a = [self.element(t, self._index(t, step)) for t in tensors]
        d = [self.seed_of(t, self._index(t, step)) for t in tensors]
        op = step.op
        if op == "Clip":  # an absent limit is no limit
            low, high = [*step.inputs[1:], None, None][:2]
            a = [
                a[0],
                "(-INFINITY)" if low is None else self.element(low, "0"),
                "INFINITY" if high is None else self.element(high, "0"),
            ]
        if op == "Cast":
            op = "Identity"
            to = int(step.attributes["to"])
            if to in {1, 10, 16}:
                a = [f"(double)(float)({a[0]})"]
            elif to in {6, 7}:
                a = [f"trunc({a[0]})"]
            elif to == 9:
                a, d = [f"(({a[0]}) != 0.0 ? 1.0 : 0.0)"], [None]
        self.assign(name, step.output.size, ops.ELEMENTWISE[op](a))
        if self.seeded:
            y = name if step.output.size == 1 else f"{name}[i]"
            expression = ops.derivative(op, y, a, d)
            if expression is not None:
                self.assign(self._seed(step), step.output.size, expression)

    def _product(self, step: Step, name: str) -> None:
        x, w = step.inputs[0], step.inputs[1]
        assert x is not None and w is not None and w.constant is not None
        alpha = float(step.attributes.get("alpha", 1.0)) if step.op == "Gemm" else 1.0
        beta = float(step.attributes.get("beta", 1.0)) if step.op == "Gemm" else 1.0
        weights = w.constant.astype(float)
        weights = alpha * (weights.T if step.attributes.get("transB", 0) else weights)
        rows, columns = weights.shape
        matrix = self.constant(weights)
        bias = step.inputs[2] if len(step.inputs) > 2 else None
        if bias is not None and bias.constant is None:
            raise refuse(self.where, "the bias of a Gemm is computed in the graph")
        start = "0.0"
        if bias is not None and bias.constant is not None:
            spread = np.broadcast_to(beta * bias.constant.astype(float), (1, columns))
            start = f"{self.constant(spread)}[j]"
        self._accumulate(name, x, rows, columns, matrix, start, seed=False)
        if self.seeded and id(x) in self.seeds:
            self._accumulate(self._seed(step), x, rows, columns, matrix, "0.0", seed=True)

    def _accumulate(
        self, name: str, x: Tensor, rows: int, columns: int, matrix: str, start: str, seed: bool
    ) -> None:
        """Write ``name = start + x @ matrix`` in blocks of columns whose sums stay in registers."""
        element = self.element(x, "i", seed)
        array = f"{name}a" if columns == 1 else name
        self.lines.append(f"double {array}[{columns}];")
        for first in range(0, columns, _BLOCK):
            width = min(_BLOCK, columns - first)
            self.lines += [
                "{",
                f"    double s[{width}];",
                f"    for (int j = 0; j < {width}; ++j) s[j] = {start.replace('[j]', f'[{first} + j]')};",
                f"    for (int i = 0; i < {rows}; ++i) {{",
                f"        const double x = {element};",
                f"        for (int j = 0; j < {width}; ++j) s[j] += x * {matrix}[i * {columns} + {first} + j];",
                "    }",
                f"    for (int j = 0; j < {width}; ++j) {array}[{first} + j] = s[j];",
                "}",
            ]
        if columns == 1:
            self.lines.append(f"const double {name} = {array}[0];")

    def _reduce(self, step: Step, name: str) -> None:
        x = step.inputs[0]
        assert x is not None
        total = " + ".join(self.element(x, str(i)) for i in range(x.size))
        self.assign(name, 1, total)
        if self.seeded and id(x) in self.seeds:
            self.assign(
                self._seed(step), 1, " + ".join(self.element(x, str(i), seed=True) for i in range(x.size))
            )

    def _pick(self, step: Step, name: str) -> None:
        picked = ops.picks(step.op, step.attributes, step.inputs, self.where)
        self._gathered(name, [self.element(t, str(i)) for t, i in picked])
        if self.seeded and any(id(t) in self.seeds for t, _ in picked):
            self._gathered(self._seed(step), [self.seed_of(t, str(i)) or "0.0" for t, i in picked])

    def _gathered(self, name: str, elements: list[str]) -> None:
        if len(elements) == 1:
            self.lines.append(f"const double {name} = {elements[0]};")
        else:
            self.lines.append(f"const double {name}[{len(elements)}] = {{{', '.join(elements)}}};")

    def _trees(self, step: Step, name: str) -> None:
        a = {k: np.ravel(v) for k, v in step.attributes.items()}

        def branch(side: str) -> Array:
            ids, leafs = a[f"nodes_{side}nodeids"].astype(np.int64), a[f"nodes_{side}leafs"]
            return np.where(leafs == 1, ~ids, ids)  # a leaf is stored as the complement of its number

        x = step.inputs[0]
        assert x is not None
        feature = self.constant(a["nodes_featureids"], "int")
        split = self.constant(a["nodes_splits"].astype(float))
        left, right = self.constant(branch("true"), "int"), self.constant(branch("false"), "int")
        weight, roots = self.constant(a["leaf_weights"].astype(float)), self.constant(a["tree_roots"], "int")
        value = self.element(x, f"{feature}[k]")
        self.lines += [
            f"double {name} = 0.0;",
            f"for (int r = 0; r < {a['tree_roots'].size}; ++r) {{",
            f"    int k = {roots}[r];",
            f"    while (k >= 0) k = {value} <= {split}[k] ? {left}[k] : {right}[k];",
            f"    {name} += {weight}[~k];",
            "}",
        ]


def _function(
    graph: Graph, role: str, head: str, where: str, tables: dict[str, str], seeded: bool = False
) -> str:
    writer = _Writer(graph, where, tables, seeded)
    for step in graph.needed_for(role):
        writer.step(step)
    tensor = graph.outputs[role]
    writer.lines.append(f"for (int i = 0; i < {tensor.size}; ++i) out[i] = {writer.element(tensor, 'i')};")
    if seeded:
        seed = writer.seed_of(tensor, "i") or "0.0"
        writer.lines.append(f"for (int i = 0; i < {tensor.size}; ++i) dout[i] = {seed};")
    unused = "(void)L; (void)S; (void)P;" + (" (void)dt;" if "dt" in head else "")
    unused += " (void)dL; (void)dS; (void)dP;" if seeded else ""
    body = "\n    ".join([unused, *writer.lines])
    return f"TF_UNUSED static void {head} {{\n    {body}\n}}\n"


def generate(source: FrictionSource, interface: FrictionInterface) -> str:
    """Return the C text of a model: constants of the interface and the functions of one contact point.

    Raises
    ------
    InputError
        The graph holds something that is not translated; the message names it.
    """
    graph = read_graph(source.onnx, source.where, len(source.states), len(source.system))
    tables: dict[str, str] = {}
    arguments = "const double *L, const double *S, const double *P"
    seeds = "const double *dL, const double *dS, const double *dP, double *out, double *dout"
    ode = "state_der" in graph.outputs
    functions = [
        _function(graph, "mu", f"tf_model_mu({arguments}, double *out)", source.where, tables),
        _function(graph, "mu", f"tf_model_mu_d({arguments}, {seeds})", source.where, tables, seeded=True),
        _MU_BLOCK,
    ]
    if source.states:
        head = f"tf_model_step({arguments}, double dt, double *out)"
        functions.append(_function(graph, "state_next", head, source.where, tables))
    if ode:
        head = f"tf_model_der({arguments}, double *out)"
        functions.append(_function(graph, "state_der", head, source.where, tables))
        head = f"tf_model_der_d({arguments}, {seeds})"
        functions.append(_function(graph, "state_der", head, source.where, tables, seeded=True))
    lower = [interface.domain.get(q.name, (-np.inf, np.inf))[0] for q in LOADS]
    upper = [interface.domain.get(q.name, (-np.inf, np.inf))[1] for q in LOADS]
    # As friction_models.domain.Domain: the width of the range; for a load that never varied its size, at least 1.
    scale = [b - a if b > a else max(abs(b), 1.0) for a, b in zip(lower, upper)]
    starts = [interface.start(q) for q in LOADS]
    header = [
        "/* Generated from the model's ONNX graph: constants of the interface, one contact point's formulas. */",
        f"#define TF_NODES {interface.nodes}",
        f"#define TF_STATES {len(source.states)}",
        f"#define TF_SYSTEM {len(source.system)}",
        f"#define TF_HAS_DOMAIN {int(bool(interface.domain))}",
        f"#define TF_ODE {int(ode)}",
        "#define TF_BLOCK 16",
        _UNUSED,
        _names("tf_load_names", [q.name for q in LOADS]),
        _names("tf_state_names", [s.name for s in source.states]),
        _names("tf_system_names", [p.name for p in source.system]),
        table("tf_load_lower", [q.lower for q in LOADS]),
        table("tf_load_upper", [q.upper for q in LOADS]),
        table("tf_load_start", starts),
        table("tf_domain_lower", lower),
        table("tf_domain_upper", upper),
        table("tf_domain_scale", scale),
        table("tf_state_start", [s.start for s in source.states] or [0.0]),
        table("tf_system_start", [p.start for p in source.system] or [0.0]),
        table("tf_system_lower", [-np.inf if p.lower is None else p.lower for p in source.system] or [0.0]),
        table("tf_system_upper", [np.inf if p.upper is None else p.upper for p in source.system] or [0.0]),
        _PRELUDE,
    ]
    constants = [d.replace(" @[", f" {name}[", 1) for d, name in tables.items()]
    return "\n".join([*header, *constants, *functions])


def _names(name: str, texts: list[str]) -> str:
    quoted = ", ".join(f'"{"".join(c for c in t if c.isalnum() or c in "_.[]")}"' for t in texts) or '""'
    return f"TF_UNUSED static const char *const {name}[] = {{{quoted}}};"
