"""Equations of Newton's method against dense algebra, on a mesh whose band is narrow in one place and wide in another."""

from __future__ import annotations

import numpy as np
import pytest

from forming.fe import linear_solver
from forming.fe.linear_solver import LinearSolver
from forming.fe.mesh.mesher import quad_mesh
from forming.fe.mesh.polyline import spaced


def equations(symmetric_part: float, skew_part: float):
    """Return a solver with a random matrix over a graded mesh, and this matrix, dense."""

    def size(points):
        return 0.15 + 0.4 * np.abs(points[:, 0] - 1.0)

    corners = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 1.0), (0.0, 1.0), (0.0, 0.0)])
    sides = [corners[k : k + 2] for k in range(4)]
    loop = np.concatenate(
        [a + np.outer(spaced(np.array([a, b]), size)[:-1] / np.hypot(*(b - a)), b - a) for a, b in sides]
    )
    mesh = quad_mesh(loop, size)
    n = len(mesh.x)
    rng = np.random.default_rng(7)
    dense = np.zeros((2 * n, 2 * n))
    for quad in mesh.quads:
        unknowns = np.concatenate([2 * quad, 2 * quad + 1])
        half = rng.normal(size=(8, 8))
        dense[np.ix_(unknowns, unknowns)] += half @ half.T
    dense += symmetric_part * np.eye(2 * n)
    skew = skew_part * rng.normal(size=n)
    solver = LinearSolver(mesh.quads, n)

    def fill(band, into):
        for k in range(solver.half + 1):
            band[: 2 * n - k, k] += np.diagonal(dense, -k)
        into += skew

    assert solver.factorise(fill)
    whole = dense.copy()
    whole[np.arange(0, 2 * n, 2), np.arange(1, 2 * n, 2)] += skew
    whole[np.arange(1, 2 * n, 2), np.arange(0, 2 * n, 2)] -= skew
    return solver, whole, rng.normal(size=2 * n)


@pytest.mark.parametrize(("symmetric_part", "skew_part"), [(1.0, 0.0), (1.0, 0.3), (-4.0, 0.3)])
def test_the_solution_is_that_of_the_dense_matrix(symmetric_part, skew_part, monkeypatch):
    """Positive definite; with friction; and not positive definite, where the whole is factorised."""
    monkeypatch.setattr(linear_solver, "ACCURACY", 1e-12)
    solver, whole, right = equations(symmetric_part, skew_part)
    expected = np.linalg.solve(whole, right)
    assert solver.solve(right) == pytest.approx(expected, rel=1e-6, abs=1e-8 * np.abs(expected).max())


def test_a_band_worked_on_too_narrowly_is_found():
    solver, whole, right = equations(1.0, 0.0)
    solver.last[:] = np.maximum(solver.last - 2, np.arange(len(solver.last)))
    solver.factorise(solver._fill)
    assert np.abs(whole @ solver.solve(right) - right).max() > 1e-3
