"""The scan against least squares by other routines, and against a column whose share is planted."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from friction_models.estimation.search.scan import FAULT_PENALTY, Projector, best_fit, prepare_candidate, rank

from .estimation_cases import candidate

M = 200


def plain(values: np.ndarray) -> np.ndarray:
    return values


def test_effects_are_ranked_by_the_share_that_they_explain() -> None:
    rng = np.random.default_rng(0)
    base = np.column_stack([np.ones(M), rng.normal(size=M)])
    q = np.linalg.qr(np.column_stack([base, rng.normal(size=(M, 4))]))[0][
        :, 2:
    ]  # orthonormal, beside the base
    strength = {"weak": 3.0, "strong": 12.0, "none": 0.0, "middle": -7.0}
    residual = sum(a * q[:, k] for k, a in enumerate(strength.values()))
    candidates = [candidate(n, 5.0 * q[:, [k], None]) for k, n in enumerate(strength)]
    found = rank([prepare_candidate(c, plain, Projector(base)) for c in candidates], residual)
    assert [f.name for f in found] == ["strong", "middle", "weak", "none"]
    for fit in found:
        a = strength[fit.name]
        assert fit.gain == pytest.approx(a**2 - 2.0, abs=1e-9)  # two per degree of freedom
        assert fit.amplitudes[0] == pytest.approx(a / 5.0, abs=1e-9)


@pytest.mark.parametrize("signs", [(0,), (1,), (-1,), (0, 0), (1, 1), (1, -1)])
def test_the_gain_is_the_drop_of_constrained_least_squares(signs: tuple[int, ...]) -> None:
    rng = np.random.default_rng(len(signs))
    base = np.column_stack([np.ones(M), rng.normal(size=(M, 2))])
    for _ in range(10):
        columns = rng.normal(size=(M, 3, len(signs)))
        y = rng.normal(size=M) + columns[:, 1] @ rng.normal(0.0, 0.2, size=len(signs))
        project = Projector(base)
        fit = best_fit(prepare_candidate(candidate("a", columns, signs), plain, project), project(y))
        before = lsq_linear(base, y).cost
        low = np.r_[np.full(3, -np.inf), [0.0 if s > 0 else -np.inf for s in signs]]
        high = np.r_[np.full(3, np.inf), [0.0 if s < 0 else np.inf for s in signs]]
        costs = [
            lsq_linear(np.column_stack([base, columns[:, k]]), y, (low, high), tol=1e-14).cost
            for k in range(3)
        ]
        assert fit.gain == pytest.approx(2.0 * (before - min(costs)) - 2.0 * len(signs), abs=1e-4)
        if before - min(costs) > 1e-3:
            assert fit.index == int(np.argmin(costs)) and fit.shape == {"s": float(fit.index)}


def test_what_the_base_can_follow_is_not_seen() -> None:
    rng = np.random.default_rng(2)
    base = np.column_stack([np.ones(M), rng.normal(size=M)])
    nearly = base[:, 1] + 0.005 * rng.normal(size=M)  # 2.5e-5 of its variation beside the base
    prepared = prepare_candidate(candidate("twin of the base", nearly[:, None, None]), plain, Projector(base))
    assert not prepared.usable.any()
    assert best_fit(prepared, rng.normal(size=M)).gain == -2.0


def test_a_fault_has_to_beat_physics_by_its_penalty() -> None:
    column = np.random.default_rng(3).normal(size=(M, 1, 1))
    gains = [
        best_fit(
            prepare_candidate(candidate("a", column, kind=kind), plain, Projector(np.ones((M, 1)))),
            column[:, 0, 0],
        ).gain
        for kind in ("physics", "fault")
    ]
    assert gains[0] - gains[1] == pytest.approx(FAULT_PENALTY)
