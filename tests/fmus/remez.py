"""The polynomials of lanes_math.h, computed anew: best approximations in the largest error (Remez algorithm)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath as mp

Number = Any
_DIGITS = 50
_GRID = 400


def exponential() -> list[float]:
    """Return the coefficients, from the constant up, of P in exp(r) = 1 + r + r^2 P(r), |r| <= ln(2)/2."""

    def remainder(r: Number) -> Number:
        return mp.mpf(1) / 2 + r / 6 if abs(r) < mp.mpf(10) ** -12 else (mp.exp(r) - 1 - r) / r**2

    with mp.workdps(_DIGITS):
        edge = mp.log(2) / 2 * mp.mpf("1.0001")
        return best_polynomial(remainder, -edge, edge, 10)


def logarithm() -> list[float]:
    """Return the coefficients of R in log(1 + f) = 2 s + s z R(z), z = s^2, s = f/(2 + f)."""

    def remainder(z: Number) -> Number:
        s = mp.sqrt(z)
        return mp.mpf(2) / 3 if z < mp.mpf(10) ** -20 else (mp.log((1 + s) / (1 - s)) - 2 * s) / (s * z)

    with mp.workdps(_DIGITS):
        edge = (mp.sqrt(2) - 1) / (mp.sqrt(2) + 1)  # of s, at f = sqrt(2) - 1
        return best_polynomial(remainder, mp.mpf(0), edge**2 * mp.mpf("1.0001"), 6)


def best_polynomial(f: Callable[[Number], Number], low: Number, high: Number, degree: int) -> list[float]:
    """Return the coefficients of the polynomial whose largest error on an interval is smallest.

    The error of the best one reaches its largest size with alternating sign at ``degree + 2`` points; the
    exchange of points starts at those of Chebyshev.
    """
    count = degree + 2
    middle, half = (low + high) / 2, (high - low) / 2
    points = [middle - half * mp.cos(mp.pi * i / (count - 1)) for i in range(count)]
    coefficients: list[Number] = []
    for _ in range(6):
        system, values = mp.matrix(count, count), mp.matrix(count, 1)
        for i, x in enumerate(points):
            for j in range(degree + 1):
                system[i, j] = x**j
            system[i, degree + 1] = (-1) ** i
            values[i] = f(x)
        solution = mp.lu_solve(system, values)
        coefficients = [solution[j] for j in range(degree + 1)]
        grid = [low + (high - low) * i / mp.mpf(_GRID) for i in range(_GRID + 1)]
        errors = [f(x) - mp.polyval(coefficients[::-1], x) for x in grid]
        points = _extremes(grid, errors)
        if len(points) != count:
            break
    return [float(c) for c in coefficients]


def _extremes(grid: list[Number], errors: list[Number]) -> list[Number]:
    """Return the place of the largest error of every stretch of equal sign."""
    places: list[int] = []
    for i, error in enumerate(errors):
        if places and errors[places[-1]] * error > 0:
            if abs(error) > abs(errors[places[-1]]):
                places[-1] = i
        else:
            places.append(i)
    return [grid[i] for i in places]
