"""Numba kernels of the sliding model: shift, implicit sweeps with k(T) and c(T), interface temperatures.

A step takes conductivity and capacity of every cell at its temperature before the step. The heat that a
cell has gained by the end of the step is then turned into a temperature by its enthalpy, so that a
capacity that varies loses no heat, however large the step.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from friction_models.loads import FloatArray

from .thermal_settings import TABLE_START, TABLE_STEP


@njit(cache=True)
def shift_plate(plate: FloatArray, fresh: float) -> None:
    """Move the plate by one cell along +x; fresh material enters in front."""
    for i in range(plate.shape[0] - 1, 0, -1):
        plate[i] = plate[i - 1]
    plate[0] = fresh


@njit(cache=True)
def _look_up(table: FloatArray, T: float) -> tuple[float, float, float]:
    """Return conductivity, capacity and enthalpy at a temperature; `table` [3, n], n = 1: constants."""
    last = table.shape[1] - 1
    if last == 0:
        return table[0, 0], table[1, 0], table[1, 0] * T
    x = (T - TABLE_START) / TABLE_STEP
    i = min(max(int(x), 0), last - 1)
    u = x - i
    v = min(max(u, 0.0), 1.0)
    k = table[0, i] + v * (table[0, i + 1] - table[0, i])
    c = table[1, i] + v * (table[1, i + 1] - table[1, i])
    # Enthalpy is the exact integral of the capacity; beyond the table the capacity stays.
    h = table[2, i] + TABLE_STEP * (0.5 * v * (table[1, i] + c) + (u - v) * c)
    return k, c, h


@njit(cache=True)
def properties(field: FloatArray, table: FloatArray, k: FloatArray, c: FloatArray) -> None:
    """Write conductivity and capacity of all cells of a body."""
    if table.shape[1] == 1:
        k[:] = table[0, 0]
        c[:] = table[1, 0]
        return
    for i in range(field.shape[0]):
        for j in range(field.shape[1]):
            for n in range(field.shape[2]):
                k[i, j, n], c[i, j, n], _ = _look_up(table, field[i, j, n])


@njit(cache=True)
def settle(field: FloatArray, before: FloatArray, table: FloatArray, c: FloatArray) -> None:
    """Turn the temperatures at the end of a step, found with capacity `c`, into those of equal heat."""
    for i in range(field.shape[0]):
        for j in range(field.shape[1]):
            for n in range(field.shape[2]):
                T, start = field[i, j, n], before[i, j, n]
                if abs(T - start) < 1e-4:
                    continue
                wanted = _look_up(table, start)[2] + c[i, j, n] * (T - start)
                for _ in range(4):
                    _, slope, value = _look_up(table, T)
                    T -= (value - wanted) / slope
                    if abs(value - wanted) < 1e-7 * slope:
                        break
                field[i, j, n] = T


@njit(cache=True)
def _forward(
    here: FloatArray,
    before: FloatArray,
    k: FloatArray,
    k_next: FloatArray,
    c: FloatArray,
    left: FloatArray,
    ratio: FloatArray,
    ratio_before: FloatArray,
    room: float,
    face: float,
) -> None:
    """Eliminate one row of cells; all arrays [layers]. `left` is the conductance to the row before."""
    for n in range(here.shape[0]):
        right = face * (k[n] + k_next[n])
        own = room * c[n]
        pivot = 1.0 / (own + right + left[n] * (1.0 - ratio_before[n]))
        ratio[n] = right * pivot
        here[n] = (own * here[n] + left[n] * before[n]) * pivot
        left[n] = right


@njit(cache=True)
def sweep_across(
    field: FloatArray, share: FloatArray, k: FloatArray, c: FloatArray, dx: float, dy: FloatArray, dt: float
) -> None:
    """Conduct implicitly along x, then along y; cells with share 0 are outside the body.

    `share` [nx, ny] is the covered part of a cell; a face conducts over the smaller one of its two cells.
    """
    nx, ny, nz = field.shape
    ratio = np.zeros((max(nx, ny), nz))
    left = np.empty(nz)
    for j in range(ny):
        left[:] = 0.0
        for i in range(nx):
            p, q = max(i - 1, 0), min(i + 1, nx - 1)
            face = 0.5 * min(share[i, j], share[q, j]) * dt / (dx * dx) if q > i else 0.0
            own = share[i, j]
            if own <= 0.0:  # outside the body; `left` is 0 already
                ratio[i] = 0.0
                continue
            _forward(field[i, j], field[p, j], k[i, j], k[q, j], c[i, j], left, ratio[i], ratio[p], own, face)
        for i in range(nx - 2, -1, -1):
            for n in range(nz):
                field[i, j, n] += ratio[i, n] * field[i + 1, j, n]
    if ny == 1:
        return
    for i in range(nx):
        left[:] = 0.0
        for j in range(ny):
            p, q = max(j - 1, 0), min(j + 1, ny - 1)
            # Cells differ in width: rows are per length of x, times their own width.
            face = min(share[i, j], share[i, q]) * dt / (dy[j] + dy[q]) if q > j else 0.0
            own = share[i, j] * dy[j]
            if own <= 0.0:
                ratio[j] = 0.0
                continue
            _forward(field[i, j], field[i, p], k[i, j], k[i, q], c[i, j], left, ratio[j], ratio[p], own, face)
        for j in range(ny - 2, -1, -1):
            for n in range(nz):
                field[i, j, n] += ratio[j, n] * field[i, j + 1, n]


@njit(cache=True)
def sweep_depth(
    plate: FloatArray,
    specimen: FloatArray,
    share: FloatArray,
    heat: FloatArray,
    plate_layers: FloatArray,
    specimen_layers: FloatArray,
    k_p: FloatArray,
    c_p: FloatArray,
    k_s: FloatArray,
    c_s: FloatArray,
    dt: float,
    heat_transfer: float,
    friction_heat_share: float,
    punch_temperature: float,
) -> None:
    """Conduct implicitly through punch - specimen - interface - plate, column by column.

    `heat` [nx, ny] is the friction power per contact area; a column whose cell is covered in part
    (`share`) passes that part of it to the plate. `k_*`, `c_*`: conductivity and capacity of the cells.
    """
    n_p, n_s = len(plate_layers), len(specimen_layers)
    ratio_s, ratio_p = np.empty(n_s), np.empty(n_p)
    for i in range(plate.shape[0]):
        for j in range(plate.shape[1]):
            part = share[i, j]
            # What crosses the interface, as seen by the plate: flux = to_plate + bridge * (T_s - T_p).
            upper = 0.0  # conductance to the specimen, times its part
            inflow = 0.0
            last_ratio = 0.0
            last_value = 0.0
            if part > 0.0:
                column_s, ks, cs = specimen[i, j], k_s[i, j], c_s[i, j]
                r_p = 0.5 * plate_layers[0] / k_p[i, j, 0] + friction_heat_share / heat_transfer
                r_s = 0.5 * specimen_layers[0] / ks[0] + (1.0 - friction_heat_share) / heat_transfer
                bridge = 1.0 / (r_p + r_s)
                to_plate = heat[i, j] * r_s * bridge
                top = 1.0 / (1.0 / heat_transfer + 0.5 * specimen_layers[n_s - 1] / ks[n_s - 1])
                # Elimination from the punch down: row n is coupled to n + 1 (above) and n - 1 (below).
                from_above, ratio_above, value_above = top, 0.0, punch_temperature
                for n in range(n_s - 1, -1, -1):
                    room = cs[n] * specimen_layers[n] / dt
                    below = bridge
                    source = heat[i, j] - to_plate
                    if n > 0:
                        below = (ks[n] + ks[n - 1]) / (specimen_layers[n] + specimen_layers[n - 1])
                        source = 0.0
                    pivot = 1.0 / (room + below + from_above * (1.0 - ratio_above))
                    value_above = (room * column_s[n] + source + from_above * value_above) * pivot
                    column_s[n] = value_above
                    ratio_above = below * pivot
                    ratio_s[n] = ratio_above
                    from_above = below
                upper, inflow = part * bridge, part * to_plate
                last_ratio, last_value = ratio_above, value_above
            column_p, kp, cp = plate[i, j], k_p[i, j], c_p[i, j]
            for n in range(n_p):
                room = cp[n] * plate_layers[n] / dt
                below = 0.0
                if n < n_p - 1:
                    below = (kp[n] + kp[n + 1]) / (plate_layers[n] + plate_layers[n + 1])
                pivot = 1.0 / (room + below + upper * (1.0 - last_ratio))
                last_value = (room * column_p[n] + inflow + upper * last_value) * pivot
                column_p[n] = last_value
                last_ratio = below * pivot
                ratio_p[n] = last_ratio
                upper, inflow = below, 0.0
            for n in range(n_p - 2, -1, -1):
                column_p[n] += ratio_p[n] * column_p[n + 1]
            if part > 0.0:
                column_s = specimen[i, j]
                column_s[0] += ratio_s[0] * column_p[0]
                for n in range(1, n_s):
                    column_s[n] += ratio_s[n] * column_s[n - 1]


@njit(cache=True)
def interface_means(
    plate: FloatArray,
    specimen: FloatArray,
    weights: FloatArray,
    heat: FloatArray,
    offset: float,
    plate_layer: float,
    specimen_layer: float,
    plate_table: FloatArray,
    specimen_table: FloatArray,
    to_plate_side: float,
    to_specimen_side: float,
) -> tuple[float, float, float]:
    """Return area means of plate and specimen surface temperature, and the largest mean of both.

    `offset` (-0.5 to 0.5 cells) is how far the plate has moved since its lattice was in place; the
    plate is read in between its cells. `*_layer` are the layers at the interface [mm], `to_*_side` the
    thermal resistances of the film between where friction heat is released and each body.
    """
    nx, ny, _ = plate.shape
    mean_p = mean_s = 0.0
    top = -1e30
    step = 1 if offset >= 0.0 else -1
    part = abs(offset)
    for i in range(nx):
        neighbour = min(max(i - step, 0), nx - 1)
        for j in range(ny):
            weight = weights[i, j]
            if weight <= 0.0:
                continue
            cell_p = (1.0 - part) * plate[i, j, 0] + part * plate[neighbour, j, 0]
            cell_s = specimen[i, j, 0]
            half_p = 0.5 * plate_layer / _look_up(plate_table, cell_p)[0]
            half_s = 0.5 * specimen_layer / _look_up(specimen_table, cell_s)[0]
            r_p, r_s = half_p + to_plate_side, half_s + to_specimen_side
            to_plate = (heat[i, j] * r_s + cell_s - cell_p) / (r_p + r_s)
            surface_p = cell_p + to_plate * half_p
            surface_s = cell_s + (heat[i, j] - to_plate) * half_s
            mean_p += weight * surface_p
            mean_s += weight * surface_s
            top = max(top, 0.5 * (surface_p + surface_s))
    return mean_p, mean_s, top
