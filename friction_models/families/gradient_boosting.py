"""Gradient-boosted regression trees: a black box that needs no shape of the law."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from ..expressions.ops import LoadColumns, Ops, Value
from ..expressions.parameters import check_integer, check_number, check_seed
from ..expressions.trees import MAX_LEAVES, MAX_TREES, IntArray, TreeTable
from ..loads import LOAD_NAMES, FloatArray, TriboLoads
from ..loads.splits import hold_out
from ..models.base import FrictionModel
from ..models.law import Arrays, Groups, JsonObject, Learned, States, System, Weights


@dataclass(eq=False, repr=False)
class GradientBoostingFriction(FrictionModel):
    """mu = sum of small regression trees, trained by scikit-learn's histogram gradient boosting.

    The number of trees is chosen on whole held-out tests, then all tests are used. Outside the domain
    the prediction stays at its border value; it is a step function everywhere.

    Parameters
    ----------
    trees : int
        Largest number of trees.
    learning_rate : float
    leaves : int
        Most leaves a tree.
    min_points : int
        Fewest points a leaf.
    l2 : float
        Regularisation of leaf values.
    validation_fraction : float
        Share of the tests held out to choose the number of trees; 0 keeps `trees`.
    seed : int
        Chooses the tests held out.

    Attributes
    ----------
    trees_ : TreeTable
    baseline_ : float
    validation_tests_ : list of str
        Tests held out to choose the number of trees.

    Examples
    --------
    One tree with two leaves finds a step of the speed; its values are the means on both sides:

    >>> from friction_models import GradientBoostingFriction
    >>> loads = [[v, 20, 500, 0, 1] for v in (10, 20, 30, 40)]
    >>> model = GradientBoostingFriction(trees=1, learning_rate=1, leaves=2, min_points=1, l2=0)
    >>> model = model.fit(loads, [0.12, 0.12, 0.06, 0.06])
    >>> model.predict([[15, 20, 500, 0, 1], [35, 20, 500, 0, 1]]).round(6).tolist()
    [0.12, 0.06]
    """

    family: ClassVar[str] = "gradient_boosting"

    trees: int = 200
    learning_rate: float = 0.08
    leaves: int = 24
    min_points: int = 60
    l2: float = 1.0
    validation_fraction: float = 0.2
    seed: int = 0

    def _fit(self, loads: TriboLoads, mu: FloatArray, groups: Groups, sample_weight: Weights = None) -> None:
        from sklearn.ensemble import HistGradientBoostingRegressor

        params = self._checked_params()
        matrix = loads.as_array()
        count = int(params["max_iter"])
        weights = sample_weight
        train, held = hold_out(groups, len(mu), self.validation_fraction, self.seed)
        self.validation_tests_ = [] if groups is None else sorted(set(groups[held].tolist()))
        if held.any():
            learnt, judged = (None, None) if weights is None else (weights[train], weights[held])
            trial = HistGradientBoostingRegressor(**params).fit(matrix[train], mu[train], learnt)
            errors = [
                np.average((p - mu[held]) ** 2, weights=judged) for p in trial.staged_predict(matrix[held])
            ]
            count = int(np.argmin(errors)) + 1
        final = HistGradientBoostingRegressor(**{**params, "max_iter": count}).fit(matrix, mu, weights)
        self.trees_, constant = table_of([stage[0].nodes for stage in final._predictors])
        self.baseline_ = float(np.ravel(final._baseline_prediction)[0]) + constant

    def _checked_params(self) -> dict[str, float]:
        check_number(self.family, "validation_fraction", self.validation_fraction, 0.0, 0.9)
        return {
            "max_iter": check_integer(self.family, "trees", self.trees, 1, MAX_TREES),
            "learning_rate": check_number(self.family, "learning_rate", self.learning_rate, 1e-4, 1.0),
            "max_leaf_nodes": check_integer(self.family, "leaves", self.leaves, 2, MAX_LEAVES),
            "min_samples_leaf": check_integer(self.family, "min_points", self.min_points, 1, 10**9),
            "l2_regularization": check_number(self.family, "l2", self.l2, 0.0, 1e9),
            "random_state": check_seed(self.family, self.seed),
            # Its own early stopping draws single points, which are not independent.
            "early_stopping": False,
        }

    def formula(self, x: Ops, L: LoadColumns, S: States = None, system: System = None) -> Value:
        if len(self.trees_.nodes) == 0:
            return x.constant(self.baseline_, L.v_rel)
        return x.tree_ensemble(x.concat(L.columns()), self.trees_) + self.baseline_

    def formula_text(self) -> str:
        leaves = len(self.trees_.leaf)
        return f"mu = {self.baseline_:.6g} + {len(self.trees_.nodes)} trees with {leaves} leaves"

    def _learned(self) -> Learned:
        values = {"baseline": self.baseline_, "validation_tests": self.validation_tests_}
        return values, self.trees_.arrays()

    def _restore(self, values: JsonObject, arrays: Arrays) -> None:
        self._checked_params()
        self.baseline_ = check_number(self.family, "baseline", values["baseline"], -math.inf, math.inf)
        self.validation_tests_ = [str(t) for t in values.get("validation_tests", [])]
        self.trees_ = TreeTable.restore(self.family, arrays, len(LOAD_NAMES))


def table_of(trees: list[npt.NDArray[Any]]) -> tuple[TreeTable, float]:
    """Return the trees of scikit-learn's predictors as a `TreeTable`, and the sum of those that are one leaf.

    The predictors have the fields ``is_leaf``, ``value``, ``feature_idx``, ``num_threshold``, ``left``, ``right``.
    """
    constant = 0.0
    counts: list[int] = []
    inner: list[tuple[int, float, int, int]] = []
    leaves: list[float] = []
    for nodes in trees:
        if nodes["is_leaf"][0]:
            constant += float(nodes["value"][0])
            continue
        order, ends = depth_first(nodes)
        place = {n: i for i, n in enumerate(order)} | {n: -1 - k for k, n in enumerate(ends)}
        for n in order:
            node = nodes[n]
            children = place[int(node["left"])], place[int(node["right"])]
            inner.append((int(node["feature_idx"]), float(node["num_threshold"]), *children))
        leaves.extend(float(nodes["value"][n]) for n in ends)
        counts.append(len(order))
    columns: list[IntArray] = [np.array([row[j] for row in inner], dtype=np.int64) for j in (0, 2, 3)]
    table = TreeTable(
        np.array(counts, dtype=np.int64),
        columns[0],
        np.array([row[1] for row in inner], dtype=np.float64),
        columns[1],
        columns[2],
        np.array(leaves, dtype=np.float64),
        len(LOAD_NAMES),
    )
    return table, constant


def depth_first(nodes: npt.NDArray[Any]) -> tuple[list[int], list[int]]:
    """Return the inner nodes, parents first, and the leaves from left to right."""
    order: list[int] = []
    ends: list[int] = []
    stack = [0]
    while stack:
        n = stack.pop()
        if nodes["is_leaf"][n]:
            ends.append(n)
        else:
            order.append(n)
            stack += [int(nodes["right"][n]), int(nodes["left"][n])]
    return order, ends
