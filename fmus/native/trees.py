"""Tables of lanes_trees.h for a TreeEnsemble. Nodes that do not form trees raise InputError."""

from __future__ import annotations

import numpy as np

from friction_models.common import InputError

from .tables import Tables, literal
from .tensors import Attributes


def tree_tables(attributes: Attributes, features: int, tables: Tables, where: str) -> tuple[str, str, int]:
    """Write the trees as two tables; return the names of those of the nodes and of the trees, and the number of trees.

    Raises InputError: an index out of range, or a node that is reached twice.
    """
    feature = attributes.array("nodes_featureids").astype(np.int64)
    split = attributes.array("nodes_splits").astype(float)
    weights = attributes.array("leaf_weights").astype(float)
    roots = attributes.array("tree_roots").astype(np.int64)
    sides = [
        (attributes.array(f"nodes_{s}nodeids").astype(np.int64), attributes.array(f"nodes_{s}leafs"))
        for s in ("true", "false")
    ]
    count = len(feature)
    if any(len(x) != count for x in (split, *sides[0], *sides[1])):
        raise InputError(f"{where}: TreeEnsemble has lists of different lengths for its {count} nodes")
    if count and not 0 <= feature.min() <= feature.max() < features:
        raise InputError(f"{where}: TreeEnsemble uses feature {feature.max()}, allowed: 0 to {features - 1}")
    seen = np.zeros(count, dtype=bool)
    nodes: list[str] = []
    trees: list[str] = []

    def take(index: int, leaf: bool) -> None:
        if not 0 <= index < (len(weights) if leaf else count):
            kind = "leaf" if leaf else "node"
            raise InputError(f"{where}: TreeEnsemble points to {kind} {index}, which does not exist")
        if not leaf:
            if seen[index]:
                raise InputError(f"{where}: TreeEnsemble reaches node {index} twice, allowed: trees")
            seen[index] = True

    for root in roots.tolist():
        take(root, False)
        level, first, depth, size = [(root, False)], len(nodes), 0, 1
        while level:  # level by level: what is near the root stands together
            following: list[tuple[int, bool]] = []
            start = size - len(level)
            for position, (index, leaf) in enumerate(level, start):
                if leaf:
                    nodes.append(f"{{{literal(weights[index])}, 0, {{{position}, {position}}}}}")
                    continue
                children = [(int(ids[index]), bool(leafs[index])) for ids, leafs in sides]
                for child in children:
                    take(*child)
                low = size + len(following)
                nodes.append(f"{{{literal(split[index])}, {feature[index]}, {{{low}, {low + 1}}}}}")
                following += children
            depth += bool(following)
            size += len(following)
            level = following
        trees.append(f"{{{first}, {depth}}}")
    return tables.add_rows(nodes, "tf_tree_node"), tables.add_rows(trees, "tf_tree"), len(trees)
