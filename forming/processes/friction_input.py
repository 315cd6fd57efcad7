"""Friction of a process: a number, or a function of the loads at the markers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError
from friction_models.loads import MU

from ..fe.mesh.shape import FloatArray

#: ``mu = friction(loads, t)`` with loads of shape (n, 5) in the order of the contract and t in s.
FrictionLaw = Callable[[FloatArray, float], npt.ArrayLike]
Friction = float | FrictionLaw
#: So large a coefficient that friction is limited by the shear yield stress alone: tau = m k.
CONSTANT_SHEAR = MU.upper


def checked_mu(mu: npt.ArrayLike, n: int, stroke: float) -> FloatArray:
    """Return friction coefficients of shape (n,), checked.

    Raises InputError: not numbers, wrong shape, NaN, infinite, negative or above the physical limit.

    Examples
    --------
    >>> checked_mu(0.08, n=3, stroke=0.0).tolist()
    [0.08, 0.08, 0.08]
    >>> checked_mu([0.08, -0.1], n=2, stroke=1.5)
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: friction: mu = -0.1 at marker 1 and stroke 1.500 mm; allowed: finite, 0 to 10
    """
    try:
        given = np.asarray(mu)
        if given.dtype.kind not in "iuf":
            raise ValueError
    except (TypeError, ValueError):
        raise InputError(
            f"friction: mu = {mu!r:.60} at stroke {stroke:.3f} mm; allowed: a number from {MU.lower:g} to "
            f"{MU.upper:g}, or {n} of them, one a marker"
        ) from None
    array = given.astype(np.float64)
    if array.ndim == 0:
        array = np.full(n, float(array))
    array = array.reshape(-1) if array.shape == (n, 1) else array
    if array.shape != (n,):
        raise InputError(f"friction: mu has shape {array.shape}, allowed: ({n},), one value a marker")
    good = np.isfinite(array) & (array >= MU.lower) & (array <= MU.upper)
    if not good.all():
        i = int(np.argmin(good))
        raise InputError(
            f"friction: mu = {float(array[i])!r} at marker {i} and stroke {stroke:.3f} mm; "
            f"allowed: finite, {MU.lower:g} to {MU.upper:g}"
        )
    return array


def start_mu(friction: Friction, n: int, T: float) -> FloatArray:
    """Return the friction coefficients before any contact: the law at zero loads and psi = 1.

    Examples
    --------
    A law of the loads is asked at no pressure and no sliding, at the temperature of the billet:

    >>> start_mu(lambda loads, t: 0.05 + 0.001 * loads[:, 1], n=2, T=20.0).round(6).tolist()
    [0.07, 0.07]
    """
    if callable(friction):
        return checked_mu(friction(np.tile([0.0, T, 0.0, 0.0, 1.0], (n, 1)), 0.0), n, 0.0)
    return checked_mu(friction, n, 0.0)
