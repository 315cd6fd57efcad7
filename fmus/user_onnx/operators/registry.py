"""Which foreign operators are translated, and by what."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from . import arithmetic, classic, products, structure, trees
from .tensors import Canvas, Tensor
from .view import View

Translation: TypeAlias = Callable[[Canvas, View], Tensor | list[Tensor]]

STANDARD: dict[str, Translation] = {
    **dict.fromkeys(arithmetic.FORMULAS, arithmetic.formula),
    **dict.fromkeys(("Add", "Sub", "Mul", "Div", "Pow", "Sum", "Mean", "Max", "Min"), arithmetic.binary),
    **dict.fromkeys(("Less", "LessOrEqual", "Greater", "GreaterOrEqual", "Equal"), arithmetic.compare),
    **dict.fromkeys(("And", "Or", "Xor", "Not"), arithmetic.logic),
    **dict.fromkeys(("IsNaN", "IsInf"), arithmetic.not_a_number),
    **dict.fromkeys(("Cast", "CastLike"), arithmetic.cast),
    **dict.fromkeys(("Floor", "Ceil"), arithmetic.whole),
    **dict.fromkeys(("Shape", "Size"), structure.shape_of),
    **dict.fromkeys(("Identity", "Dropout"), structure.identity),
    **dict.fromkeys(("Softmax", "LogSoftmax"), products.softmax),
    **dict.fromkeys(("LayerNormalization", "RMSNormalization"), products.layer_normalization),
    **dict.fromkeys(("ReduceSum", "ReduceMean", "ReduceMax", "ReduceMin", "ReduceProd"), products.reduce),
    **dict.fromkeys(("ReduceL1", "ReduceL2", "ReduceSumSquare"), products.reduce),
    **dict.fromkeys(("ReduceLogSum", "ReduceLogSumExp"), products.reduce),
    "BatchNormalization": products.batch_normalization,
    "Clip": arithmetic.clip,
    "Concat": structure.concat,
    "Constant": structure.constant,
    "ConstantOfShape": structure.constant_of_shape,
    "Expand": structure.expand,
    "Flatten": structure.flatten,
    "Gather": structure.gather,
    "Gelu": arithmetic.gelu,
    "Gemm": products.gemm,
    "MatMul": products.matmul,
    "PRelu": arithmetic.prelu,
    "Range": structure.range_,
    "Reshape": structure.reshape,
    "Slice": structure.slice_,
    "Split": structure.split,
    "Squeeze": structure.squeeze,
    "Tile": structure.tile,
    "Transpose": structure.transpose,
    "Unsqueeze": structure.unsqueeze,
    "Where": arithmetic.where,
}
MACHINE_LEARNING: dict[str, Translation] = {
    "ArrayFeatureExtractor": structure.gather,
    "Binarizer": classic.binarizer,
    "FeatureVectorizer": structure.feature_vector,
    "Imputer": classic.imputer,
    "LinearRegressor": classic.linear,
    "Normalizer": classic.normalizer,
    "SVMRegressor": classic.support_vectors,
    "Scaler": classic.scaler,
    "TreeEnsemble": trees.ensemble,
    "TreeEnsembleRegressor": trees.regressor,
}
MICROSOFT: dict[str, Translation] = {
    "CDist": classic.distances,
    **dict.fromkeys(("BiasGelu", "FastGelu", "Gelu", "QuickGelu"), arithmetic.gelu),
}
DOMAINS = {"": STANDARD, "ai.onnx.ml": MACHINE_LEARNING, "com.microsoft": MICROSOFT}
#: Operators that decide by comparing with float32 numbers: what leads to them is rounded as the original rounds.
DECIDING = frozenset({"TreeEnsemble", "TreeEnsembleRegressor"})
#: Operators after which nothing needs to be rounded again.
MOVING = frozenset(
    {"Identity", "Dropout", "Cast", "Concat", "Constant", "Expand", "Flatten", "Gather", "Reshape", "Slice"}
    | {"ArrayFeatureExtractor", "FeatureVectorizer", "Split", "Squeeze", "Tile", "Transpose", "Unsqueeze"}
)


def translated() -> list[str]:
    """Return the names of all translated operators, those of other domains with their domain.

    Examples
    --------
    >>> {"MatMul", "Relu"} <= set(translated())
    True
    """
    return sorted(f"{domain}.{op}" if domain else op for domain, table in DOMAINS.items() for op in table)
