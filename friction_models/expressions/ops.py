"""One formula, two back ends: laws are written against `Ops` and run on NumPy arrays or become an ONNX graph.

A law gets an `Ops` object `x`, the loads `L` and perhaps states and system variables, and combines them
with Python operators (``+ - * / ** < > & | ~`` and unary minus) and the functions of `Ops`. It never needs
to know whether it computes numbers (`NumpyOps`) or draws a graph (`friction_models.expressions.onnx_graph.OnnxOps`).
Values are columns of shape [n, 1] (or [n, k]); Python floats and arrays of shape [1, k] or [k] broadcast.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ..loads import LOAD_NAMES, STAND_IN

if TYPE_CHECKING:
    from .trees import TreeTable

#: A float64 array, a number, or a node of a graph: whatever the back end at hand computes with.
Value: TypeAlias = Any
Function: TypeAlias = Callable[..., Value]


@dataclass(frozen=True)
class LoadColumns:
    """The five loads as columns of shape [n, 1]: what a formula sees as ``L``.

    Examples
    --------
    >>> loads = np.array([[50.0, 20.0, 500.0, 0.0, 1.0], [100.0, 80.0, 900.0, 5.0, 1.2]])
    >>> L = LoadColumns.from_matrix(NumpyOps(), loads)
    >>> (L.sigma_n / 100).tolist()
    [[5.0], [9.0]]
    """

    #: Loads in mm/s, degC, MPa, mm, 1; shape [n, 1].
    v_rel: Value
    T: Value
    sigma_n: Value
    sd: Value
    psi: Value

    @classmethod
    def from_matrix(cls, x: Ops, loads: Value) -> LoadColumns:
        """Split a value of shape [n, 5], in the order of the contract."""
        return cls(*(x.column(loads, j) for j in range(len(LOAD_NAMES))))

    def without(self, x: Ops, absent: Sequence[str]) -> LoadColumns:
        """Return the loads as a model sees them that was not given those in `absent`: a constant in their place."""
        return replace(self, **{n: x.constant(STAND_IN[n], getattr(self, n)) for n in absent})

    def at_rest(self) -> LoadColumns:
        """Return the same loads of a contact that stands still."""
        return replace(self, v_rel=0.0 * self.v_rel)

    def columns(self) -> list[Value]:
        """Return the five columns in the order of the contract."""
        return [self.v_rel, self.T, self.sigma_n, self.sd, self.psi]


class Ops:
    """The functions that a formula may use, on float64 arrays; every one has a float64 kernel in ONNX Runtime.

    Examples
    --------
    A law that is written once, for arrays and for ONNX graphs alike:

    >>> def law(x, L):
    ...     return 0.05 + 0.05 * x.exp(-L.v_rel)
    >>> L = LoadColumns.from_matrix(NumpyOps(), np.array([[0.0, 20.0, 500.0, 0.0, 1.0]]))
    >>> law(NumpyOps(), L).tolist()
    [[0.1]]

    The functions:

    >>> x = NumpyOps()
    >>> a = np.array([[-1.0], [4.0]])
    >>> x.relu(a).tolist()
    [[0.0], [4.0]]
    >>> x.where(a > 0.0, x.sqrt(x.abs(a)), 0.0).tolist()
    [[0.0], [2.0]]
    >>> x.matmul(x.concat([a, a]), [[1.0], [2.0]], bias=[1.0]).tolist()
    [[-2.0], [13.0]]
    """

    exp: Function = staticmethod(np.exp)
    log: Function = staticmethod(np.log)
    sqrt: Function = staticmethod(np.sqrt)
    tanh: Function = staticmethod(np.tanh)
    abs: Function = staticmethod(np.abs)
    maximum: Function = staticmethod(np.maximum)
    minimum: Function = staticmethod(np.minimum)
    power: Function = staticmethod(np.power)

    def sigmoid(self, a: Value, /) -> Value:
        return 0.5 + 0.5 * np.tanh(0.5 * np.asarray(a))

    def relu(self, a: Value, /) -> Value:
        return np.maximum(a, 0.0)

    def where(self, condition: Value, a: Value, b: Value) -> Value:
        """Choose `a` where `condition` holds, else `b`; both must be finite everywhere."""
        return np.where(condition, a, b)

    def matmul(self, a: Value, weights: npt.ArrayLike, bias: npt.ArrayLike | None = None) -> Value:
        """Return ``a @ weights + bias`` for `a` [n, k], constant `weights` [k, m] and `bias` [m]."""
        product = np.asarray(a) @ np.asarray(weights, dtype=np.float64)
        return product if bias is None else product + np.asarray(bias, dtype=np.float64)

    def column(self, a: Value, j: int) -> Value:
        """Return column `j` of `a` as [n, 1]."""
        return np.asarray(a)[:, j : j + 1]

    def concat(self, columns: Sequence[Value]) -> Value:
        """Put columns side by side."""
        rows = max(np.shape(c)[0] for c in columns)
        return np.concatenate([np.broadcast_to(c, (rows, np.shape(c)[1])) for c in columns], axis=1)

    def reduce_sum(self, a: Value) -> Value:
        """Sum over the columns of `a` (axis 1); the result is [n, 1]."""
        return np.sum(a, axis=1, keepdims=True)

    def constant(self, value: float, like: Value) -> Value:
        """Return a column of `value` with as many rows as `like`."""
        return np.full((np.shape(like)[0], 1), float(value))

    def tree_ensemble(self, a: Value, trees: TreeTable) -> Value:
        """Return the sum of all trees at the rows of `a` [n, features], as [n, 1]."""
        return trees.evaluate(np.asarray(a))


#: The back end that computes; `friction_models.expressions.onnx_graph.OnnxOps` draws.
NumpyOps = Ops
