"""ONNX graphs as other programs write them: one case for every operator that is translated."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import onnx
from onnx import TensorProto, helper, numpy_helper

Array = npt.NDArray[Any]
RNG = np.random.default_rng(21)
FLOAT, DOUBLE = TensorProto.FLOAT, TensorProto.DOUBLE
#: Brings loads of usual contact to between -2 and 2.
SCALE = np.array([[4e-3, 6e-3, 9e-4, 3e-2, 9e-2]])
SHIFT = np.array([[-1.2, -1.4, -1.3, -1.1, -1.0]])
#: Constants that the cases take by name.
CONSTANTS: dict[str, Array] = {
    "scale": SCALE,
    "shift": SHIFT,
    "w": RNG.normal(size=(5, 6)),
    "wt": RNG.normal(size=(6, 5)),
    "b6": RNG.normal(size=6),
    "row": RNG.uniform(0.5, 1.5, size=(1, 5)),
    "slope": RNG.uniform(0.1, 0.4, size=5),
    "half": np.array(0.5),
    "zero": np.array(0.0),
    "two": np.array(2.0),
    "low": np.array(-0.3),
    "high": np.array(0.4),
    "v5": RNG.normal(size=5),
    "mean": RNG.normal(size=5),
    "var": RNG.uniform(0.5, 2.0, size=5),
    "points": RNG.normal(size=(9, 5)),
    "truth": np.array([[True, False, True, True, False]]),
    "axis1": np.array([1]),
    "axis0": np.array([0]),
    "pick": np.array([3, 0, -1]),
    "to15": np.array([1, 5]),
    "to51": np.array([-1, 1]),
    "to151": np.array([0, -1, 1]),
    "s1": np.array([1]),
    "s4": np.array([4]),
    "back": np.array([-1]),
    "front": np.array([-6]),
    "twothree": np.array([2, 3]),
    "rep": np.array([1, 2]),
    "exp": np.array([3, 5]),
    "i0": np.array(0),
    "i5": np.array(5),
    "i1": np.array(1),
}


def node(op: str, inputs: str, output: str, **attributes: Any) -> onnx.NodeProto:
    """Return a node; operand names are one text with blanks ("-" for one left out), a domain stands before "/"."""
    domain, _, name = op.rpartition("/")
    names = ["" if n == "-" else n for n in inputs.split(" ")] if inputs else []
    return helper.make_node(name, names, output.split(" "), domain=domain, **attributes)


def positive(name: str) -> list[onnx.NodeProto]:
    return [node("Mul", "x x", "sq"), node("Add", "sq half", name)]


def unary(op: str, **attributes: Any) -> list[onnx.NodeProto]:
    return [node(op, "x", "y", **attributes)]


def chosen(op: str, inputs: str = "x low") -> list[onnx.NodeProto]:
    return [node(op, inputs, "c"), node("Where", "c x row", "y")]


def truths(op: str) -> list[onnx.NodeProto]:
    return [
        node("Less", "x high", "p"),
        node("Less", "low x", "q"),
        node(op, "p q", "c"),
        node("Where", "c x row", "y"),
    ]


def reduced(op: str, **attributes: Any) -> list[onnx.NodeProto]:
    return [*positive("p"), node(op, "p axis1", "y", **attributes)]


ML, MS = "ai.onnx.ml", "com.microsoft"
#: Nodes from x, float [n, 5] around -2 to 2, to y with one row a point.
CASES: dict[str, list[onnx.NodeProto]] = {
    **{op: unary(op) for op in ("Abs", "Exp", "Neg", "Relu", "Tanh", "Sigmoid", "Softplus", "Softsign", "Identity")},
    **{op: unary(op) for op in ("Erf", "Mish", "HardSwish", "Gelu", "Selu", "Sinh", "Cosh", "Sign", "Floor", "Ceil")},
    **{op: unary(op) for op in ("Softmax", "LogSoftmax", "Dropout")},
    "Elu": unary("Elu", alpha=0.7),
    "Celu": unary("Celu", alpha=1.7),
    "LeakyRelu": unary("LeakyRelu", alpha=0.2),
    "ThresholdedRelu": unary("ThresholdedRelu", alpha=0.3),
    "HardSigmoid": unary("HardSigmoid", alpha=0.3, beta=0.4),
    "Shrink": unary("Shrink", lambd=0.4, bias=0.1),
    "Swish": unary("Swish", alpha=0.8),
    "Gelu tanh": unary("Gelu", approximate="tanh"),
    "PRelu": [node("PRelu", "x slope", "y")],
    **{op: [*positive("p"), node(op, "p", "y")] for op in ("Log", "Sqrt", "Reciprocal")},
    **{op: [node(op, "x row", "y")] for op in ("Add", "Sub", "Mul", "Div", "Max", "Min", "Sum", "Mean")},
    "Pow": [*positive("p"), node("Pow", "p high", "y")],
    "Clip": [node("Clip", "x low high", "y")],
    **{op: chosen(op) for op in ("Less", "Greater", "LessOrEqual", "GreaterOrEqual")},
    "Equal": [node("Relu", "x", "r"), *chosen("Equal", "r zero")],
    "Where": [node("Where", "truth x row", "y")],
    "Not": [node("Less", "x high", "p"), node("Not", "p", "c"), node("Where", "c x row", "y")],
    **{op: truths(op) for op in ("And", "Or", "Xor")},
    "IsNaN": [node("Sqrt", "x", "r"), node("IsNaN", "r", "c"), node("Where", "c x r", "y")],
    "IsInf": [node("Div", "row x", "r"), node("IsInf", "r", "c"), node("Where", "c x r", "y")],
    "Cast": [node("Less", "x low", "c"), node("Cast", "c", "f", to=DOUBLE), node("Mul", "f x", "y")],
    "CastLike": [node("Greater", "x low", "c"), node("CastLike", "c x", "f"), node("Mul", "f x", "y")],
    "MatMul": [node("MatMul", "x w", "y")],
    "Gemm": [node("Gemm", "x wt b6", "y", transB=1, alpha=0.5, beta=2.0)],
    "BatchNormalization": [node("BatchNormalization", "x v5 slope mean var", "y", epsilon=1e-3)],
    "LayerNormalization": [node("LayerNormalization", "x v5 mean", "y")],
    "RMSNormalization": [node("RMSNormalization", "x v5", "y")],
    **{f"Reduce{k}": reduced(f"Reduce{k}") for k in ("Sum", "Mean", "Max", "Min", "Prod", "L1", "L2")},
    "ReduceSumSquare": reduced("ReduceSumSquare"),
    "ReduceLogSum": reduced("ReduceLogSum"),
    "ReduceLogSumExp": reduced("ReduceLogSumExp"),
    "Concat": [node("Exp", "x", "e"), node("Concat", "x e x", "y", axis=1)],
    "Constant": [node("Constant", "", "k", value=numpy_helper.from_array(np.array([[2.0]]))), node("Mul", "x k", "y")],
    "ConstantOfShape": [
        node("Shape", "x", "s"),
        node("ConstantOfShape", "s", "o", value=numpy_helper.from_array(np.array([3.0]))),
        node("Mul", "x o", "y"),
    ],
    "Shape": [node("Shape", "x", "s"), node("Reshape", "x s", "y")],
    "Size": [node("Size", "row", "s"), node("Cast", "s", "f", to=DOUBLE), node("Div", "x f", "y")],
    "Expand": [node("Unsqueeze", "x axis1", "u"), node("Expand", "u exp", "e"), node("ReduceMax", "e axis1", "y", keepdims=0)],
    "Flatten": [node("Unsqueeze", "x axis1", "u"), node("Flatten", "u", "y")],
    "Gather": [node("Gather", "x pick", "y", axis=1)],
    "Range": [node("Range", "i0 i5 i1", "r"), node("Cast", "r", "f", to=DOUBLE), node("Mul", "x f", "y")],
    "Reshape": [node("Reshape", "x to151", "r"), node("MatMul", "r row", "m"), node("ReduceSum", "m axis1", "y", keepdims=0)],
    "Slice": [node("Slice", "x s1 s4 axis1", "a"), node("Slice", "x back front axis1 back", "b"), node("Concat", "a b", "y", axis=1)],
    "Split": [node("Split", "x twothree", "p q", axis=1), node("Concat", "q p", "y", axis=1)],
    "Squeeze": [node("Unsqueeze", "x axis0", "u"), node("Squeeze", "u axis0", "y")],
    "Tile": [node("Tile", "x rep", "y")],
    "Transpose": [node("Transpose", "x", "t", perm=[1, 0]), node("MatMul", "wt t", "m"), node("Transpose", "m", "y")],
    "Unsqueeze": [node("Unsqueeze", "x axis1", "u"), node("Unsqueeze", "x back", "v"), node("MatMul", "u v", "m"), node("Flatten", "m", "y")],
    f"{ML}.Binarizer": [node(f"{ML}/Binarizer", "x", "y", threshold=0.1)],
    f"{ML}.FeatureVectorizer": [node(f"{ML}/FeatureVectorizer", "x x", "y", inputdimensions=[5, 5])],
    f"{ML}.ArrayFeatureExtractor": [node(f"{ML}/ArrayFeatureExtractor", "x pick0", "y")],
    f"{ML}.Imputer": [
        node("Sqrt", "x", "r"),
        node(f"{ML}/Imputer", "r", "y", imputed_value_floats=[0.1, 0.2, 0.3, 0.4, 0.5], replaced_value_float=float("nan")),
    ],
    f"{ML}.LinearRegressor": [
        node(f"{ML}/LinearRegressor", "x", "y", coefficients=[0.1, 0.2, -0.3, 0.4, 0.5], intercepts=[0.7])
    ],
    f"{ML}.Normalizer": [node(f"{ML}/Normalizer", "x", "y", norm="L2")],
    f"{ML}.Scaler": [node(f"{ML}/Scaler", "x", "y", offset=[0.1, 0.2, 0.3, 0.4, 0.5], scale=[2.0, 3.0, 4.0, 5.0, 6.0])],
    **{
        f"{ML}.SVMRegressor {kernel}": [
            node(
                f"{ML}/SVMRegressor",
                "x",
                "y",
                kernel_type=kernel,
                kernel_params=[0.2, 0.3, 3.0],
                n_supports=3,
                support_vectors=RNG.normal(size=15).astype(np.float32).tolist(),
                coefficients=[0.4, -0.7, 0.2],
                rho=[0.3],
            )
        ]
        for kernel in ("LINEAR", "RBF", "POLY", "SIGMOID")
    },
    f"{MS}.Gelu": [node(f"{MS}/Gelu", "x", "y")],
    f"{MS}.FastGelu": [node(f"{MS}/FastGelu", "x v5", "y")],
    f"{MS}.BiasGelu": [node(f"{MS}/BiasGelu", "x v5", "y")],
    f"{MS}.QuickGelu": [node(f"{MS}/QuickGelu", "x", "y", alpha=1.5)],
    f"{MS}.CDist": [node(f"{MS}/CDist", "x points", "y", metric="sqeuclidean")],
}  # fmt: skip
CONSTANTS["pick0"] = np.array([3, 0, 4])


def model_bytes(
    nodes: list[onnx.NodeProto],
    constants: dict[str, Array] | None = None,
    inputs: dict[str, list[Any] | None] | None = None,
    outputs: dict[str, list[Any] | None] | None = None,
    kind: int = FLOAT,
    opset: int = 24,
) -> bytes:
    """Return a serialized model of float or double; constants of real numbers take the type of the graph."""
    real = np.float32 if kind == FLOAT else np.float64
    for n in nodes:  # what the cases write as double follows the graph too
        for a in n.attribute:
            if a.name == "to" and a.i == DOUBLE:
                a.i = kind
            if a.name == "value" and kind == FLOAT:
                a.t.CopyFrom(numpy_helper.from_array(numpy_helper.to_array(a.t).astype(real)))
    arrays = {n: np.asarray(a) for n, a in (constants or {}).items()}
    graph = helper.make_graph(
        nodes,
        "foreign",
        [helper.make_tensor_value_info(n, kind, s) for n, s in (inputs or {"in": ["n", 5]}).items()],
        [helper.make_tensor_value_info(n, kind, s) for n, s in (outputs or {"out": None}).items()],
        [numpy_helper.from_array(a.astype(real) if a.dtype.kind == "f" else a, n) for n, a in arrays.items()],
    )
    domains = [helper.make_opsetid("", opset), helper.make_opsetid(ML, 3), helper.make_opsetid(MS, 1)]
    return bytes(helper.make_model(graph, opset_imports=domains, ir_version=10).SerializeToString())


def case_bytes(name: str, kind: int) -> bytes:
    """Return a model whose output is the weighted sum of what the case makes of scaled loads."""
    nodes = [onnx.NodeProto.FromString(n.SerializeToString()) for n in CASES[name]]
    body = [node("Mul", "in scale", "scaled"), node("Add", "scaled shift", "x"), *nodes]
    tail = (
        [node("ReduceSum", "y axis1", "out", keepdims=1)]
        if name not in {"Softmax", "LogSoftmax"}
        else [
            node("Mul", "y row", "weighted"),
            node("ReduceSum", "weighted axis1", "out", keepdims=1),
        ]
    )
    used = {n for one in [*body, *tail] for n in one.input}
    return model_bytes([*body, *tail], {k: v for k, v in CONSTANTS.items() if k in used}, kind=kind)


def forest(
    modes: list[str],
    aggregate: str = "SUM",
    base: float | None = None,
    trees: int = 7,
    depth: int = 3,
    targets: int = 1,
) -> onnx.NodeProto:
    """Return full binary trees over loads of usual contact, modes in turn."""
    rng = np.random.default_rng(5)
    low, high = np.array([0.0, 20.0, 0.0, 0.0, 0.5]), np.array([600.0, 500.0, 3000.0, 80.0, 25.0])
    inner, every = 2**depth - 1, 2 ** (depth + 1) - 1
    rows = [(t, k) for t in range(trees) for k in range(every)]
    features = [int(rng.integers(5)) if k < inner else 0 for _, k in rows]
    values = [
        float(np.float32(rng.uniform(low[f], high[f]))) if k < inner else 0.0
        for f, (_, k) in zip(features, rows)
    ]
    ends = [(t, k, j) for t, k in rows if k >= inner for j in range(targets)]
    more: dict[str, Any] = {} if base is None else {"base_values": [base] * targets}
    return node(
        f"{ML}/TreeEnsembleRegressor",
        "in",
        "out",
        n_targets=targets,
        aggregate_function=aggregate,
        nodes_treeids=[t for t, _ in rows],
        nodes_nodeids=[k for _, k in rows],
        nodes_featureids=features,
        nodes_values=values,
        nodes_modes=[modes[k % len(modes)] if k < inner else "LEAF" for _, k in rows],
        nodes_truenodeids=[2 * k + 1 if k < inner else 0 for _, k in rows],
        nodes_falsenodeids=[2 * k + 2 if k < inner else 0 for _, k in rows],
        target_treeids=[t for t, _, _ in ends],
        target_nodeids=[k for _, k, _ in ends],
        target_ids=[j for _, _, j in ends],
        target_weights=[float(x) for x in rng.uniform(0.01, 0.05, len(ends))],
        **more,
    )
