"""What may still change in a model while physical effects are fitted with it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations_with_replacement
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..loads import LOAD_NAMES, FloatArray, TriboLoads

FOLDS = 5


@dataclass(frozen=True)
class MeasuredPoints:
    """Measured points at which a model is asked for its `tangent`."""

    loads: TriboLoads
    #: Measured coefficient of friction; shape (n,).
    mu: FloatArray
    #: Names of the tests.
    tests: Sequence[str]
    #: Test of each point, as its place in `tests`; shape (n,).
    point_test: npt.NDArray[np.intp]
    #: Returns the columns of an effect, one an amplitude, each of shape (n, 1) or (1, 1), from the effect,
    #: the friction coefficient that it sees, shape (n,), and its shape parameters.
    effect_columns: Callable[[Any, FloatArray, Mapping[str, float]], Sequence[FloatArray]] = field(repr=False)
    #: Of the folds.
    seed: int = 0


class Beside(NamedTuple):
    """What a model could do, though no fit of it does: follow another constant, or a smooth curve where it has steps."""

    name: str  #: In a sentence.
    column: FloatArray  #: Shape (n,).
    loads: tuple[str, ...] = ()  #: Along which it bends; none given, it may stand for any effect.


@dataclass(frozen=True)
class Tangent:
    """A model at measured points: ``mu = offset + columns @ coefficients``.

    Examples
    --------
    >>> from friction_models import ConstantFriction, TriboLoads
    >>> loads = TriboLoads.from_array([[50, 20, 500, 0, 1], [50, 20, 900, 0, 1]])
    >>> data = MeasuredPoints(loads, np.array([0.08, 0.07]), ["a", "b"], np.array([0, 1]), lambda *args: [])
    >>> tangent = ConstantFriction().tangent(data)
    >>> tangent.columns.tolist(), tangent.offset.tolist()
    ([[1.0], [1.0]], [0.0, 0.0])
    """

    #: Terms whose coefficients are fitted together with effects; shape (n, p).
    columns: FloatArray
    #: Part of mu that stays; shape (n,).
    offset: FloatArray
    #: Whether the model is taken as it is; its column then is a shift that stands for what the model lacks.
    fixed: bool = False
    #: Effects that the model holds already.
    effects: tuple[str, ...] = ()
    #: What the model could do as well.
    beside: tuple[Beside, ...] = ()


def varying_loads(loads: TriboLoads) -> FloatArray:
    """Return the loads that vary, centred and scaled to unit spread, shape (n, k).

    Examples
    --------
    >>> varying_loads(TriboLoads.from_array([[50, 20, 500, 0, 1], [50, 20, 700, 0, 1]])).tolist()
    [[-1.0], [1.0]]
    """
    array = loads.as_array()
    varies = [_varies(column) for column in array.T]
    chosen = array[:, varies]
    if not any(varies):
        return chosen
    return (chosen - chosen.mean(axis=0)) / chosen.std(axis=0)


def _varies(column: FloatArray) -> bool:
    return bool(np.ptp(column) > 1e-9 * max(1.0, float(np.max(np.abs(column)))))


def bends(loads: TriboLoads) -> tuple[Beside, ...]:
    """Return the squares of the loads that vary, and their products.

    Examples
    --------
    >>> [b.name for b in bends(TriboLoads.from_array([[50, 20, 500, 0, 1], [50, 30, 700, 0, 1]]))]
    ['a bend along T', 'the product of T and sigma_n', 'a bend along sigma_n']
    """
    varied = varying_loads(loads)
    names = [n for n, c in zip(LOAD_NAMES, loads.as_array().T, strict=True) if _varies(c)]
    pairs = combinations_with_replacement(zip(names, varied.T, strict=True), 2)
    return tuple(
        Beside(f"a bend along {a}" if a == b else f"the product of {a} and {b}", x * y, (a, b))
        for (a, x), (b, y) in pairs
    )


def polynomial_columns(loads: TriboLoads, degree: int) -> FloatArray:
    """Return all products of the scaled loads up to `degree`, shape (n, terms), constant first."""
    z = varying_loads(loads)
    columns = [np.ones(len(z))]
    for d in range(1, degree + 1):
        columns += [
            np.prod(z[:, list(c)], axis=1) for c in combinations_with_replacement(range(z.shape[1]), d)
        ]
    return np.column_stack(columns)


def out_of_fold(model: Any, data: MeasuredPoints) -> FloatArray:
    """Return predictions for each test by copies of the model that never saw that test, shape (n,).

    A single test is predicted by a model of the same test: there is nothing else to learn from.
    """
    from sklearn.base import clone

    tests = len(data.tests)
    names = np.array(data.tests)[data.point_test]
    if tests < 2:
        return np.asarray(clone(model).fit(data.loads, data.mu).predict(data.loads))
    folds = min(FOLDS, tests)
    fold_of_test = np.random.default_rng(data.seed).permutation(tests) % folds
    predicted = np.empty(len(data.mu))
    for fold in range(folds):
        held = fold_of_test[data.point_test] == fold
        copy = clone(model).fit(data.loads.take(~held), data.mu[~held], groups=names[~held])
        predicted[held] = copy.predict(data.loads.take(held))
    return predicted
