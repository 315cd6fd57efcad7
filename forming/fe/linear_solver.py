"""Linear equations of Newton's method: a symmetric band, and what Coulomb friction adds to it at the nodes of the contact."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numba import njit
from scipy.linalg.lapack import dgbtrf, dgbtrs

from .mesh.shape import FloatArray, IntArray, half_bandwidth, last_rows

#: The iteration ends when what is left is this share of the right-hand side, or after so many rounds.
ACCURACY, ROUNDS = 5e-2, 10
#: So many columns of a factor are eliminated at once, and so many are used at once for a solution.
AT_ONCE, USED_AT_ONCE = 8, 4


@njit(cache=True)
def clear_band(band: FloatArray, last: IntArray) -> None:
    """Set to zero what a matrix and its factor can fill, a third of the band; the rest of it stays zero."""
    n = band.shape[0]
    for i in range(n):
        end = last[min(i - i % AT_ONCE + AT_ONCE, n) - 1]
        band[i, : end - i + 1] = 0.0


@njit(cache=True, fastmath={"contract"}, error_model="numpy")
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
                share = own[p - q]
                for k in range(end - j - p + 1):
                    target[k] -= share * own[p - q + k]
        if columns < AT_ONCE:
            break
        a, b, c, d = band[j], band[j + 1], band[j + 2], band[j + 3]
        e, f, g, h = band[j + 4], band[j + 5], band[j + 6], band[j + 7]
        for i in range(j + AT_ONCE, end + 1):
            s = i - j
            target = band[i]
            a_i, b_i, c_i, d_i = a[s], b[s - 1], c[s - 2], d[s - 3]
            e_i, f_i, g_i, h_i = e[s - 4], f[s - 5], g[s - 6], h[s - 7]
            from_a, from_b, from_c, from_d = a[s:], b[s - 1 :], c[s - 2 :], d[s - 3 :]
            from_e, from_f, from_g, from_h = e[s - 4 :], f[s - 5 :], g[s - 6 :], h[s - 7 :]
            for k in range(end - i + 1):
                first = a_i * from_a[k] + b_i * from_b[k] + c_i * from_c[k] + d_i * from_d[k]
                second = e_i * from_e[k] + f_i * from_f[k] + g_i * from_g[k] + h_i * from_h[k]
                target[k] -= first + second
    return True


@njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def solve_band(band: FloatArray, last: IntArray, x: FloatArray) -> None:
    """Overwrite the right-hand side `x` with the solution, with the factor that `factorise_band` leaves in `band`."""
    n = band.shape[0]
    whole = n - n % USED_AT_ONCE
    for j in range(0, whole, USED_AT_ONCE):
        a, b, c, d = band[j], band[j + 1], band[j + 2], band[j + 3]
        x0 = x[j] / a[0]
        x1 = (x[j + 1] - a[1] * x0) / b[0]
        x2 = (x[j + 2] - a[2] * x0 - b[1] * x1) / c[0]
        x3 = (x[j + 3] - a[3] * x0 - b[2] * x1 - c[1] * x2) / d[0]
        x[j], x[j + 1], x[j + 2], x[j + 3] = x0, x1, x2, x3
        below, from_a, from_b, from_c, from_d = x[j + 4 :], a[4:], b[3:], c[2:], d[1:]
        for k in range(last[j + 3] - j - 3):
            below[k] -= from_a[k] * x0 + from_b[k] * x1 + from_c[k] * x2 + from_d[k] * x3
    for j in range(whole, n):
        x[j] /= band[j, 0]
        for k in range(j + 1, n):
            x[k] -= band[j, k - j] * x[j]
    for j in range(n - 1, whole - 1, -1):
        for k in range(j + 1, n):
            x[j] -= band[j, k - j] * x[k]
        x[j] /= band[j, 0]
    for j in range(whole - USED_AT_ONCE, -1, -USED_AT_ONCE):
        a, b, c, d = band[j], band[j + 1], band[j + 2], band[j + 3]
        below, from_a, from_b, from_c, from_d = x[j + 4 :], a[4:], b[3:], c[2:], d[1:]
        s0 = s1 = s2 = s3 = 0.0
        for k in range(last[j + 3] - j - 3):
            s0 += from_a[k] * below[k]
            s1 += from_b[k] * below[k]
            s2 += from_c[k] * below[k]
            s3 += from_d[k] * below[k]
        x3 = (x[j + 3] - s3) / d[0]
        x2 = (x[j + 2] - s2 - c[1] * x3) / c[0]
        x1 = (x[j + 1] - s1 - b[1] * x2 - b[2] * x3) / b[0]
        x0 = (x[j] - s0 - a[1] * x1 - a[2] * x2 - a[3] * x3) / a[0]
        x[j], x[j + 1], x[j + 2], x[j + 3] = x0, x1, x2, x3


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
        self.last = last_rows(quads, n, 2)
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
        clear_band(self.band, self.last)
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
        tried: list[tuple[FloatArray, FloatArray]] = []
        enough = ACCURACY * ACCURACY * float(right @ right)
        for _ in range(ROUNDS):
            step = left.copy()
            solve_band(self.band, self.last, step)
            # The symmetric part times the step is `left` again.
            image = left.copy()
            image[::2] += self.skew * step[1::2]
            image[1::2] -= self.skew * step[::2]
            for other, its_image in tried:
                along = float(its_image @ image) / float(its_image @ its_image)
                image -= along * its_image
                step -= along * other
            length = float(image @ image)
            if not length > 0.0:
                break
            tried.append((step, image))
            share = float(image @ left) / length
            solution += share * step
            left -= share * image
            if float(left @ left) <= enough:
                return solution
        if self._factorise_whole():
            return self.solve(right)
        return solution
