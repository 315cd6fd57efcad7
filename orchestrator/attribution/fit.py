"""Deviations of force-stroke curves projected on the fingerprints of causes."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from scipy.stats import chi2

from friction_models.common import InputError
from friction_models.loads import FloatArray

from .causes import Cause
from .curves import BENT, LevelForces, fingerprint
from .result import LEFT, Attribution, Fit, LevelCurves, Strength
from .scatter import Scatter
from .sensitivities import Sensitivities

#: Whitened squared distance below which two causes cannot be told apart (three standard errors).
APART = 9.0
#: Fingerprints closer than this are one and the same, whatever the scatter: cosine of their angle.
TWINS = 0.985
#: Family-wise level at which a cause counts as present.
LEVEL = 0.01
#: Least share of the squared deviation that a second cause must carry.
SECOND_SHARE = 0.1
#: How often causes whose change is not in proportion to their strength are followed.
FOLLOWED = 4


def attribution(
    levels: Sequence[LevelForces], found: Sensitivities, synthetic: bool, warnings: Sequence[str] = ()
) -> Attribution:
    """Project the deviations of all levels on the fingerprints."""
    notes = list(warnings)
    scatter = Scatter.of(levels, found, notes)
    columns = {c.key: fingerprint(c, levels, found) for c in found.causes}
    deviation = [v.measured - v.simulated for v in levels]
    y = scatter.whitened(deviation)
    names = list(dict.fromkeys(c.name for c in found.causes))
    parts = {n: [c for c in found.causes if c.name == n] for n in names}
    for name in (n for n in BENT if n in parts):
        (cause,) = parts[name]
        for _ in range(FOLLOWED):
            strength = float(_fit(parts[name], _whitened([columns[name]], scatter), y)[0][0])
            if strength == 0.0:
                break
            columns[name] = fingerprint(cause, levels, found, strength)
    X = {n: _whitened([columns[c.key] for c in parts[n]], scatter) for n in names}
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
    before = _rms(np.concatenate(deviation))
    left, times = _left(y - signal, scatter)
    if confusion and times > LEFT and _rms(left) > before:
        # Repeats and mesh leave the height of the curves open, so the course decides; but far outside the scatter a cause
        # that takes the curves further apart explains nothing.
        notes.append(
            f"{first.cause} would fit the course of the curves best, but leave {_rms(left):.1f} kN in place of {before:.1f}: not named"
        )
        confusion, second = [], []
        left, _ = _left(y, scatter)
    elif confusion and times > LEFT:
        notes.append(
            f"what is left after the causes named is {times:.1f} times the scatter: something else is wrong too"
        )
    return Attribution(
        ranking=ranking,
        confusion_set=confusion,
        second=second,
        groups=_groups(seen, X, parts),
        unseen=unseen,
        deviation={
            "before": before,
            "after": _rms(left),
            "scatter": _rms(scatter.deviation),
            "mesh": _rms(scatter.drift),
        },
        levels=[
            {
                "level": v.name,
                "stroke_mm": [float(v.stroke[0]), float(v.stroke[-1])],
                "rms_kN": _rms(v.measured - v.simulated),
            }
            for v in levels
        ],
        synthetic=synthetic,
        warnings=notes,
        curves=_curves(levels, columns, parts, left, scatter),
    )


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _left(whitened: FloatArray, scatter: Scatter) -> tuple[FloatArray, float]:
    """Return forces that are left [kN], and their size in standard deviations of the scatter."""
    return scatter.factor @ whitened, _rms(whitened)


def _whitened(prints: Sequence[Sequence[FloatArray]], scatter: Scatter) -> FloatArray:
    """Return whitened fingerprints as columns."""
    return np.column_stack([scatter.whitened(p) for p in prints])


def _curves(
    levels: Sequence[LevelForces],
    columns: dict[str, list[FloatArray]],
    parts: dict[str, list[Cause]],
    left: FloatArray,
    scatter: Scatter,
) -> list[LevelCurves]:
    """Return what the page draws of each level."""
    ends = np.cumsum([len(v.stroke) for v in levels])[:-1]
    after, expected = np.split(left, ends), np.split(scatter.deviation, ends)
    return [
        {
            "level": v.name,
            "stroke": v.stroke,
            "measured": v.measured,
            "simulated": v.simulated,
            "after": after[k],
            "scatter": expected[k],
            "fingerprints": {c.key: columns[c.key][k] for p in parts.values() for c in p},
        }
        for k, v in enumerate(levels)
    ]


def _visible(parts: Sequence[Cause], X: FloatArray) -> float:
    """Return how many standard errors a usual size of the cause is worth; the sensitivity's step where none is known."""
    usual = {"compliance": 1e-3, "stroke_zero": 0.05, "force_gain": 0.02, "flow_stress": 0.03}
    steps = [usual.get(c.name, c.step) for c in parts]
    return float(max(np.linalg.norm(X[:, k] * s) for k, s in enumerate(steps)))


def _fit(parts: Sequence[Cause], X: FloatArray, y: FloatArray) -> tuple[FloatArray, float]:
    """Return the strengths that fit best with their physical signs, and the drop of the squared error."""
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
    k = len(parts)
    errors = np.sqrt(np.diag(np.linalg.pinv(X.T @ X)))
    p = float(min(1.0, family * chi2.sf(drop, k)))
    numbers = tuple(
        Strength(c.column, float(v), float(e), c.unit) for c, v, e in zip(parts, values, errors, strict=True)
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
