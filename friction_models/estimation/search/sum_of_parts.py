"""Effects that simpler ones imitate: rate and state friction is a speed law plus running-in while no speed changes.

A breakdown by temperature and pressure is one by temperature alone, in another form, where nothing depends on the pressure.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from ...loads import LOAD_NAMES, FloatArray
from ..campaign.binned_tests import BinnedTests
from ..campaign.curves import spline_columns
from ..noise.noise_floor import Whitener
from .scan import VISIBLE, Fit, Projector, best_fit
from .significance import SAME

#: Gain beyond any sum of curves along its loads, from which on an effect shows something of its own.
OWN = 40.0
#: Bends of each curve.
KNOTS = 8
#: A simpler effect is tried in place of the first one from this share of its evidence on.
NEARLY = 0.85
#: Gain that chance hardly leaves the first one beyond a simpler effect and curves along its loads.
CHANCE = 12.0
#: By so many standard errors less than it would if it were true (`rivalry.py` says how far such gains scatter).
APART = 2.0


def shown_by_parts(
    campaign: BinnedTests, ranking: Sequence[Fit], residual: FloatArray, whiten: Whitener, project: Projector
) -> frozenset[str]:
    """Return the effects that show nothing beyond a sum of curves along each of their loads.

    Only effects with several amplitudes are asked: the others are simpler than any sum. `residual`, shape (m,), is whitened,
    without the base, which `project` removes.
    """
    asked = [f for f in ranking if len(f.amplitudes) > 1 and f.gain > 0.0]
    return frozenset(
        f.name
        for f in asked
        if sum(n in LOAD_NAMES and campaign.varies(n) for n in _drivers(f)) > 1
        and _own_gain(campaign, f, residual, whiten, project) <= OWN
    )


def parts_first(ranking: list[Fit], by_parts: Collection[str]) -> list[Fit]:
    """Let an effect of fewer loads lead where the first one is among those that parts show, too."""
    if not ranking or ranking[0].name not in by_parts:
        return ranking
    part = next((f for f in ranking[1:] if f.gain > 0.0 and is_part(f, ranking[0])), None)
    return ranking if part is None else [part, *(f for f in ranking if f is not part)]


def fewer_loads_first(
    campaign: BinnedTests, ranking: list[Fit], residual: FloatArray, whiten: Whitener, project: Projector
) -> list[Fit]:
    """Let an effect of fewer loads lead the first one if that shows nothing beyond it, in whatever form along its own loads.

    Weak effects need not show it: the first one stays where it would hardly show more if it were true, and does differ.
    `residual` is that of `shown_by_parts`.
    """
    if not ranking or ranking[0].gain <= 0.0:
        return ranking
    first = ranking[0]
    for part in ranking[1:]:
        simpler = len(part.amplitudes) <= len(first.amplitudes) and _drivers(part) < _drivers(first)
        nearly = part.evidence > NEARLY * first.evidence and part.effect.kind == first.effect.kind
        if not (simpler and nearly):
            continue
        forms = part.prepared.columns[:, part.prepared.usable.all(axis=1)].reshape(len(residual), -1)
        curves = project(whiten(spline_columns(campaign, part.effect.driver, KNOTS)))
        beyond = Projector(np.column_stack([forms, curves]))
        shown = _gain_beyond(first, beyond, residual)
        # what it would gain there if it were true: hardly anything where it has taken on the form of the simpler one
        expected = float(np.sum(beyond(first.signal) ** 2))
        alike = expected < SAME * first.gain
        if shown <= CHANCE and (alike or shown < expected - APART * 2.0 * np.sqrt(expected)):
            return [part, *(f for f in ranking if f is not part)]
    return ranking


def is_part(fit: Fit, whole: Fit) -> bool:
    """Return whether an effect has fewer amplitudes than another one, and only loads of it."""
    return len(fit.amplitudes) < len(whole.amplitudes) and _drivers(fit) < _drivers(whole)


def _drivers(fit: Fit) -> frozenset[str]:
    return frozenset(fit.effect.driver)


def _own_gain(
    campaign: BinnedTests, fit: Fit, residual: FloatArray, whiten: Whitener, project: Projector
) -> float:
    """Return the gain of an effect beyond curves along each of its loads."""
    curves = project(whiten(spline_columns(campaign, fit.effect.driver, KNOTS)))
    return _gain_beyond(fit, Projector(curves), residual)


def _gain_beyond(fit: Fit, beyond: Projector, residual: FloatArray) -> float:
    """Return the gain of an effect, at its best shape, `beyond` other columns, whitened and without the base."""
    prepared = fit.prepared
    columns = beyond(prepared.columns)
    seen = np.sum(columns**2, axis=0) > VISIBLE * np.maximum(np.sum(prepared.columns**2, axis=0), 1e-12)
    gram = np.einsum("mga,mgb->gab", columns, columns)
    own = replace(prepared, columns=columns, gram=gram, usable=prepared.usable & seen)
    return best_fit(own, beyond(residual)).gain
