"""Numba kernels of the sliding model: shift, implicit sweeps, interface temperatures."""

from __future__ import annotations

import numpy as np
from numba import njit

from friction_models.loads import FloatArray


@njit(cache=True)
def shift_plate(plate: FloatArray, fresh: float) -> None:
    """Move the plate by one cell along +x; fresh material enters in front."""
    for i in range(plate.shape[0] - 1, 0, -1):
        plate[i] = plate[i - 1]
    plate[0] = fresh


@njit(cache=True)
def _tridiagonal_lines(
    lower: FloatArray, diagonal: FloatArray, upper: FloatArray, lines: FloatArray, scratch: FloatArray
) -> None:
    """Solve one tridiagonal system for many right-hand sides, lines[equation, side], in place."""
    n = len(diagonal)
    scratch[0] = upper[0] / diagonal[0]
    lines[0] /= diagonal[0]
    for i in range(1, n):
        pivot = 1.0 / (diagonal[i] - lower[i] * scratch[i - 1])
        scratch[i] = upper[i] * pivot
        for k in range(lines.shape[1]):
            lines[i, k] = (lines[i, k] - lower[i] * lines[i - 1, k]) * pivot
    for i in range(n - 2, -1, -1):
        for k in range(lines.shape[1]):
            lines[i, k] -= scratch[i] * lines[i + 1, k]


@njit(cache=True)
def sweep_across(field: FloatArray, share: FloatArray, dx: float, dy: FloatArray, alpha_dt: float) -> None:
    """Conduct implicitly along x, then along y; cells with share 0 are outside the body.

    `share` [nx, ny] is the covered part of a cell; a face conducts over the smaller one of its two cells.
    """
    nx, ny, _ = field.shape
    size = max(nx, ny)
    lower, diagonal = np.zeros(size), np.ones(size)
    upper, scratch = np.zeros(size), np.zeros(size)
    for j in range(ny):
        for i in range(nx):
            own = share[i, j]
            lower[i] = upper[i] = 0.0
            if own > 0.0:
                if i > 0:
                    lower[i] = -alpha_dt / (dx * dx) * min(own, share[i - 1, j]) / own
                if i < nx - 1:
                    upper[i] = -alpha_dt / (dx * dx) * min(own, share[i + 1, j]) / own
            diagonal[i] = 1.0 - lower[i] - upper[i]
        _tridiagonal_lines(lower[:nx], diagonal[:nx], upper[:nx], field[:, j, :], scratch)
    if ny == 1:
        return
    for i in range(nx):
        for j in range(ny):
            own = share[i, j]
            lower[j] = upper[j] = 0.0
            if own > 0.0:
                if j > 0:
                    gap = 0.5 * (dy[j] + dy[j - 1]) * dy[j]
                    lower[j] = -alpha_dt / gap * min(own, share[i, j - 1]) / own
                if j < ny - 1:
                    gap = 0.5 * (dy[j] + dy[j + 1]) * dy[j]
                    upper[j] = -alpha_dt / gap * min(own, share[i, j + 1]) / own
            diagonal[j] = 1.0 - lower[j] - upper[j]
        _tridiagonal_lines(lower[:ny], diagonal[:ny], upper[:ny], field[i], scratch)


@njit(cache=True)
def sweep_depth(
    plate: FloatArray,
    specimen: FloatArray,
    share: FloatArray,
    heat: FloatArray,
    plate_layers: FloatArray,
    specimen_layers: FloatArray,
    material: tuple[float, float, float, float],
    heat_transfer: float,
    punch_temperature: float,
) -> None:
    """Conduct implicitly through punch - specimen - interface - plate, column by column.

    `heat` [nx, ny] is the friction power per contact area; a column whose cell is covered in part
    (`share`) passes that part of it to the plate. `material`: conductivity and capacity / dt of plate
    and specimen.
    """
    k_p, c_p, k_s, c_s = material
    n_p, n_s = len(plate_layers), len(specimen_layers)
    n = n_p + n_s
    lower0, diagonal0, upper0 = np.zeros(n), np.zeros(n), np.zeros(n)
    for k in range(n_s):  # specimen from the punch down: row n_s - 1 - k
        diagonal0[n_s - 1 - k] = c_s * specimen_layers[k]
    for k in range(n_p):
        diagonal0[n_s + k] = c_p * plate_layers[k]
    for k in range(n_s - 1):
        g = 2.0 * k_s / (specimen_layers[k] + specimen_layers[k + 1])
        row = n_s - 1 - k
        diagonal0[row] += g
        diagonal0[row - 1] += g
        lower0[row] -= g
        upper0[row - 1] -= g
    for k in range(n_p - 1):
        g = 2.0 * k_p / (plate_layers[k] + plate_layers[k + 1])
        row = n_s + k
        diagonal0[row] += g
        diagonal0[row + 1] += g
        upper0[row] -= g
        lower0[row + 1] -= g
    top = 1.0 / (1.0 / heat_transfer + 0.5 * specimen_layers[-1] / k_s)
    diagonal0[0] += top
    r_p = 0.5 * plate_layers[0] / k_p + 0.5 / heat_transfer
    r_s = 0.5 * specimen_layers[0] / k_s + 0.5 / heat_transfer
    bridge = 1.0 / (r_p + r_s)
    ratio, pivot = np.empty(n), np.empty(n)
    free_ratio, free_pivot = np.empty(n), np.empty(n)
    _factor(lower0, diagonal0, upper0, n_s, free_ratio, free_pivot)
    column = np.empty(n)
    last = -1.0
    for i in range(plate.shape[0]):
        for j in range(plate.shape[1]):
            part = share[i, j]
            for k in range(n_p):
                column[n_s + k] = c_p * plate_layers[k] * plate[i, j, k]
            if part <= 0.0:
                _substitute(lower0, n_s, free_ratio, free_pivot, column)
            else:
                if part != last:
                    # Equations of the specimen are per contact area, of the plate per cell area.
                    diagonal0[n_s - 1] += bridge
                    diagonal0[n_s] += part * bridge
                    upper0[n_s - 1] = -bridge
                    lower0[n_s] = -part * bridge
                    _factor(lower0, diagonal0, upper0, 0, ratio, pivot)
                    diagonal0[n_s - 1] -= bridge
                    diagonal0[n_s] -= part * bridge
                    last = part
                for k in range(n_s):
                    column[n_s - 1 - k] = c_s * specimen_layers[k] * specimen[i, j, k]
                to_plate = heat[i, j] * r_s / (r_p + r_s)
                column[0] += top * punch_temperature
                column[n_s - 1] += heat[i, j] - to_plate
                column[n_s] += part * to_plate
                lower0[n_s] = -part * bridge
                _substitute(lower0, 0, ratio, pivot, column)
                for k in range(n_s):
                    specimen[i, j, k] = column[n_s - 1 - k]
            for k in range(n_p):
                plate[i, j, k] = column[n_s + k]


@njit(cache=True)
def _factor(
    lower: FloatArray,
    diagonal: FloatArray,
    upper: FloatArray,
    start: int,
    ratio: FloatArray,
    pivot: FloatArray,
) -> None:
    """Factor the tridiagonal system from row `start` on."""
    pivot[start] = 1.0 / diagonal[start]
    ratio[start] = upper[start] * pivot[start]
    for a in range(start + 1, len(diagonal)):
        pivot[a] = 1.0 / (diagonal[a] - lower[a] * ratio[a - 1])
        ratio[a] = upper[a] * pivot[a]


@njit(cache=True)
def _substitute(
    lower: FloatArray, start: int, ratio: FloatArray, pivot: FloatArray, column: FloatArray
) -> None:
    """Solve with a factored system, in place, from row `start` on."""
    column[start] *= pivot[start]
    for a in range(start + 1, len(column)):
        column[a] = (column[a] - lower[a] * column[a - 1]) * pivot[a]
    for a in range(len(column) - 2, start - 1, -1):
        column[a] -= ratio[a] * column[a + 1]


@njit(cache=True)
def interface_means(
    plate: FloatArray,
    specimen: FloatArray,
    weights: FloatArray,
    heat: FloatArray,
    offset: float,
    half_plate: float,
    half_specimen: float,
    half_contact: float,
) -> tuple[float, float, float]:
    """Return area means of plate and specimen surface temperature, and the largest mean of both.

    `offset` (-0.5 to 0.5 cells) is how far the plate has moved since its lattice was in place; the
    plate is read in between its cells. `half_*` are thermal resistances of half a layer and of half
    the contact.
    """
    nx, ny, _ = plate.shape
    r_p, r_s = half_plate + half_contact, half_specimen + half_contact
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
            to_plate = (heat[i, j] * r_s + cell_s - cell_p) / (r_p + r_s)
            surface_p = cell_p + to_plate * half_plate
            surface_s = cell_s + (heat[i, j] - to_plate) * half_specimen
            mean_p += weight * surface_p
            mean_s += weight * surface_s
            top = max(top, 0.5 * (surface_p + surface_s))
    return mean_p, mean_s, top
