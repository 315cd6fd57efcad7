"""Flow stress with its slopes, for the material vector that `forming.materials.materials` writes.

Entries: 0-5 numbers of the law, 6 shear modulus, 7 bulk modulus, 8 strain floor, 9 rate floor, 10 law. The vector
of the common law has shape (10,), that of the others shape (1, n): numba compiles the kernels for each, so
that the common law does not pay for the choice.

====  =================================================================================================
law   entries
====  =================================================================================================
-     Hensel-Spittel: 0 A, 1 m1, 2 m2, 3 m3, 4 coefficient of 1/strain, 5 temperature slope of the rate
      exponent
1     the same, and 11 m5, 12 m7, 13 m9, 14 and 15 temperature slopes of the strain exponent and of the
      coefficient of 1/strain
2     power law: 0 yield stress, 1 K, 2 strain exponent, 3 prestrain, 4 rate exponent, 5 reference rate
3     table: 11, 12, 13 numbers of strains, rates, temperatures; then the axes (natural logarithm of the
      rates); then ln of the stress, [temperature, rate, strain]; then its slopes by strain
====  =================================================================================================
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .mesh.shape import FloatArray

EXTENDED, POWER, TABLE = 1.0, 2.0, 3.0
#: Where the axes of a table begin in the material vector.
AXES = 14


@njit(cache=True)
def flow_stress(strain: float, rate: float, T: float, m: FloatArray) -> tuple[float, float, float]:
    """Return the flow stress and its derivatives by strain and by strain rate."""
    if m.ndim == 2:
        return _other_laws(strain, rate, T, m[0])
    # Divisions and roots cost as much as all the rest.
    square = strain * strain + m[8] * m[8]
    rate_square = rate * rate + m[9] * m[9]
    half = 0.5 * (m[3] + m[5] * T)
    over_e = 1.0 / np.sqrt(square)
    y = m[0] * np.exp(m[1] * T + m[4] * over_e + 0.5 * m[2] * np.log(square) + half * np.log(rate_square))
    by_strain = y * (m[2] - m[4] * over_e) * strain * (over_e * over_e)
    return y, by_strain, 2.0 * y * half * rate / rate_square


@njit(cache=True)
def elastic_moduli(m: FloatArray) -> tuple[float, float]:
    """Return shear and bulk modulus."""
    if m.ndim == 2:
        return m[0, 6], m[0, 7]
    return m[6], m[7]


@njit(cache=True)
def _other_laws(strain: float, rate: float, T: float, m: FloatArray) -> tuple[float, float, float]:
    if m[10] == TABLE:
        return _table(strain, rate, T, m)
    e = np.sqrt(strain * strain + m[8] * m[8])
    r = np.sqrt(rate * rate + m[9] * m[9])
    if m[10] == POWER:
        root = m[1] * (m[3] + e) ** m[2]
        factor = (r / m[5]) ** m[4]
        y = factor * (m[0] + root)
        return y, factor * root * m[2] / (m[3] + e) * strain / e, y * m[4] * rate / (r * r)
    exponent = m[3] + m[5] * T
    power = m[2] + m[14] * T
    inverse = m[4] + m[15] * T
    y = m[0] * np.exp(
        m[1] * T
        + m[13] * np.log(max(T, 1.0))
        + inverse / e
        + power * np.log(e)
        + m[11] * T * np.log(1.0 + e)
        + m[12] * e
        + exponent * np.log(r)
    )
    slope = power / e - inverse / (e * e) + m[11] * T / (1.0 + e) + m[12]
    return y, y * slope * strain / e, y * exponent * rate / (r * r)


@njit(cache=True)
def _place(value: float, m: FloatArray, start: int, n: int) -> tuple[int, float]:
    """Return the interval of an axis that holds a value and the share of it; outside, the nearest end."""
    if n == 1 or value <= m[start]:
        return 0, 0.0
    if value >= m[start + n - 1]:
        return n - 2, 1.0
    low = 0
    high = n - 1
    while high - low > 1:
        middle = (low + high) // 2
        if m[start + middle] <= value:
            low = middle
        else:
            high = middle
    return low, (value - m[start + low]) / (m[start + low + 1] - m[start + low])


@njit(cache=True)
def _table(strain: float, rate: float, T: float, m: FloatArray) -> tuple[float, float, float]:
    """Interpolate ln of the stress: monotone cubic in strain, linear in ln(rate) and in temperature."""
    n_e = int(m[11])
    n_r = int(m[12])
    n_T = int(m[13])
    rates = AXES + n_e
    temperatures = rates + n_r
    values = temperatures + n_T
    slopes = values + n_T * n_r * n_e
    log_rate = np.log(rate) if rate > 0.0 else -1e300
    i, u = _place(strain, m, AXES, n_e)
    j, v = _place(log_rate, m, rates, n_r)
    k, w = _place(T, m, temperatures, n_T)
    h = m[AXES + i + 1] - m[AXES + i] if n_e > 1 else 1.0
    inside = n_e > 1 and strain > m[AXES] and strain < m[AXES + n_e - 1]
    ln_y = 0.0
    by_strain = 0.0
    by_log_rate = 0.0
    for c in range(2):
        if c == 1 and w == 0.0:
            continue
        share_T = w if c == 1 else 1.0 - w
        first = 0.0
        for b in range(2):
            if b == 1 and n_r == 1:
                continue
            at = ((k + c) * n_r + j + b) * n_e + i
            value = m[values + at]
            slope = 0.0
            if n_e > 1:
                f0 = value
                f1 = m[values + at + 1]
                d0 = h * m[slopes + at]
                d1 = h * m[slopes + at + 1]
                c2 = 3.0 * (f1 - f0) - 2.0 * d0 - d1
                c3 = d0 + d1 - 2.0 * (f1 - f0)
                value = f0 + u * (d0 + u * (c2 + u * c3))
                if inside:
                    slope = (d0 + u * (2.0 * c2 + u * 3.0 * c3)) / h
            share = share_T * (v if b == 1 else 1.0 - v)
            ln_y += share * value
            by_strain += share * slope
            if b == 0:
                first = value
            elif log_rate > m[rates] and log_rate < m[rates + n_r - 1]:
                by_log_rate += share_T * (value - first) / (m[rates + j + 1] - m[rates + j])
    y = np.exp(ln_y)
    by_rate = y * by_log_rate / rate if rate > 0.0 else 0.0
    return y, y * by_strain, by_rate


@njit(cache=True)
def flow_stresses(strain: FloatArray, rate: FloatArray, T: FloatArray, m: FloatArray) -> FloatArray:
    """Return the flow stress for arrays of one length."""
    y = np.empty(strain.shape[0])
    for n in range(strain.shape[0]):
        y[n] = flow_stress(strain[n], rate[n], T[n], m)[0]
    return y
