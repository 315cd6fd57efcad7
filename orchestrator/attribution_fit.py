"""Deviations of force-stroke curves projected on fingerprints, under the scatter of the repeats and of the mesh."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from friction_models.loads import FloatArray, InputError

from .attribution_causes import Cause
from .attribution_result import Attribution, Fit
from .attribution_runs import Sensitivities
from .forces import WINDOW, ForceCurve

if TYPE_CHECKING:
    from forming.press import PressLevel

#: Places along the stroke at which curves are compared.
PLACES = 32
#: Least that a mesh moves a curve by, relative to its largest force: slowly along the stroke, and at random.
MESH_ERROR = (0.002, 0.001)
#: Share of the stroke over which relative sensitivities are smoothed: meshes make them ripple.
SMOOTH = 0.08
#: Scatter of the force that is assumed where nothing was repeated.
ASSUMED_SCATTER = 0.01
#: Whitened squared distance below which two causes cannot be told apart (three standard errors).
APART = 9.0
#: Fingerprints closer than this are one and the same, whatever the scatter: cosine of their angle.
TWINS = 0.985
#: Family-wise level at which a cause counts as present.
LEVEL = 0.01
#: Least share of the squared deviation that a second cause must carry.
SECOND_SHARE = 0.1


@dataclass(frozen=True)
class Level:
    """One level of the press on a common stroke.

    Attributes
    ----------
    name : str
    stroke, simulated, measured, slope : ndarray, shape (n,)
        Stroke [mm], forces [kN], and the slope of the simulated one [kN/mm].
    window : float
        Stroke over which the forces are averaged [mm].
    deviations : ndarray, shape (repeats, n)
        Of each repeat from their mean [kN].
    """

    name: str
    stroke: FloatArray
    window: float
    simulated: FloatArray
    measured: FloatArray
    slope: FloatArray
    deviations: FloatArray


def on_common_stroke(level: PressLevel, simulated: ForceCurve, mesh_size: float = 0.0) -> Level:
    """Return measured and simulated force at the same strokes, both averaged over a mesh size at least.

    Raises
    ------
    InputError
        Less than 0.5 mm of stroke in common.
    """
    repeats = [ForceCurve(c["stroke"].to_numpy(), c["force"].to_numpy()) for c in level.repeats]
    start = max(simulated.stroke[0], *(c.stroke[0] for c in repeats))
    end = min(simulated.stroke[-1], *(c.stroke[-1] for c in repeats))
    if end - start < 0.5:
        raise InputError(
            f"{level.file}: {max(end - start, 0.0):.2f} mm of stroke in common with the simulation; allowed: at least 0.5 mm"
        )
    grid = np.linspace(start, end, PLACES)
    window = max(WINDOW, mesh_size)
    force = averaged(simulated, grid, window)
    each = np.array([averaged(c, grid, window) for c in repeats])
    mean = each.mean(axis=0)
    return Level(level.file, grid, window, force, mean, np.gradient(force, grid), each - mean)


def averaged(curve: ForceCurve, grid: FloatArray, window: float) -> FloatArray:
    """Return the force on `grid`, averaged over `window` [mm] (narrower at the ends)."""
    half = np.minimum(window / 2, np.minimum(grid - grid[0], grid[-1] - grid))
    fine = curve.on(np.linspace(grid[0], grid[-1], 8 * len(grid) + 1))
    at = np.linspace(grid[0], grid[-1], len(fine))
    area = np.concatenate([[0.0], np.cumsum(0.5 * (fine[1:] + fine[:-1]) * np.diff(at))])
    wide = half > 1e-9
    mean = np.interp(grid, at, fine)
    ends = [np.interp(grid[wide] + side * half[wide], at, area) for side in (-1.0, 1.0)]
    mean[wide] = (ends[1] - ends[0]) / (2.0 * half[wide])
    return mean


def attribution(
    levels: Sequence[Level], found: Sensitivities, synthetic: bool, warnings: Sequence[str] = ()
) -> Attribution:
    """Project the deviations of all levels on the fingerprints."""
    notes = list(warnings)
    whiten = _whiteners(levels, _mesh_error(levels, found), notes)
    columns = {c.key: _fingerprint(c, levels, found) for c in found.causes}
    deviation = [v.measured - v.simulated for v in levels]
    y = np.concatenate([w @ d for w, d in zip(whiten, deviation, strict=True)])
    names = list(dict.fromkeys(c.name for c in found.causes))
    parts = {n: [c for c in found.causes if c.name == n] for n in names}
    X = {
        n: np.column_stack(
            [np.concatenate([w @ f for w, f in zip(whiten, columns[c.key], strict=True)]) for c in parts[n]]
        )
        for n in names
    }
    unseen = [n for n in names if _visible(parts[n], X[n]) < 2.0]
    seen = [n for n in names if n not in unseen]
    if not seen:
        raise InputError(
            "attribution: no cause leaves a trace in these curves; allowed: longer strokes or more levels"
        )
    fits = {n: _fit(parts[n], X[n], y) for n in seen}
    ranking = sorted((_described(parts[n], X[n], *fits[n], len(seen)) for n in seen), key=lambda f: -f.gain)
    first = ranking[0]
    confusion: list[str] = []
    second: list[str] = []
    signal = np.zeros(len(y))
    if first.p_value < LEVEL and first.gain > 0.0:
        signal = X[first.cause] @ fits[first.cause][0]
        confusion = [first.cause] + [
            f.cause for f in ranking[1:] if _confused(signal, X[f.cause], parts[f.cause], first.gain - f.gain)
        ]
        second, signal = _second(y, X, parts, confusion, [n for n in seen if n not in confusion], len(seen))
    after = y - signal
    total = np.concatenate(deviation)
    scale = float(np.sqrt(np.mean(total**2)))
    expected = np.sqrt(np.mean(np.concatenate([np.diag(np.linalg.inv(w.T @ w)) for w in whiten])))
    left = _unwhitened(after, whiten)
    chi2 = float(after @ after) / len(y)
    if confusion and chi2 > 4.0:
        notes.append(
            f"what is left after the causes named is {np.sqrt(chi2):.1f} times the scatter: something else is wrong too"
        )
    return Attribution(
        ranking=ranking,
        confusion_set=confusion,
        second=second,
        groups=_groups(seen, X, parts),
        unseen=unseen,
        deviation={"before": scale, "after": float(np.sqrt(np.mean(left**2))), "scatter": float(expected)},
        levels=[
            {
                "level": v.name,
                "stroke_mm": [float(v.stroke[0]), float(v.stroke[-1])],
                "rms_kN": float(np.sqrt(np.mean((v.measured - v.simulated) ** 2))),
            }
            for v in levels
        ],
        synthetic=synthetic,
        warnings=notes,
    )


def _fingerprint(cause: Cause, levels: Sequence[Level], found: Sensitivities) -> list[FloatArray]:
    """Return the change of the force at every level for a strength of one [kN]."""
    if cause.name == "compliance":  # the sensor sees s + c F as travel
        return [-v.slope * v.simulated for v in levels]
    if cause.name == "stroke_zero":
        return [-v.slope for v in levels]
    if cause.name == "force_gain":
        return [v.simulated for v in levels]
    prints = []
    for v, moved in zip(levels, found.moved[cause.key], strict=True):
        change = averaged(moved, v.stroke, v.window) - v.simulated
        near = np.exp(-0.5 * ((v.stroke[:, None] - v.stroke) / (SMOOTH * np.ptp(v.stroke))) ** 2)
        relative = near @ (v.simulated * change) / np.maximum(near @ v.simulated**2, 1e-12)
        prints.append(relative * v.simulated / cause.step)
    return prints


def _mesh_error(levels: Sequence[Level], found: Sensitivities) -> tuple[float, float]:
    """Return the slow and the random error of the mesh, relative to the largest force."""
    slow, white = 0.0, 0.0
    for v, other in zip(levels, found.remeshed, strict=False):
        change = (averaged(other, v.stroke, v.window) - v.simulated) / v.simulated.max()
        noise = float(np.mean(np.diff(change, 2) ** 2)) / 6.0
        white += noise / len(levels)
        slow += max(float(np.mean(change**2)) - noise, 0.0) / len(levels)
    return max(MESH_ERROR[0], float(np.sqrt(slow))), max(MESH_ERROR[1], float(np.sqrt(white)))


def _whiteners(levels: Sequence[Level], mesh: tuple[float, float], notes: list[str]) -> list[FloatArray]:
    """Return a matrix for each level that turns its mean curve into independent numbers of variance one.

    A billet, or its lubricant, shifts a whole curve in proportion to the force; beside that curves differ
    slowly along the stroke, and by sensor noise. Meshes differ too: their error is on top.
    """
    gains, slow, white, freedom = 0.0, 0.0, 0.0, 0
    for v in levels:
        share = v.deviations @ v.simulated / float(v.simulated @ v.simulated)
        rest = (v.deviations - share[:, None] * v.simulated) / v.simulated.max()
        noise = float(np.mean(np.diff(rest, 2, axis=1) ** 2)) / 6.0
        gains += float(share @ share)
        slow += float(np.sum(np.mean(rest**2, axis=1)))
        white += noise * len(rest)
        freedom += len(rest) - 1
    if freedom < 1:
        notes.append(
            f"no level was repeated: a scatter of {100 * ASSUMED_SCATTER:g} % of the force is assumed, nothing is certain"
        )
        gains, slow, white = ASSUMED_SCATTER**2, (0.5 * ASSUMED_SCATTER) ** 2, 1e-6
    else:
        wide = freedom / max(freedom - 2.0, 1.0)  # few repeats know their own scatter poorly
        gains, slow, white = gains / freedom * wide, slow / freedom * wide, white / freedom * wide
        if freedom < 4:
            notes.append("few repeats: their scatter is poorly known")
    result = []
    for v in levels:
        n, top = max(len(v.deviations), 1), float(v.simulated.max())
        gap = np.abs(v.stroke[:, None] - v.stroke[None, :]) / float(np.ptp(v.stroke))
        S = gains * np.outer(v.simulated, v.simulated)
        S = S + top**2 * (slow * np.exp(-gap / 0.3) + white * np.eye(len(v.stroke)))
        S = S / n + top**2 * (mesh[0] ** 2 * np.exp(-gap / 0.15) + mesh[1] ** 2 * np.eye(len(v.stroke)))
        result.append(np.linalg.inv(np.linalg.cholesky(S)))
    return result


def _unwhitened(values: FloatArray, whiten: Sequence[FloatArray]) -> FloatArray:
    parts = np.split(values, np.cumsum([len(w) for w in whiten])[:-1])
    return np.concatenate([np.linalg.solve(w, p) for w, p in zip(whiten, parts, strict=True)])


def _visible(parts: Sequence[Cause], X: FloatArray) -> float:
    """Return how many standard errors the sensitivity's step is worth (for causes of the press: a usual size)."""
    usual = {"compliance": 1e-3, "stroke_zero": 0.05, "force_gain": 0.01}
    steps = [usual.get(c.name, c.step) for c in parts]
    return float(max(np.linalg.norm(X[:, k] * s) for k, s in enumerate(steps)))


def _fit(parts: Sequence[Cause], X: FloatArray, y: FloatArray) -> tuple[FloatArray, float]:
    """Return the strengths that fit best with their physical signs, and the drop of the squared error."""
    from itertools import combinations

    best, drop = np.zeros(len(parts)), 0.0
    for size in range(1, len(parts) + 1):
        for chosen in combinations(range(len(parts)), size):
            x = np.linalg.lstsq(X[:, chosen], y, rcond=1e-8)[0]
            if any(parts[k].sign * v < 0.0 for k, v in zip(chosen, x, strict=True)):
                continue
            gained = float(y @ y - np.sum((y - X[:, chosen] @ x) ** 2))
            if gained > drop + (2.0 if size > 1 else 0.0):
                best, drop = np.zeros(len(parts)), gained
                best[list(chosen)] = x
    return best, drop


def _described(parts: Sequence[Cause], X: FloatArray, values: FloatArray, drop: float, family: int) -> Fit:
    from scipy.stats import chi2

    k = len(parts)
    errors = np.sqrt(np.diag(np.linalg.pinv(X.T @ X)))
    p = float(min(1.0, family * chi2.sf(drop, k)))
    numbers = tuple(
        (c.column, float(v), float(e), c.unit) for c, v, e in zip(parts, values, errors, strict=True)
    )
    return Fit(parts[0].name, parts[0].kind, parts[0].title, numbers, drop - 2.0 * k, p)


def _confused(signal: FloatArray, X: FloatArray, parts: Sequence[Cause], lead: float) -> bool:
    """Return whether a rival explains what the first cause does, within the scatter."""
    drop = _fit(parts, X, signal)[1]
    power = float(signal @ signal)
    return power - drop < APART or lead < APART / 2 or np.sqrt(drop / power) > TWINS


def _second(
    y: FloatArray,
    X: dict[str, FloatArray],
    parts: dict[str, list[Cause]],
    confusion: list[str],
    others: Sequence[str],
    family: int,
) -> tuple[list[str], FloatArray]:
    """Return causes that explain what the first one leaves, and the joint signal of both."""
    from scipy.stats import chi2

    first = confusion[0]
    alone = X[first] @ np.linalg.lstsq(X[first], y, rcond=1e-8)[0]
    base = float(np.sum((y - alone) ** 2))
    # whatever of the confusion set is the truth must not leave room for a second cause
    least = min(float(np.sum((y - X[c] @ _fit(parts[c], X[c], y)[0]) ** 2)) for c in confusion)
    found = []
    for name in others:
        both = np.column_stack([X[first], X[name]])
        x = np.linalg.lstsq(both, y, rcond=1e-8)[0]
        added = x[X[first].shape[1] :]
        if any(c.sign * v < 0.0 for c, v in zip(parts[name], added, strict=True)):
            continue
        drop = min(base, least) - float(np.sum((y - both @ x) ** 2))
        size = float(np.sum((X[name] @ added) ** 2))
        p = family * chi2.sf(max(drop, 0.0), len(parts[name]))
        if p < LEVEL and size > SECOND_SHARE * float(y @ y):
            found.append((drop, name, both @ x))
    if not found:
        return [], alone
    found.sort(key=lambda f: -f[0])
    near = [n for d, n, _ in found if found[0][0] - d < APART]
    return near, found[0][2]


def _groups(names: Sequence[str], X: dict[str, FloatArray], parts: dict[str, list[Cause]]) -> list[list[str]]:
    """Return causes whose fingerprints lie closer than `TWINS`, as connected sets."""
    groups: list[list[str]] = []
    q = {n: np.linalg.qr(X[n] / np.linalg.norm(X[n], axis=0).clip(1e-300))[0] for n in names}
    for name in names:
        near = [
            g
            for g in groups
            if any(
                q[name].shape[1] == q[o].shape[1] == 1 and abs(float(q[name][:, 0] @ q[o][:, 0])) > TWINS
                for o in g
            )
        ]
        merged = [x for g in near for x in g] + [name]
        groups = [g for g in groups if g not in near] + [merged]
    return [g for g in groups if len(g) > 1]
