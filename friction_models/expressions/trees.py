"""Regression trees as plain arrays, and their fast evaluation in NumPy."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
import numpy.typing as npt

from ..common import InputError
from ..loads import FloatArray
from .parameters import Arrays, stored_floats, stored_integers

IntArray = npt.NDArray[np.int64]
#: One bit of a 64-bit word a leaf.
MAX_LEAVES = 64
MAX_TREES = 5000
MAX_TABLE_BYTES = 512 * 1024**2
ROWS_AT_ONCE = 1024


@dataclass(frozen=True)
class TreeTable:
    """A sum of binary regression trees.

    Inner nodes of all trees stand one after the other, parents before children; a point goes to
    `left` where its feature is <= the threshold. Every tree has at least one inner node.

    Examples
    --------
    One tree: 0.12 up to a feature of 25, 0.06 above.

    >>> tree = TreeTable(
    ...     nodes=np.array([1]),
    ...     feature=np.array([0]),
    ...     threshold=np.array([25.0]),
    ...     left=np.array([-1]),
    ...     right=np.array([-2]),
    ...     leaf=np.array([0.12, 0.06]),
    ...     features=1,
    ... )
    >>> tree.evaluate(np.array([[20.0], [25.0], [30.0]])).tolist()
    [[0.12], [0.12], [0.06]]
    """

    #: Inner nodes a tree; its leaves are one more; shape (trees,).
    nodes: IntArray
    #: Shape (sum of nodes,).
    feature: IntArray
    threshold: FloatArray
    #: Child within the same tree: ``i >= 0`` inner node i, ``-1 - k`` leaf k. Leaves count from left to
    #: right; shape (sum of nodes,).
    left: IntArray
    right: IntArray
    #: Leaf values, tree after tree; shape (sum of nodes + trees,).
    leaf: FloatArray
    #: Number of features.
    features: int

    def evaluate(self, matrix: FloatArray) -> FloatArray:
        """Return the sum of all trees at each row, shape (n, 1).

        Every inner node whose test fails rules out the leaves on its left. A table a feature holds,
        for each interval between thresholds, which leaves of each tree remain; the leftmost leaf that
        remains for all features is the one reached (the idea of QuickScorer, Lucchese et al., SIGIR 2015).
        """
        total = np.zeros((len(matrix), 1))
        if len(self.nodes) == 0:
            return total
        limits, tables, values, offsets = self._tables
        for start in range(0, len(matrix), ROWS_AT_ONCE):
            rows = matrix[start : start + ROWS_AT_ONCE]
            left = tables[0][np.searchsorted(limits[0], rows[:, 0], side="left")]
            for j in range(1, self.features):
                left &= tables[j][np.searchsorted(limits[j], rows[:, j], side="left")]
            # The lowest bit set, minus one, has as many bits set as there are leaves before it.
            index = np.bitwise_count((left & -left) - np.uint64(1)) + offsets
            total[start : start + ROWS_AT_ONCE, 0] = values[index].sum(axis=1)
        return total

    @cached_property
    def _tables(self) -> tuple[list[FloatArray], list[npt.NDArray[np.uint64]], FloatArray, IntArray]:
        trees = len(self.nodes)
        tree = np.repeat(np.arange(trees), self.nodes)
        spare = ~self._left_masks()
        limits, tables = [], []
        for j in range(self.features):
            own = np.flatnonzero(self.feature == j)
            unique, position = np.unique(self.threshold[own], return_inverse=True)
            table = np.full((len(unique) + 1, trees), np.iinfo(np.uint64).max, dtype=np.uint64)
            np.bitwise_and.at(table, (position + 1, tree[own]), spare[own])
            np.bitwise_and.accumulate(table, axis=0, out=table)
            limits.append(unique)
            tables.append(table)
        values = np.zeros((trees, MAX_LEAVES))
        values[np.arange(MAX_LEAVES) <= self.nodes[:, None]] = self.leaf
        return limits, tables, values.ravel(), np.arange(trees) * MAX_LEAVES

    def _left_masks(self) -> npt.NDArray[np.uint64]:
        """Return for each inner node the bits of the leaves below its left child."""
        below = np.zeros(len(self.feature), dtype=np.uint64)
        mask = np.zeros(len(self.feature), dtype=np.uint64)
        one = np.uint64(1)
        first = np.repeat(np.cumsum(self.nodes) - self.nodes, self.nodes)
        # Children stand behind their parents, so backwards every child is known before its parent.
        for i in range(len(self.feature) - 1, -1, -1):
            sides = [
                below[first[i] + child] if child >= 0 else one << np.uint64(-1 - child)
                for child in (int(self.left[i]), int(self.right[i]))
            ]
            mask[i] = sides[0]
            below[i] = sides[0] | sides[1]
        return mask

    def arrays(self) -> dict[str, IntArray | FloatArray]:
        """Return the arrays to store."""
        return {n: getattr(self, n) for n in ("nodes", "feature", "threshold", "left", "right", "leaf")}

    @classmethod
    def restore(cls, family: str, arrays: Arrays, features: int) -> Self:
        """Take back what `arrays` returned.

        Raises InputError: the arrays do not describe trees: a node is reached twice or never, an index is out
        of range.
        """
        nodes = stored_integers(family, arrays, "nodes", (None,))
        if len(nodes) > MAX_TREES or (len(nodes) and not 1 <= nodes.min() <= nodes.max() < MAX_LEAVES):
            raise InputError(
                f"{family}: {len(nodes)} trees with up to {nodes.max()} inner nodes; allowed: {MAX_TREES} trees "
                f"with 1 to {MAX_LEAVES - 1}"
            )
        count = int(nodes.sum())
        feature, left, right = (
            stored_integers(family, arrays, n, (count,)) for n in ("feature", "left", "right")
        )
        table = cls(
            nodes,
            feature,
            stored_floats(family, arrays, "threshold", (count,)),
            left,
            right,
            stored_floats(family, arrays, "leaf", (count + len(nodes),)),
            features,
        )
        table._check(family)
        return table

    def _check(self, family: str) -> None:
        start = 0
        for tree, count in enumerate(self.nodes.tolist()):
            own = slice(start, start + count)
            children = np.concatenate([self.left[own], self.right[own]])
            parents = np.tile(np.arange(count), 2)
            expected = np.arange(-1 - count, count)
            reached = np.sort(np.append(children, 0))
            behind = (children < 0) | (children > parents)
            if len(reached) != len(expected) or (reached != expected).any() or not behind.all():
                raise InputError(
                    f"{family}: tree {tree} is no tree; allowed: every node but the root is the child of one "
                    "node before it"
                )
            start += count
        if len(self.feature) and not 0 <= self.feature.min() <= self.feature.max() < self.features:
            raise InputError(
                f"{family}: feature index {self.feature.max()}, allowed: 0 to {self.features - 1}"
            )
        size = 8 * len(self.nodes) * (len(np.unique(self.threshold)) + self.features)
        if size > MAX_TABLE_BYTES:
            raise InputError(f"{family}: the trees need {size} bytes in memory, allowed: {MAX_TABLE_BYTES}")
