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

#: Columns of the moduli of a Gauss point, by which the tangent follows from the last evaluation of the stress: 2 G of the
#: deviator after the return, the modulus along the flow direction, and this direction (rr, zz, tt, rz). Then the trial stress,
#: and how the plastic strain rises with it; 0: no plastic flow.
MODULI = 8
#: Newton's method for the plastic strain ends at this excess over the flow stress, or with a correction by this share; it is
#: linear, which leaves its square: of the flow stress, that times the exponents of strain and rate, 1e-6.
SETTLED, CLOSE = 1e-5, 1e-2


@njit(cache=True)
def radial_return(
    q: float, strain: float, T: float, dt: float, m: FloatArray, guess: float = 0.0
) -> tuple[float, float, float]:
    """Return plastic strain increment, flow stress and hardening slope for a trial equivalent stress `q`.

    Newton's method inside a bisection bracket: the law is steep near zero strain. It starts at the increment `guess`, if that
    is plastic.
    """
    g3 = 3.0 * elastic_moduli(m)[0]
    low = 0.0
    high = q / g3
    dp = guess
    yields = False
    if not 0.0 < guess < high:
        y, _, _ = flow_stress(strain, 0.0, T, m)
        if q <= y:
            return 0.0, y, 0.0
        yields = True
        dp = max(0.95 * (q - y) / g3, 1e-12)
    slope = 0.0
    per_time = 1.0 / dt
    for _ in range(40):
        y, by_strain, by_rate = flow_stress(strain + dp, dp * per_time, T, m)
        slope = by_strain + by_rate * per_time
        excess = q - g3 * dp - y
        if excess > 0.0:
            low = dp
        else:
            high = dp
        trial = dp + excess / (g3 + slope)
        if trial > 0.0 and (abs(excess) < SETTLED * y or abs(trial - dp) < CLOSE * dp):
            y += slope * (trial - dp)
            dp = trial
            break
        if trial <= low or trial >= high:
            if low == 0.0 and not yields:
                y, _, _ = flow_stress(strain, 0.0, T, m)
                if q <= y:
                    return 0.0, y, 0.0
                yields = True
            trial = 0.5 * (low + high)
        dp = trial
    return dp, y, slope


@njit(cache=True)
def internal_forces(
    x0: FloatArray,
    du: FloatArray,
    quads: IntArray,
    stress0: FloatArray,
    strain0: FloatArray,
    T: FloatArray,
    dt: float,
    m: FloatArray,
    force: FloatArray,
    stress1: FloatArray,
    strain1: FloatArray,
    work: FloatArray,
    moduli: FloatArray,
) -> int:
    """Add up the internal forces for the displacement increment `du` from the configuration `x0`.

    - `force`, shape (n_dof,): internal nodal forces per radian, added to.
    - `stress1`, `strain1`, `work`, shape (n_e, 4, 4), (n_e, 4), (n_e, 4): written: stress and plastic strain
      at the end of the increment, and the plastic work in it [N/mm2], with the mean of the stresses at both
      ends. The search for the plastic strain starts from what `strain1` and `moduli` hold.
    - `moduli`, shape (n_e, 4, MODULI): written, for `add_stiffness`.
    - returns: number of Gauss points with a non-positive Jacobian (the step is too large).
    """
    xm = np.empty((4, 2))
    x1 = np.empty((4, 2))
    ue = np.empty((4, 2))
    dn = np.empty((4, 2))
    # At each Gauss point: strains rr, zz, tt, and the slopes of u_r by z and of u_z by r.
    slopes = np.empty((4, 5))
    fe = np.empty((4, 2))
    b_volume = np.empty((4, 2))
    Te = np.empty(4)
    shear, bulk = elastic_moduli(m)
    inverted = 0
    for e in range(quads.shape[0]):
        for a in range(4):
            node = quads[e, a]
            Te[a] = T[node]
            for c in range(2):
                ue[a, c] = du[node, c]
                xm[a, c] = x0[node, c] + 0.5 * du[node, c]
                x1[a, c] = x0[node, c] + du[node, c]
                b_volume[a, c] = 0.0
                fe[a, c] = 0.0
        v_mid = 0.0
        v_end = 0.0
        dilatation = 0.0
        for g in range(4):
            w, r, det = gradients(xm, g, dn)
            e_rr = 0.0
            e_zz = 0.0
            e_tt = 0.0
            u_rz = 0.0
            u_zr = 0.0
            for a in range(4):
                e_rr += dn[a, 0] * ue[a, 0]
                e_zz += dn[a, 1] * ue[a, 1]
                e_tt += N_GAUSS[g, a] * ue[a, 0]
                u_rz += dn[a, 1] * ue[a, 0]
                u_zr += dn[a, 0] * ue[a, 1]
            e_tt /= r
            slopes[g, 0] = e_rr
            slopes[g, 1] = e_zz
            slopes[g, 2] = e_tt
            slopes[g, 3] = u_rz
            slopes[g, 4] = u_zr
            v_mid += w
            dilatation += w * (e_rr + e_zz + e_tt)
        dilatation /= v_mid
        pressure_force = 0.0
        for g in range(4):
            w, r, det = gradients(x1, g, dn)
            v_end += w
            if not det > 0.0:
                inverted += 1
            curvature = 1.0 / r
            temperature = 0.0
            for a in range(4):
                b_volume[a, 0] += w * (dn[a, 0] + N_GAUSS[g, a] * curvature)
                b_volume[a, 1] += w * dn[a, 1]
                temperature += N_GAUSS[g, a] * Te[a]
            e_rr = slopes[g, 0]
            e_zz = slopes[g, 1]
            e_tt = slopes[g, 2]
            u_rz = slopes[g, 3]
            u_zr = slopes[g, 4]
            mean = (e_rr + e_zz + e_tt) / 3.0
            half = 0.25 * (u_rz - u_zr)
            inverse = 1.0 / (1.0 + half * half)
            cos = (1.0 - half * half) * inverse
            sin = 2.0 * half * inverse
            s_rr = stress0[e, g, 0]
            s_zz = stress0[e, g, 1]
            s_tt = stress0[e, g, 2]
            s_rz = stress0[e, g, 3]
            pressure = (s_rr + s_zz + s_tt) / 3.0
            shift = 2.0 * cos * sin * s_rz
            old_rr = cos * cos * s_rr + sin * sin * s_zz + shift - pressure
            old_zz = sin * sin * s_rr + cos * cos * s_zz - shift - pressure
            old_tt = s_tt - pressure
            old_rz = (cos * cos - sin * sin) * s_rz - cos * sin * (s_rr - s_zz)
            s_rr = old_rr + 2.0 * shear * (e_rr - mean)
            s_zz = old_zz + 2.0 * shear * (e_zz - mean)
            s_tt = old_tt + 2.0 * shear * (e_tt - mean)
            s_rz = old_rz + shear * (u_rz + u_zr)
            pressure += bulk * dilatation
            q = np.sqrt(1.5 * (s_rr * s_rr + s_zz * s_zz + s_tt * s_tt + 2.0 * s_rz * s_rz))
            guess = strain1[e, g] - strain0[e, g] + (q - moduli[e, g, 6]) * moduli[e, g, 7]
            dp, y, slope = radial_return(q, strain0[e, g], temperature, dt, m, guess)
            moduli[e, g, 6] = q
            moduli[e, g, 7] = 0.0
            moduli[e, g, 0] = 2.0 * shear
            moduli[e, g, 1] = 0.0
            work[e, g] = 0.0
            if dp > 0.0:
                # The stress before, along the plastic strain of this increment.
                over_q = 1.0 / q
                before = 1.5 * (old_rr * s_rr + old_zz * s_zz + old_tt * s_tt + 2.0 * old_rz * s_rz) * over_q
                work[e, g] = 0.5 * dp * (before + y)
                keep = 1.0 - 3.0 * shear * dp * over_q
                norm = np.sqrt(1.5) * over_q
                by_trial = 1.0 / (3.0 * shear + slope)
                moduli[e, g, 0] = 2.0 * shear * keep
                moduli[e, g, 1] = 6.0 * shear * shear * (dp * over_q - by_trial)
                moduli[e, g, 7] = by_trial
                moduli[e, g, 2] = s_rr * norm
                moduli[e, g, 3] = s_zz * norm
                moduli[e, g, 4] = s_tt * norm
                moduli[e, g, 5] = s_rz * norm
                s_rr *= keep
                s_zz *= keep
                s_tt *= keep
                s_rz *= keep
            strain1[e, g] = strain0[e, g] + dp
            stress1[e, g, 0] = s_rr + pressure
            stress1[e, g, 1] = s_zz + pressure
            stress1[e, g, 2] = s_tt + pressure
            stress1[e, g, 3] = s_rz
            # The averaged volumetric part of B meets the pressure alone, its deviatoric part the deviator.
            pressure_force += w * pressure
            hoop = s_tt * curvature
            for a in range(4):
                b1 = dn[a, 0]
                b2 = dn[a, 1]
                fe[a, 0] += w * (s_rr * b1 + s_rz * b2 + hoop * N_GAUSS[g, a])
                fe[a, 1] += w * (s_zz * b2 + s_rz * b1)
        pressure_force /= v_end
        for a in range(4):
            row = 2 * quads[e, a]
            force[row] += fe[a, 0] + pressure_force * b_volume[a, 0]
            force[row + 1] += fe[a, 1] + pressure_force * b_volume[a, 1]
    return inverted


@njit(cache=True)
def add_stiffness(
    x0: FloatArray,
    du: FloatArray,
    quads: IntArray,
    moduli: FloatArray,
    m: FloatArray,
    stiffer: float,
    band: FloatArray,
) -> None:
    """Add the tangent of `internal_forces` after its last evaluation, which is symmetric.

    - `stiffer`: 0 for the consistent tangent, 1 for one that leaves out how soft plastic flow is along its own direction.
    - `band`, shape (n_dof, b + 1): lower triangle, added to: entry (i, j), i >= j, stands at ``band[j, i - j]``.
    """
    x1 = np.empty((4, 2))
    dn = np.empty((4, 2))
    ke = np.empty((8, 8))
    rows = np.zeros((4, 8))
    trace = np.empty(8)
    along = np.empty(8)
    b_volume = np.empty(8)
    place = np.empty(8, np.int64)
    bulk = elastic_moduli(m)[1]
    for e in range(quads.shape[0]):
        for a in range(4):
            node = quads[e, a]
            for c in range(2):
                x1[a, c] = x0[node, c] + du[node, c]
                place[2 * a + c] = 2 * node + c
        ke[:] = 0.0
        b_volume[:] = 0.0
        v_end = 0.0
        for g in range(4):
            w, r, _ = gradients(x1, g, dn)
            v_end += w
            # dev(B)' I dev(B) = B' I B - tr(B)' tr(B) / 3; the averaged trace enters once for the element.
            curvature = 1.0 / r
            for a in range(4):
                b3 = N_GAUSS[g, a] * curvature
                rows[0, 2 * a] = dn[a, 0]
                rows[1, 2 * a + 1] = dn[a, 1]
                rows[2, 2 * a] = b3
                rows[3, 2 * a] = dn[a, 1]
                rows[3, 2 * a + 1] = dn[a, 0]
                trace[2 * a] = dn[a, 0] + b3
                trace[2 * a + 1] = dn[a, 1]
            n_rr = moduli[e, g, 2]
            n_zz = moduli[e, g, 3]
            n_tt = moduli[e, g, 4]
            n_rz = moduli[e, g, 5]
            a1 = w * moduli[e, g, 0]
            a2 = w * moduli[e, g, 1] * (1.0 - stiffer)
            for k in range(8):
                b_volume[k] += w * trace[k]
                along[k] = n_rr * rows[0, k] + n_zz * rows[1, k] + n_tt * rows[2, k] + n_rz * rows[3, k]
            for k in range(8):
                c0 = a1 * rows[0, k]
                c1 = a1 * rows[1, k]
                c2 = a1 * rows[2, k]
                c3 = 0.5 * a1 * rows[3, k]
                c4 = -a1 / 3.0 * trace[k]
                c5 = a2 * along[k]
                # What stands right of the lower triangle is not read: the loop is as long as vectors are wide.
                for j in range(4 if k < 4 else 8):
                    ke[k, j] += (
                        c0 * rows[0, j]
                        + c1 * rows[1, j]
                        + c2 * rows[2, j]
                        + c3 * rows[3, j]
                        + c4 * trace[j]
                        + c5 * along[j]
                    )
        for k in range(8):
            volumetric = bulk / v_end * b_volume[k]
            row = place[k]
            for j in range(k + 1):
                first = min(row, place[j])
                band[first, max(row, place[j]) - first] += ke[k, j] + volumetric * b_volume[j]
