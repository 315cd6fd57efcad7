"""Tree ensembles of any spelling become sums of ``<=`` trees of our own graph."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from friction_models.expressions.trees import TreeTable

from .nodes import Array, refuse
from .tensors import Canvas, Constant, Symbol, Tensor
from .view import View

#: Nodes of all trees of one operator; trees where the largest or smallest of them counts.
MAX_TREE_NODES = 1_000_000
MAX_COMPARED_TREES = 256
MAX_TARGETS = 64
_MODES = ("BRANCH_LEQ", "BRANCH_LT", "BRANCH_GTE", "BRANCH_GT", "BRANCH_EQ", "BRANCH_NEQ")


@dataclass
class Forest:
    """Trees as they stand in the file: nodes are numbers, leaves are complements of leaf numbers.

    All lists go by node: the feature it tests, the mode of the test (a place in `_MODES`), the number it compares with, the
    child where the test holds or not. The weights have shape (leaves, targets).
    """

    roots: list[int]
    feature: list[int]
    mode: list[int]
    split: list[float]
    true: list[int]
    false: list[int]
    weights: Array


def regressor(c: Canvas, v: View) -> Tensor:
    """Translate TreeEnsembleRegressor (ai.onnx.ml, operator sets 1 to 4)."""
    forest = _from_columns(v)
    aggregate = str(v.attribute("aggregate_function", "SUM"))
    base = np.ravel(v.attribute("base_values_as_tensor", v.attribute("base_values", np.empty(0))))
    result = _emit(c, v, forest, aggregate, base.astype(np.float64))
    post = str(v.attribute("post_transform", "NONE"))
    if post == "LOGISTIC":
        return c.each(v.op, c.x.sigmoid, result)
    if post != "NONE":
        raise refuse(
            c.where, f"{v.op} with post_transform {post!r:.40} is not translated, allowed: NONE, LOGISTIC"
        )
    return result


def ensemble(c: Canvas, v: View) -> Tensor:
    """Translate TreeEnsemble (ai.onnx.ml, operator set 5)."""
    if int(v.attribute("post_transform", 0)) != 0:
        raise refuse(c.where, "TreeEnsemble with a post_transform is not translated")
    a = {k: np.ravel(x) for k, x in v.node.attributes.items() if not isinstance(x, int | float | str)}
    try:
        modes, splits = a["nodes_modes"].astype(int), a["nodes_splits"].astype(float)
        sides = {
            s: np.where(a[f"nodes_{s}leafs"] != 0, ~a[f"nodes_{s}nodeids"], a[f"nodes_{s}nodeids"]).tolist()
            for s in ("true", "false")
        }
        leaves, targets = a["leaf_weights"].astype(float), a["leaf_targetids"].astype(int)
        roots, features = a["tree_roots"].astype(int).tolist(), a["nodes_featureids"].astype(int).tolist()
    except (KeyError, TypeError, ValueError):
        raise refuse(
            c.where, "TreeEnsemble lacks an attribute, or holds one that is no list of numbers"
        ) from None
    n_targets = int(v.attribute("n_targets", 1))
    table = _weights(v, np.arange(len(leaves)), targets, leaves, len(leaves), n_targets)
    # In this operator set the modes count LEQ, LT, GTE, GT, EQ, NEQ, MEMBER from 0, as `_MODES`.
    forest = Forest(roots, features, modes.tolist(), splits.tolist(), sides["true"], sides["false"], table)
    names = {0: "AVERAGE", 1: "SUM", 2: "MIN", 3: "MAX"}
    code = int(v.attribute("aggregate_function", 1))
    return _emit(c, v, forest, names.get(code, str(code)), np.empty(0))


def _from_columns(v: View) -> Forest:
    """Read the attributes of a TreeEnsembleRegressor, one entry a node, leaves among the nodes."""
    given = v.node.attributes

    def numbers(name: str, default: Any = None) -> Array:
        found = given.get(f"{name}_as_tensor", given.get(name, default))
        if found is None or isinstance(found, str):
            raise refuse(v.where, f"{v.op} lacks the attribute {name}")
        return np.ravel(np.asarray(found))

    tree, node = numbers("nodes_treeids").astype(int), numbers("nodes_nodeids").astype(int)
    modes = [
        m.decode("utf-8", "replace") if isinstance(m, bytes) else str(m) for m in given.get("nodes_modes", [])
    ]
    columns = {n: numbers(n) for n in ("nodes_featureids", "nodes_truenodeids", "nodes_falsenodeids")}
    values = numbers("nodes_values").astype(float)
    count = len(tree)
    if count > MAX_TREE_NODES:
        raise refuse(
            v.where, f"{v.op} with {count} nodes is not translated, allowed: at most {MAX_TREE_NODES}"
        )
    lengths = {len(modes), *(len(x) for x in (node, values, *columns.values()))}
    if lengths != {count}:
        raise refuse(v.where, f"the node attributes of {v.op} have different lengths")
    unknown = set(modes) - {*_MODES, "LEAF"}
    if unknown:
        raise refuse(
            v.where, f"{v.op} with mode {min(unknown)!r:.40} is not translated, allowed: {', '.join(_MODES)}"
        )
    if np.isnan(values).any():
        raise refuse(v.where, f"{v.op} splits at NaN, allowed: numbers")
    place = {key: k for k, key in enumerate(zip(tree.tolist(), node.tolist()))}
    if len(place) != count:
        raise refuse(v.where, f"{v.op} has two nodes of the same number")
    leaf_of: dict[int, int] = {}
    inner: dict[int, int] = {}
    for k, mode in enumerate(modes):
        (leaf_of if mode == "LEAF" else inner)[k] = len(leaf_of if mode == "LEAF" else inner)

    def child(k: int, name: str) -> int:
        target = place.get((int(tree[k]), int(columns[name][k])))
        if target is None:
            raise refuse(v.where, f"{v.op}: node {int(node[k])} of tree {int(tree[k])} has no child")
        return ~leaf_of[target] if target in leaf_of else inner[target]

    own = list(inner)
    true = [child(k, "nodes_truenodeids") for k in own]
    false = [child(k, "nodes_falsenodeids") for k in own]
    targets = numbers("target_ids").astype(int)
    weights = numbers("target_weights").astype(float)
    keys = zip(numbers("target_treeids").astype(int).tolist(), numbers("target_nodeids").astype(int).tolist())
    leaves = [leaf_of.get(place.get(key, -1), -1) for key in keys]
    if len(leaves) != len(weights) or min(leaves, default=0) < 0:
        raise refuse(v.where, f"{v.op} gives a weight to something that is no leaf")
    table = _weights(
        v, np.array(leaves, dtype=int), targets, weights, len(leaf_of), int(v.attribute("n_targets", 1))
    )
    firsts: dict[int, int] = {}
    for k, t in enumerate(tree.tolist()):
        firsts.setdefault(t, k)
    reached = {*true, *false}
    roots = []
    for k in firsts.values():
        root = ~leaf_of[k] if k in leaf_of else inner[k]
        if root in reached:
            raise refuse(v.where, f"{v.op}: tree {int(tree[k])} does not begin with its root")
        roots.append(root)
    return Forest(
        roots,
        columns["nodes_featureids"][own].astype(int).tolist(),
        [_MODES.index(modes[k]) for k in own],
        values[own].tolist(),
        true,
        false,
        table,
    )


def _weights(v: View, leaves: Array, targets: Array, weights: Array, count: int, n_targets: int) -> Array:
    if not 1 <= n_targets <= MAX_TARGETS or len(targets) != len(weights):
        raise refuse(
            v.where, f"{v.op} with {n_targets} targets is not translated, allowed: 1 to {MAX_TARGETS}"
        )
    if len(targets) and not 0 <= targets.min() <= targets.max() < n_targets:
        raise refuse(v.where, f"{v.op} gives a weight to target {targets.max()} of {n_targets}")
    table = np.zeros((count, n_targets))
    np.add.at(table, (leaves, targets), weights)
    return table


def _emit(c: Canvas, v: View, forest: Forest, aggregate: str, base: Array) -> Tensor:
    """Draw the trees: one TreeEnsemble a target, or one a tree where the extreme tree counts."""
    value = v.tensor(0)
    if isinstance(value, Constant):
        raise refuse(c.where, f"{v.op} of a constant is not translated")
    value = c.reshape(value, (1, value.size))
    single = value.kind == "float32"
    value = c.rounded(value)
    assert isinstance(value, Symbol)
    n_targets = forest.weights.shape[1]
    if base.size not in (0, 1, n_targets):
        raise refuse(c.where, f"{v.op} has {base.size} base values, allowed: one a target")
    trees = _normal(c, v, forest, value.size, single)
    if aggregate in {"MIN", "MAX"} and len(trees) > MAX_COMPARED_TREES:
        raise refuse(c.where, f"{v.op} compares {len(trees)} trees, allowed: at most {MAX_COMPARED_TREES}")
    if aggregate not in {"SUM", "AVERAGE", "MIN", "MAX"} or not trees:
        raise refuse(
            c.where, f"{v.op} that aggregates {len(trees)} trees by {aggregate!r:.40} is not translated"
        )
    columns = []
    for k in range(n_targets):
        offset = float(base[min(k, base.size - 1)]) if base.size else 0.0
        if aggregate in {"MIN", "MAX"}:
            function = c.x.minimum if aggregate == "MIN" else c.x.maximum
            total = _draw(c, value, trees[:1], forest.weights[:, k], 1.0)
            for tree in trees[1:]:
                total = function(total, _draw(c, value, [tree], forest.weights[:, k], 1.0))
        else:
            share = 1.0 / len(trees) if aggregate == "AVERAGE" else 1.0
            total = _draw(c, value, trees, forest.weights[:, k], share)
        columns.append(total + offset if offset else total)
    node = columns[0] if n_targets == 1 else c.x.concat(columns)
    return Symbol(node, (1, n_targets), "float64" if value.kind == "float64" else "float32")


@dataclass
class _Tree:
    """One tree of ``<=`` nodes, parents before children; leaves are complements of their numbers."""

    feature: list[int]
    split: list[float]
    left: list[int]
    right: list[int]
    root: int


def _normal(c: Canvas, v: View, forest: Forest, features: int, single: bool) -> list[_Tree]:
    """Return the trees with ``<=`` tests only; no node may be reached twice."""
    real = np.float32 if single else np.float64
    count = len(forest.feature)
    seen = bytearray(count)
    result: list[_Tree] = []
    for root in forest.roots:
        tree = _Tree([], [], [], [], root if root < 0 else 0)
        # Entries: node of the file, where to write the number of the new node.
        stack: list[tuple[int, list[int] | None, int]] = [(root, None, 0)] if root >= 0 else []
        while stack:
            k, holder, position = stack.pop()
            if not 0 <= k < count or seen[k]:
                raise refuse(c.where, f"{v.op}: node {k} is missing or reached twice; allowed: trees")
            seen[k] = 1
            if not 0 <= forest.feature[k] < features:
                raise refuse(c.where, f"{v.op} asks for feature {forest.feature[k]} of {features}")
            here = len(tree.feature)
            if holder is not None:
                holder[position] = here
            mode, split = forest.mode[k], forest.split[k]
            if not 0 <= mode < len(_MODES):
                raise refuse(
                    c.where, f"{v.op} with mode {mode} is not translated, allowed: 0 to {len(_MODES) - 1}"
                )
            name = _MODES[mode]
            true, false = forest.true[k], forest.false[k]
            if name in {"BRANCH_GT", "BRANCH_GTE", "BRANCH_NEQ"}:
                true, false = false, true
            below = float(np.nextafter(real(split), real(-np.inf)))  # x < split: x <= the number below it
            tree.feature.append(forest.feature[k])
            tree.split.append(below if name in {"BRANCH_LT", "BRANCH_GTE"} else split)
            tree.left.append(true)
            tree.right.append(false)
            if name in {"BRANCH_EQ", "BRANCH_NEQ"}:
                # x == t: x <= t, and not x <= the number below t. What does not match is needed on both sides.
                if false >= 0:
                    raise refuse(c.where, f"{v.op} with {name} above more than a leaf is not translated")
                tree.feature.append(forest.feature[k])
                tree.split.append(below)
                tree.left[here], tree.right[here] = here + 1, false
                tree.left.append(false)
                tree.right.append(true)
                children = [(true, tree.right, here + 1)]
            else:
                children = [(true, tree.left, here), (false, tree.right, here)]
            stack += [entry for entry in children if entry[0] >= 0]
        result.append(tree)
    return result


def _draw(c: Canvas, value: Symbol, trees: list[_Tree], weights: Array, share: float) -> Any:
    """Add a TreeEnsemble with the sum of the trees; trees that are a single leaf become a number."""
    alone = sum(share * _leaf(c, weights, tree.root) for tree in trees if tree.root < 0)
    grown = [tree for tree in trees if tree.root >= 0]
    if not grown:
        return c.x.constant(alone, value.node)
    nodes: list[int] = []
    feature: list[int] = []
    split: list[float] = []
    left: list[int] = []
    right: list[int] = []
    leaf: list[float] = []
    for tree in grown:
        numbers: list[float] = []
        for side, target in ((tree.left, left), (tree.right, right)):
            for child in side:
                if child < 0:
                    numbers.append(share * _leaf(c, weights, child))
                    target.append(-len(numbers))
                else:
                    target.append(child)
        nodes.append(len(tree.feature))
        feature += tree.feature
        split += tree.split
        leaf += numbers
    whole = [np.array(x, dtype=np.int64) for x in (nodes, feature, left, right)]
    table = TreeTable(whole[0], whole[1], np.array(split), whole[2], whole[3], np.array(leaf), value.size)
    total = c.x.tree_ensemble(c.number(value).node, table)
    return total + alone if alone else total


def _leaf(c: Canvas, weights: Array, child: int) -> float:
    if not 0 <= ~child < len(weights):
        raise refuse(c.where, f"a tree ends at leaf {~child}, allowed: 0 to {len(weights) - 1}")
    return float(weights[~child])
