"""Axisymmetric elasto-viscoplastic element: mean dilatation, updated Lagrangian, consistent tangent.

The strain increment is taken at the midpoint configuration, the old stress is rotated after Hughes and
Winget (Int. J. Numer. Meth. Eng. 15, 1980), the return is radial (backward Euler), and the volumetric
part of B is averaged over the element (Nagtegaal, Parks and Rice, Comput. Meth. Appl. Mech. Eng. 4, 1974),
which keeps the element from locking in isochoric flow.

The material vector is described in `forming.fe.flow`.
Stress components: rr, zz, tt, rz.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .flow import elastic_moduli, flow_stress
from .mesh.shape import N_GAUSS, FloatArray, IntArray, gradients


@njit(cache=True)
def radial_return(q: float, strain: float, T: float, dt: float, m: FloatArray) -> tuple[float, float, float]:
    """Return plastic strain increment, flow stress and hardening slope for a trial equivalent stress `q`.

    Newton's method inside a bisection bracket: the law is steep near zero strain.
    """
    g3 = 3.0 * elastic_moduli(m)[0]
    y, _, _ = flow_stress(strain, 0.0, T, m)
    if q <= y:
        return 0.0, y, 0.0
    low = 0.0
    high = q / g3
    dp = max(0.95 * (q - y) / g3, 1e-12)
    slope = 0.0
    for _ in range(40):
        y, by_strain, by_rate = flow_stress(strain + dp, dp / dt, T, m)
        slope = by_strain + by_rate / dt
        excess = q - g3 * dp - y
        if excess > 0.0:
            low = dp
        else:
            high = dp
        if abs(excess) < 1e-8 * y:
            break
        trial = dp + excess / (g3 + slope)
        if trial <= low or trial >= high:
            trial = 0.5 * (low + high)
        dp = trial
    return dp, y, slope


@njit(cache=True)
def assemble(
    x0: FloatArray,
    du: FloatArray,
    quads: IntArray,
    stress0: FloatArray,
    strain0: FloatArray,
    T: FloatArray,
    dt: float,
    m: FloatArray,
    band: FloatArray,
    force: FloatArray,
    stress1: FloatArray,
    strain1: FloatArray,
    work: FloatArray,
) -> int:
    """Assemble internal forces and tangent for the displacement increment `du` from the configuration `x0`.

    - `band`, shape (n_dof, 3 b + 1): column-wise LAPACK band storage, added to: entry (i, j) stands at
      ``band[j, 2 b + i - j]``.
    - `force`, shape (n_dof,): internal nodal forces per radian, added to.
    - `stress1`, `strain1`, `work`, shape (n_e, 4, 4), (n_e, 4), (n_e, 4): written: stress and plastic strain
      at the end of the increment, and the plastic work in it [N/mm2], with the mean of the stresses at both
      ends.
    - returns: number of Gauss points with a non-positive Jacobian (the step is too large).
    """
    xm = np.empty((4, 2))
    x1 = np.empty((4, 2))
    ue = np.empty((4, 2))
    dn_mid = np.empty((4, 4, 2))
    dn_end = np.empty((4, 4, 2))
    r_mid = np.empty(4)
    r_end = np.empty(4)
    w_end = np.empty(4)
    b_bar = np.empty((4, 8))
    db = np.empty((4, 8))
    d = np.empty((4, 4))
    ke = np.empty((8, 8))
    fe = np.empty(8)
    b_volume = np.empty(8)
    n = np.empty(4)
    s = np.empty(4)
    old = np.empty(4)
    shear, bulk = elastic_moduli(m)
    diagonal = 2 * ((band.shape[1] - 1) // 3)
    inverted = 0
    for e in range(quads.shape[0]):
        for a in range(4):
            node = quads[e, a]
            for c in range(2):
                ue[a, c] = du[node, c]
                xm[a, c] = x0[node, c] + 0.5 * du[node, c]
                x1[a, c] = x0[node, c] + du[node, c]
        v_mid = 0.0
        v_end = 0.0
        dilatation = 0.0
        b_volume[:] = 0.0
        for g in range(4):
            w, r, det = gradients(xm, g, dn_mid[g])
            r_mid[g] = r
            v_mid += w
            for a in range(4):
                dilatation += w * (
                    (dn_mid[g, a, 0] + N_GAUSS[g, a] / r) * ue[a, 0] + dn_mid[g, a, 1] * ue[a, 1]
                )
            w, r, det = gradients(x1, g, dn_end[g])
            w_end[g] = w
            r_end[g] = r
            v_end += w
            if not det > 0.0:
                inverted += 1
            for a in range(4):
                b_volume[2 * a] += w * (dn_end[g, a, 0] + N_GAUSS[g, a] / r)
                b_volume[2 * a + 1] += w * dn_end[g, a, 1]
        dilatation /= v_mid
        for k in range(8):
            b_volume[k] /= v_end
        ke[:] = 0.0
        fe[:] = 0.0
        for g in range(4):
            e_rr = 0.0
            e_zz = 0.0
            e_tt = 0.0
            g_rz = 0.0
            spin = 0.0
            temperature = 0.0
            for a in range(4):
                e_rr += dn_mid[g, a, 0] * ue[a, 0]
                e_zz += dn_mid[g, a, 1] * ue[a, 1]
                e_tt += N_GAUSS[g, a] * ue[a, 0] / r_mid[g]
                g_rz += dn_mid[g, a, 1] * ue[a, 0] + dn_mid[g, a, 0] * ue[a, 1]
                spin += 0.5 * (dn_mid[g, a, 1] * ue[a, 0] - dn_mid[g, a, 0] * ue[a, 1])
                temperature += N_GAUSS[g, a] * T[quads[e, a]]
            mean = (e_rr + e_zz + e_tt) / 3.0
            half = 0.5 * spin
            cos = (1.0 - half * half) / (1.0 + half * half)
            sin = 2.0 * half / (1.0 + half * half)
            s_rr = stress0[e, g, 0]
            s_zz = stress0[e, g, 1]
            s_tt = stress0[e, g, 2]
            s_rz = stress0[e, g, 3]
            pressure = (s_rr + s_zz + s_tt) / 3.0
            shift = 2.0 * cos * sin * s_rz
            old[0] = cos * cos * s_rr + sin * sin * s_zz + shift - pressure
            old[1] = sin * sin * s_rr + cos * cos * s_zz - shift - pressure
            old[2] = s_tt - pressure
            old[3] = (cos * cos - sin * sin) * s_rz - cos * sin * (s_rr - s_zz)
            s[0] = old[0] + 2.0 * shear * (e_rr - mean)
            s[1] = old[1] + 2.0 * shear * (e_zz - mean)
            s[2] = old[2] + 2.0 * shear * (e_tt - mean)
            s[3] = old[3] + shear * g_rz
            pressure += bulk * dilatation
            q = np.sqrt(1.5 * (s[0] ** 2 + s[1] ** 2 + s[2] ** 2 + 2.0 * s[3] ** 2))
            dp, y, slope = radial_return(q, strain0[e, g], temperature, dt, m)
            a1 = 2.0 * shear
            a2 = 0.0
            work[e, g] = 0.0
            if dp > 0.0:
                # The stress before, along the plastic strain of this increment.
                before = 1.5 * (old[0] * s[0] + old[1] * s[1] + old[2] * s[2] + 2.0 * old[3] * s[3]) / q
                work[e, g] = 0.5 * dp * (before + y)
                keep = 1.0 - 3.0 * shear * dp / q
                a1 = 2.0 * shear * keep
                a2 = 6.0 * shear * shear * (dp / q - 1.0 / (3.0 * shear + slope))
                norm = q * np.sqrt(2.0 / 3.0)
                for i in range(4):
                    n[i] = s[i] / norm
                    s[i] *= keep
            strain1[e, g] = strain0[e, g] + dp
            for i in range(3):
                stress1[e, g, i] = s[i] + pressure
            stress1[e, g, 3] = s[3]
            w = w_end[g]
            for a in range(4):
                b1 = dn_end[g, a, 0]
                b2 = dn_end[g, a, 1]
                b3 = N_GAUSS[g, a] / r_end[g]
                v = (b_volume[2 * a] - (b1 + b3)) / 3.0
                b_bar[0, 2 * a] = b1 + v
                b_bar[1, 2 * a] = v
                b_bar[2, 2 * a] = b3 + v
                b_bar[3, 2 * a] = b2
                v = (b_volume[2 * a + 1] - b2) / 3.0
                b_bar[0, 2 * a + 1] = v
                b_bar[1, 2 * a + 1] = b2 + v
                b_bar[2, 2 * a + 1] = v
                b_bar[3, 2 * a + 1] = b1
            for k in range(8):
                for i in range(4):
                    fe[k] += w * b_bar[i, k] * stress1[e, g, i]
            d[:] = 0.0
            for i in range(3):
                for j in range(3):
                    d[i, j] = bulk - a1 / 3.0
                d[i, i] += a1
            d[3, 3] = 0.5 * a1
            if a2 != 0.0:
                for i in range(4):
                    for j in range(4):
                        d[i, j] += a2 * n[i] * n[j]
            for k in range(8):
                for i in range(4):
                    db[i, k] = w * (
                        d[i, 0] * b_bar[0, k]
                        + d[i, 1] * b_bar[1, k]
                        + d[i, 2] * b_bar[2, k]
                        + d[i, 3] * b_bar[3, k]
                    )
            for k in range(8):
                for j in range(k + 1):
                    ke[k, j] += (
                        b_bar[0, k] * db[0, j]
                        + b_bar[1, k] * db[1, j]
                        + b_bar[2, k] * db[2, j]
                        + b_bar[3, k] * db[3, j]
                    )
        for k in range(8):
            row = 2 * quads[e, k // 2] + k % 2
            force[row] += fe[k]
            for j in range(8):
                column = 2 * quads[e, j // 2] + j % 2
                band[column, diagonal + row - column] += ke[k, j] if j <= k else ke[j, k]
    return inverted
