"""Linear equations of Newton's method: a symmetric band, and what Coulomb friction adds to it at the nodes of the contact."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.linalg.lapack import dgbtrf, dgbtrs, dpbtrf, dpbtrs

from .mesh.shape import FloatArray

#: The iteration ends when what is left is this share of the right-hand side, or after so many rounds.
ACCURACY, ROUNDS = 5e-2, 10


class LinearSolver:
    """Equations of `n` nodes with two unknowns each, whose matrix is symmetric but for skew 2 x 2 blocks of single nodes.

    Where the friction stress follows the pressure, it makes such blocks. The symmetric part is factorised after Cholesky, in
    half of the memory and half to a third of the time of an unsymmetric matrix; the skew part, smaller by the coefficient of
    friction, is left to an iteration of a few rounds (generalised conjugate residuals: Eisenstat, Elman and Schultz, SIAM J.
    Numer. Anal. 20, 1983). Where the symmetric part is not positive definite, or holds the body too weakly for the iteration,
    the whole is factorised.
    """

    def __init__(self, n: int, half: int) -> None:
        self.half = half
        #: Lower triangle, entry (i, j) at ``band[j, i - j]``, shape (2 n, half + 1); its factor after `factorise`.
        self.band = np.zeros((2 * n, half + 1))
        #: Entry (r, z) of the skew block of each node, shape (n,).
        self.skew = np.zeros(n)
        self._whole: tuple[FloatArray, np.ndarray] | None = None
        self._fill: Callable[[FloatArray, FloatArray], None]

    def factorise(self, fill: Callable[[FloatArray, FloatArray], None]) -> bool:
        """Factorise the matrix that `fill` adds to zeros in `band` and `skew`; False: it is singular."""
        self._whole, self._fill = None, fill
        self._clear()
        fill(self.band, self.skew)
        return dpbtrf(self.band.T, lower=1, overwrite_ab=1)[1] == 0 or self._factorise_whole()

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
        whole[:, 2 * b :] = self.band
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
