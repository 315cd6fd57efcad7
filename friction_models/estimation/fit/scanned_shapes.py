"""The best scan values of effects beside one another, from where their shapes are fitted."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ...loads import FloatArray
from ..search.candidates import Candidate
from ..search.scan import Prepared, Projector, best_fit, prepare_candidate

#: Share of the squares of two columns below which they tell the same.
APART = 1e-6


def scanned_shapes(
    candidates: Sequence[Candidate],
    base: FloatArray,
    y: FloatArray,
    whiten: Callable[[FloatArray], FloatArray],
) -> list[dict[str, float]]:
    """Return the best shape parameters of every effect: two of one amplitude together, else one after the other.

    `base`, shape (m, p), and `y`, shape (m,), are those of the bins.
    """
    target = whiten(y)
    if [c.columns.shape[2] for c in candidates] == [1, 1]:
        project = Projector(whiten(base))
        first, second = (prepare_candidate(c, whiten, project) for c in candidates)
        if (best := best_pair(first, second, project(target))) is not None:
            return [c.shape_at(k) for c, k in zip(candidates, best, strict=True)]
    blocks, places = [c.columns[:, 0] for c in candidates], [0] * len(candidates)
    for _ in range(2 if len(candidates) > 1 else 1):
        for k, candidate in enumerate(candidates):
            project = Projector(whiten(np.column_stack([base, *blocks[:k], *blocks[k + 1 :]])))
            places[k] = best_fit(prepare_candidate(candidate, whiten, project), project(target)).index
            blocks[k] = candidate.columns[:, places[k]]
    return [c.shape_at(k) for c, k in zip(candidates, places, strict=True)]


def best_pair(first: Prepared, second: Prepared, target: FloatArray) -> tuple[int, int] | None:
    """Return which sets of scan values of two effects of one amplitude each leave least of a whitened `target`, shape (m,).

    One after the other, two effects along one load can end where each mends what the other spoils. None where no two of them lower
    the squares with the signs that they must have.

    Examples
    --------
    >>> from types import SimpleNamespace as Made
    >>> x = np.eye(3)[:, :2]
    >>> two = Made(columns=x[:, :, None], gram=np.ones((2, 1, 1)), usable=np.ones((2, 1), dtype=bool), signs=np.ones(1))
    >>> best_pair(two, two, np.array([1.0, 2.0, 0.5]))
    (0, 1)
    """
    a, b = first.columns[:, :, 0], second.columns[:, :, 0]
    along_a, along_b = (a.T @ target)[:, None], (b.T @ target)[None, :]
    squares_a, squares_b = first.gram[:, 0, :1], second.gram[:, 0, 0][None, :]
    both = a.T @ b
    determinant = squares_a * squares_b - both**2
    usable = (first.usable[:, :1] & second.usable[:, 0]) & (determinant > APART * squares_a * squares_b)
    divisor = np.where(usable, determinant, 1.0)
    size_a = (squares_b * along_a - both * along_b) / divisor
    size_b = (squares_a * along_b - both * along_a) / divisor
    usable &= (size_a * first.signs[0] >= 0.0) & (size_b * second.signs[0] >= 0.0)
    drop = np.where(usable, size_a * along_a + size_b * along_b, 0.0)
    best = np.unravel_index(int(np.argmax(drop)), drop.shape)
    return (int(best[0]), int(best[1])) if drop[best] > 0.0 else None
