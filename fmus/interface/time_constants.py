"""Fastest time constant of a model's memory, which a solver in model exchange must resolve."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable

import numpy as np

from friction_models.expressions.onnx_session import onnx_session
from friction_models.loads import LOADS, FloatArray

from .friction_source import FrictionSource
from .quantities import USUAL

#: Random points of the trained domain, besides its corners, and seconds of contact after which the rates are looked at.
_POINTS, _AGES = 200, (0.0, 0.01, 0.1, 1.0)
#: Slower memory than this [s] asks nothing of a solver; numerical differences end there, too.
_SLOW = 1e3


def fastest_time_constant(source: FrictionSource) -> float | None:
    """Return the fastest time constant of the memory inside the trained domain [s].

    The memory obeys d(state)/dt = rate(state, loads); the time constant is that of the fastest decay of a small
    difference in the states, over points of the trained domain and states that they lead to. None without memory, where it is
    no differential equation, and where nothing decays within `_SLOW` seconds.
    """
    if not source.states or not source.onnx:
        return None
    box = tuple(source.domain.get(q.name, USUAL[q.name]) for q in LOADS)
    starts = tuple(s.start for s in source.states), tuple(p.start for p in source.system)
    return _fastest(source.onnx, box, *starts)


def hint(fastest: float) -> str:
    """Return what a time constant asks of the solver in model exchange, one sentence.

    Examples
    --------
    >>> print(hint(0.01))
    inside the trained domain the memory has time constants down to about 0.01 s: explicit solvers diverge with steps above about 0.02 s, implicit ones (BDF) do not
    """
    return (
        f"inside the trained domain the memory has time constants down to about {fastest:.2g} s: explicit solvers diverge "
        f"with steps above about {2.0 * fastest:.2g} s, implicit ones (BDF) do not"
    )


@functools.lru_cache(maxsize=8)  # description and documentation ask for it
def _fastest(
    onnx: bytes, box: tuple[tuple[float, float], ...], start: tuple[float, ...], system: tuple[float, ...]
) -> float | None:
    try:
        session = onnx_session(onnx)
        inputs = {i.name for i in session.get_inputs()}
        if "state_der" not in {o.name for o in session.get_outputs()}:
            return None
        loads = _loads(box)

        def run(name: str, state: FloatArray, step: float) -> FloatArray:
            feed = {"loads": loads, "state": state, "dt": np.array([step]), "system": np.array([system])}
            found = session.run([name], {k: v for k, v in feed.items() if k in inputs})[0]
            return np.asarray(found, dtype=float)

        fastest = 0.0
        state = np.tile(start, (len(loads), 1))
        for age, before in zip(_AGES, (0.0, *_AGES)):
            if age > before:
                state = run("state_next", state, age - before)
            fastest = max(fastest, _fastest_decay(lambda s: run("state_der", s, 0.0), state))
    except Exception:  # ONNX Runtime has errors of its own; packing tells them where it needs the graph
        return None
    return 1.0 / fastest if fastest > 1.0 / _SLOW else None


def _fastest_decay(rates: Callable[[FloatArray], FloatArray], state: FloatArray) -> float:
    """Return the largest rate of decay [1/s] over the points, by central differences of the rates."""
    count = state.shape[1]
    jacobian = np.empty((len(state), count, count))
    for j in range(count):
        h = np.zeros_like(state)
        h[:, j] = 1e-6 * np.maximum(np.abs(state[:, j]), 1e-3)
        jacobian[:, :, j] = (rates(state + h) - rates(state - h)) / (2.0 * h[:, j : j + 1])
    known = jacobian[np.isfinite(jacobian).all(axis=(1, 2))]
    return float(-np.linalg.eigvals(known).real.min(initial=0.0))


def _loads(box: tuple[tuple[float, float], ...]) -> FloatArray:
    """Return the corners of a domain and random points in between, shape (n, 5)."""
    lower, upper = np.array(box).T
    corners = np.array(list(itertools.product(*box)))
    points = np.random.default_rng(9).uniform(lower, upper, size=(_POINTS, len(LOADS)))
    return np.vstack([corners, points])
