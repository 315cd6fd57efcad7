"""Linear equations of Newton's method: a symmetric band, and what Coulomb friction adds to it at the nodes of the contact."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numba import njit
from scipy.linalg.lapack import dgbtrf, dgbtrs, dpbtrs

from .mesh.shape import FloatArray, IntArray, half_bandwidth

#: The iteration ends when what is left is this share of the right-hand side, or after so many rounds.
ACCURACY, ROUNDS = 5e-2, 10


#: So many columns of a factor are eliminated at once.
AT_ONCE = 4


@njit(cache=True)
def last_rows(quads: IntArray, n_nodes: int) -> IntArray:
    """Return for each column of a matrix over the mesh the last row in which it or one before it has an entry, shape (2 n,)."""
    last = np.zeros(2 * n_nodes, np.int64)
    for e in range(quads.shape[0]):
        nodes = quads[e]
        low = 2 * min(nodes[0], nodes[1], nodes[2], nodes[3])
        last[low] = max(last[low], 2 * max(nodes[0], nodes[1], nodes[2], nodes[3]) + 1)
    for i in range(1, 2 * n_nodes):
        last[i] = max(last[i], last[i - 1])
    return last


@njit(cache=True)
def factorise_band(band: FloatArray, last: IntArray) -> bool:
    """Factorise a symmetric band after Cholesky, as LAPACK's `dpbtrf` does; False: it is not positive definite.

    A mesh that is fine in one place has a wide band there and a narrow one elsewhere: only what lies above `last` is worked
    on, a third of the band.

    - `band`, shape (n, b + `AT_ONCE`): lower triangle, entry (i, j) at ``band[j, i - j]``; overwritten by its factor.
    """
    n = band.shape[0]
    for j in range(0, n, AT_ONCE):
        columns = min(AT_ONCE, n - j)
        end = last[j + columns - 1]
        for q in range(columns):
            own = band[j + q]
            if not own[0] > 0.0:
                return False
            own[0] = np.sqrt(own[0])
            for k in range(1, end - j - q + 1):
                own[k] /= own[0]
            for p in range(q + 1, columns):
                target = band[j + p]
                for k in range(end - j - p + 1):
                    target[k] -= own[p - q] * own[p - q + k]
        if columns < AT_ONCE:
            break
        a, b, c, d = band[j], band[j + 1], band[j + 2], band[j + 3]
        for i in range(j + AT_ONCE, end + 1):
            s = i - j
            target = band[i]
            a_i, b_i, c_i, d_i = a[s], b[s - 1], c[s - 2], d[s - 3]
            from_a, from_b, from_c, from_d = a[s:], b[s - 1 :], c[s - 2 :], d[s - 3 :]
            for k in range(end - i + 1):
                target[k] -= a_i * from_a[k] + b_i * from_b[k] + c_i * from_c[k] + d_i * from_d[k]
    return True


class LinearSolver:
    """Equations of a mesh of `n` nodes with two unknowns each, whose matrix is symmetric but for skew 2 x 2 blocks of single nodes.

    Where the friction stress follows the pressure, it makes such blocks. The symmetric part is factorised after Cholesky, in
    half of the memory and half to a third of the time of an unsymmetric matrix; the skew part, smaller by the coefficient of
    friction, is left to an iteration of a few rounds (generalised conjugate residuals: Eisenstat, Elman and Schultz, SIAM J.
    Numer. Anal. 20, 1983). Where the symmetric part is not positive definite, or holds the body too weakly for the iteration,
    the whole is factorised.
    """

    def __init__(self, quads: IntArray, n: int) -> None:
        self.half = 2 * half_bandwidth(quads) + 1
        self.last = last_rows(quads, n)
        #: Lower triangle, entry (i, j) at ``band[j, i - j]``, shape (2 n, half + AT_ONCE); its factor after `factorise`.
        self.band = np.zeros((2 * n, self.half + AT_ONCE))
        #: Entry (r, z) of the skew block of each node, shape (n,).
        self.skew = np.zeros(n)
        self._whole: tuple[FloatArray, np.ndarray] | None = None
        self._fill: Callable[[FloatArray, FloatArray], None]

    def factorise(self, fill: Callable[[FloatArray, FloatArray], None]) -> bool:
        """Factorise the matrix that `fill` adds to zeros in `band` and `skew`; False: it is singular."""
        self._whole, self._fill = None, fill
        self._clear()
        fill(self.band, self.skew)
        return bool(factorise_band(self.band, self.last)) or self._factorise_whole()

    def _factorise_whole(self) -> bool:
        self._clear()
        self._fill(self.band, self.skew)
        factors, pivots, info = dgbtrf(self._unsymmetric(), self.half, self.half, overwrite_ab=1)
        self._whole = factors, pivots
        return bool(info == 0)

    def _clear(self) -> None:
        self.band[:] = 0.0
        self.skew[:] = 0.0

    def _unsymmetric(self) -> FloatArray:
        """Return the whole matrix in the band storage of LAPACK, with rows for fill-in."""
        n, b = self.band.shape[0], self.half
        whole = np.zeros((n, 3 * b + 1))
        whole[:, 2 * b :] = self.band[:, : b + 1]
        for k in range(1, b + 1):
            whole[k:, 2 * b - k] = self.band[: n - k, k]
        whole[::2, 2 * b + 1] -= self.skew
        whole[1::2, 2 * b - 1] += self.skew
        return whole.T

    def solve(self, right: FloatArray) -> FloatArray:
        """Return the solution for a right-hand side, shape (2 n,), with the factors of the last factorisation."""
        if self._whole is not None:
            return np.asarray(dgbtrs(self._whole[0], self.half, self.half, right, self._whole[1])[0])
        left, solution = right.copy(), np.zeros_like(right)
        tried, images = np.empty((2, ROUNDS, len(right)))
        enough = ACCURACY * float(np.sqrt(right @ right))
        for k in range(ROUNDS):
            step = dpbtrs(self.band.T, left, lower=1)[0]
            # The symmetric part times the step is `left` again.
            image = left.copy()
            image[::2] += self.skew * step[1::2]
            image[1::2] -= self.skew * step[::2]
            along = images[:k] @ image
            image -= along @ images[:k]
            step -= along @ tried[:k]
            length = float(np.sqrt(image @ image))
            if not length > 0.0:
                break
            images[k], tried[k] = image / length, step / length
            share = float(images[k] @ left)
            solution += share * tried[k]
            left -= share * images[k]
            if float(np.sqrt(left @ left)) <= enough:
                return solution
        if self._factorise_whole():
            return self.solve(right)
        return solution
