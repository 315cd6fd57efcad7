"""Operators of classical machine learning: scalers, linear and kernel regressors, distances."""

from __future__ import annotations

import numpy as np

from .nodes import Array, refuse
from .tensors import Canvas, Constant, Symbol, Tensor
from .view import View


def _numbers(v: View, name: str, size: int | None = None) -> Array:
    found = v.node.attributes.get(name)
    values = np.ravel(np.asarray([] if found is None else found)).astype(np.float64)
    if not np.isfinite(values).all() or (size is not None and values.size not in (1, size)):
        raise refuse(
            v.where, f"attribute {name} of {v.op} has {values.size} numbers, allowed: {size} finite ones"
        )
    return values


def _row(c: Canvas, v: View) -> Tensor:
    value = v.tensor(0)
    return c.reshape(value, (1, value.size))


def scaler(c: Canvas, v: View) -> Tensor:
    """Translate Scaler: ``(x - offset) * scale``."""
    value = _row(c, v)
    offset, scale = (Constant(_numbers(v, n, value.size), value.kind) for n in ("offset", "scale"))
    if value.kind == "int64" and isinstance(value, Symbol):
        value = Symbol(value.node, value.shape, "float32")
    shifted = c.each(v.op, lambda a, b: a - b, value, offset)
    return c.each(v.op, lambda a, b: a * b, shifted, scale)


def linear(c: Canvas, v: View) -> Tensor:
    """Translate LinearRegressor."""
    if str(v.attribute("post_transform", "NONE")) != "NONE":
        raise refuse(c.where, "LinearRegressor with a post_transform is not translated")
    value = _row(c, v)
    targets = int(v.attribute("targets", 1))
    weights, bias = _numbers(v, "coefficients"), _numbers(v, "intercepts")
    if targets < 1 or weights.size != targets * value.size or bias.size not in (0, targets):
        raise refuse(
            c.where, f"LinearRegressor with {weights.size} coefficients for {value.size} columns does not fit"
        )
    matrix = weights.reshape(targets, value.size).T
    return c.affine(value, matrix, bias if bias.size else np.zeros(targets), v.op)


def normalizer(c: Canvas, v: View) -> Tensor:
    """Translate Normalizer: rows divided by their norm."""
    value, norm = _row(c, v), str(v.attribute("norm", "MAX"))
    if norm == "L1":
        size = c.total(c.each(v.op, c.x.abs, value), (1,), True, v.op)
    elif norm == "L2":
        size = c.each(v.op, c.x.sqrt, c.total(c.each(v.op, lambda a: a * a, value), (1,), True, v.op))
    else:
        raise refuse(c.where, f"Normalizer with norm {norm!r:.20} is not translated, allowed: L1, L2")
    return c.each(v.op, lambda a, s: a / s, value, size)


def binarizer(c: Canvas, v: View) -> Tensor:
    """Translate Binarizer: 1 above the threshold, else 0."""
    value, limit = c.rounded(v.tensor(0)), float(v.attribute("threshold", 0.0))
    return c.each(v.op, lambda a: c.x.where(a > limit, 1.0 + 0.0 * a, 0.0 * a), value)


def imputer(c: Canvas, v: View) -> Tensor:
    """Translate Imputer: what is NaN (or equal to a value) is replaced."""
    value = _row(c, v)
    fill = Constant(_numbers(v, "imputed_value_floats", value.size), value.kind)
    replaced = v.node.attributes.get("replaced_value_float", 0.0)
    if fill.size == 0:
        raise refuse(c.where, "Imputer of whole numbers is not translated")
    if np.isnan(replaced):
        return c.each(v.op, lambda a, b: c.x.where((a < 1.0) | (a > 0.0), a, b), value, fill)
    return c.each(v.op, lambda a, b: c.x.where((a < replaced) | (a > replaced), a, b), value, fill)


def support_vectors(c: Canvas, v: View) -> Tensor:
    """Translate SVMRegressor: kernels LINEAR, RBF, POLY, SIGMOID."""
    value = _row(c, v)
    if v.attribute("one_class", 0) or str(v.attribute("post_transform", "NONE")) != "NONE":
        raise refuse(c.where, "SVMRegressor of one class or with a post_transform is not translated")
    kernel = str(v.attribute("kernel_type", "LINEAR"))
    parameters = [*_numbers(v, "kernel_params"), 0.0, 0.0, 0.0][:3]
    gamma, coef0, degree = (float(p) for p in parameters)
    weights, rho = _numbers(v, "coefficients"), _numbers(v, "rho")
    vectors = _numbers(v, "support_vectors")
    count = int(v.attribute("n_supports", 0))
    rows = count or 1
    if rho.size != 1 or vectors.size not in (0, rows * value.size) or weights.size != (count or value.size):
        raise refuse(
            c.where, f"SVMRegressor with {weights.size} coefficients and {vectors.size} numbers does not fit"
        )
    if count == 0:  # a linear machine without vectors
        return c.affine(value, weights.reshape(-1, 1), rho, v.op)
    points = vectors.reshape(count, value.size)
    if kernel == "RBF":
        k = c.each(v.op, lambda d: c.x.exp(-gamma * d), squared_distances(c, value, points, v.op))
    else:
        k = c.matmul(value, Constant(points.T, value.kind), v.op)
        if kernel == "POLY":
            k = c.each(v.op, lambda p: c.x.power(gamma * p + coef0, degree), k)
        elif kernel == "SIGMOID":
            k = c.each(v.op, lambda p: c.x.tanh(gamma * p + coef0), k)
        elif kernel != "LINEAR":
            raise refuse(c.where, f"SVMRegressor with kernel {kernel!r:.20} is not translated")
    return c.affine(k, weights.reshape(-1, 1), rho, v.op)


def squared_distances(c: Canvas, value: Tensor, points: Array, what: str) -> Tensor:
    """Return the squared distances of one row to constant points, shape (1, points); by differences, not products."""
    total: Tensor | None = None
    for j in range(points.shape[1]):
        column = c.move(what, lambda a, j=j: a[:, j : j + 1], value)
        own = Constant(points[None, :, j], value.kind)
        squares = c.each(what, lambda a, b: (a - b) * (a - b), column, own)
        total = squares if total is None else c.each(what, lambda a, b: a + b, total, squares)
    if total is None:
        raise refuse(c.where, f"{what} of points without coordinates is not translated")
    return total


def distances(c: Canvas, v: View) -> Tensor:
    """Translate ONNX Runtime's CDist between the loads and constant points."""
    metric = str(v.attribute("metric", "sqeuclidean"))
    first, second = v.tensor(0), v.tensor(1)
    turned = isinstance(first, Constant)
    value, points = (second, first) if turned else (first, second)
    if not isinstance(points, Constant) or len(points.shape) != 2 or len(value.shape) != 2:
        raise refuse(c.where, "CDist between two computed matrices is not translated")
    if metric not in {"sqeuclidean", "euclidean"} or value.shape[0] != 1 or value.shape[1] != points.shape[1]:
        raise refuse(
            c.where, f"CDist with metric {metric!r:.20} of {value.shape} and {points.shape} is not translated"
        )
    result = squared_distances(c, value, points.array, v.op)
    if metric == "euclidean":
        # At a point itself the square root is 0 and its slope infinite; the generator makes that slope 0.
        result = c.each(v.op, c.x.sqrt, result)
    return c.reshape(result, (result.size, 1)) if turned else result
