"""Candidate terms: every effect of the catalogue over its shape parameters, evaluated on all points at once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from ...common import InputError
from ...effects.base import Effect, EffectContext
from ...effects.empirical.curves import LEAST
from ...effects.temperature.thermal_softening import ROOM
from ...expressions.ops import LoadColumns
from ...loads import LOAD_NAMES, FloatArray, TriboLoads
from ..campaign.binned_tests import BinnedTests
from ..campaign.metadata import metadata_spans
from .checked_call import called, finite, shaped
from .memory import OPS, check_step, integrate

#: Tests that begin so far above room temperature, in parts of the range of their temperatures, show nothing of what a film does at it.
FAR = 0.5
#: A range of a load that holds less than this share of the points counts as untested; so do the outer points on either side.
THIN, OUTER = 0.01, 0.025


@dataclass
class Candidate:
    """One effect at g sets of shape parameters."""

    effect: Effect
    shapes: dict[str, FloatArray]  #: Shape parameters of every set, each of shape (g,).
    columns: FloatArray  #: Bin means of the basis, shape (m, g, amplitudes).

    def shape_at(self, k: int) -> dict[str, float]:
        """Return the shape parameters of set `k`."""
        return {name: float(values[k]) for name, values in self.shapes.items()}


def load_columns(loads: TriboLoads) -> LoadColumns:
    """Return the loads as columns for a formula."""
    return LoadColumns(*(getattr(loads, n)[:, None] for n in LOAD_NAMES))


def tested_ranges(loads: TriboLoads) -> dict[str, tuple[float, ...]]:
    """Return lowest and highest value of each load, ``range of T``, and its widest untested part and that of its logarithm.

    The untested parts are shares of the range. Three speeds in equal steps leave 0.5; values everywhere leave about 0.01.
    """
    found: dict[str, tuple[float, ...]] = {}
    for name, values in zip(LOAD_NAMES, loads.as_array().T, strict=True):
        low, high = float(values.min()), float(values.max())
        logarithms = np.log(np.maximum(values, max(LEAST * high, 1e-300)))
        found[f"range of {name}"] = (low, high, _untested(values), _untested(logarithms))
    return found


def _untested(values: FloatArray) -> float:
    size = float(np.ptp(values))
    outer, thin = int(OUTER * len(values)), max(int(THIN * len(values)), 1)
    inner = np.sort(values)[outer : len(values) - outer]
    return float(np.max(inner[thin:] - inner[:-thin], initial=0.0)) / size if size > 0.0 else 0.0


def spans_of(campaign: BinnedTests, mu: FloatArray) -> dict[str, tuple[float, ...]]:
    """Return the range of each load and of the derived quantities that scan grids follow, and what metadata take.

    `mu`, shape (n,), is the friction coefficient of the base model, for friction work and flash heating.
    """
    loads = campaign.loads
    sliding = loads.v_rel[loads.v_rel > 0.0]
    if sliding.size == 0:
        sliding = np.array([1.0])
    spans: dict[str, tuple[float, ...]] = {
        "v_rel": _span(sliding),
        "T": _span(loads.T),
        "sigma_n": _span(loads.sigma_n),
        "sd": _span(loads.sd),
        "psi": _span(loads.psi),
        "hersey": _span(loads.v_rel / np.maximum(loads.sigma_n, 1e-9)),
        "sigma_n_hot": _span(loads.sigma_n * np.exp(0.005 * np.clip(loads.T - 20.0, 0.0, 1000.0))),
        "flash": _span(np.maximum(mu, 1e-6) * loads.sigma_n * np.sqrt(loads.v_rel)),
    }
    spans |= tested_ranges(loads)
    lasts = campaign.point_lasts
    lengths = campaign.distance[lasts]
    work = np.maximum(mu, 1e-6) * loads.sigma_n * 1e-3
    totals = (
        np.array([work[a : b + 1].mean() for a, b in zip(campaign.point_starts, lasts, strict=True)])
        * lengths
    )
    spans["work"] = (0.05 * float(np.max(totals)), float(np.max(totals)))
    coldest = float(loads.T.min())
    cold = ROOM if 0.0 < coldest - ROOM < FAR * float(np.ptp(loads.T)) else coldest
    spans["T_cold"] = (cold, cold)
    spans["T_rise"] = (0.1 * (spans["T"][1] - cold), max(spans["T"][1] - cold, 1.0))
    rise = max(spans["psi"][1] - 1.0, 1e-3)
    spans["psi_rise"] = (0.1 * rise, rise)
    slow, length = spans["v_rel"][0], float(np.median(lengths))
    spans["v_rel_low"] = (slow, slow)
    spans["distance"] = (length * 1e-3, length)
    spans["duration"] = (length / slow, length / slow)  # of a slow test
    if "batch" in campaign.system:
        spans["batch"] = tuple(map(float, np.unique(campaign.system["batch"])))
    return spans | metadata_spans(campaign.loads, campaign.system)


def _span(values: FloatArray) -> tuple[float, float]:
    low, high = np.quantile(values, [0.03, 0.98])
    return float(low), float(high)


def evaluate(
    effect: Effect, campaign: BinnedTests, mu: FloatArray, grids: Mapping[str, FloatArray]
) -> Candidate:
    """Evaluate an effect over the product of its scan values, by shape parameter, and average it into bins.

    `mu`, shape (n,), is the friction coefficient that effects which need one see (the base model's, not the measured one).
    """
    names = list(grids)
    mesh = np.meshgrid(*(grids[n] for n in names), indexing="ij") if names else []
    shapes = {n: g.ravel() for n, g in zip(names, mesh, strict=True)}
    rows = {n: g[None, :] for n, g in shapes.items()}
    sets = mesh[0].size if names else 1
    columns = bin_means(effect, campaign, mu, rows, sets)
    if effect.states:
        check_step(effect, campaign, mu, rows)
    return Candidate(effect, shapes, columns)


def evaluate_all(
    effects: Iterable[Effect], campaign: BinnedTests, mu: FloatArray, spans: Mapping[str, tuple[float, ...]]
) -> tuple[list[Candidate], list[str]]:
    """Evaluate effects over their scan values; return them with a note on each one that cannot be evaluated."""
    candidates, notes = [], []
    for effect in effects:
        try:
            candidates.append(evaluate(effect, campaign, mu, _scan_values(effect, spans)))
        except InputError as error:
            notes.append(f"{effect.name} was not tested: {error}")
    return candidates, notes


def _scan_values(effect: Effect, spans: Mapping[str, tuple[float, ...]]) -> dict[str, FloatArray]:
    try:
        return effect.grids(spans)
    except Exception as error:
        raise InputError(
            f"effect {effect.name!r}: grids fails ({type(error).__name__}: {str(error)[:200]})"
        ) from error


def bin_means(
    effect: Effect,
    campaign: BinnedTests,
    mu: FloatArray,
    shape: Mapping[str, FloatArray | float],
    sets: int = 1,
) -> FloatArray:
    """Return the bin means of the basis of an effect at `sets` sets of shape parameters, shape (m, sets, amplitudes).

    A few averages of neighbouring points tell the mean of a bin.
    """
    mu = campaign.over_pieces(mu) if effect.needs_mu else campaign.pieces.mu
    campaign = campaign.pieces
    columns = evaluate_points(effect, campaign, mu, shape)
    full = (np.ascontiguousarray(shaped(effect, "basis", c, (len(mu), sets))) for c in columns)
    return np.stack([campaign.average(c) for c in full], axis=2)


def evaluate_points(
    effect: Effect, campaign: BinnedTests, mu: FloatArray, shape: Mapping[str, FloatArray | float]
) -> tuple[FloatArray, ...]:
    """Return the basis of an effect on all points, one array [n, g] an amplitude.

    Raises InputError: a method of the effect fails, or no set of shape parameters gives finite numbers.
    """
    L = load_columns(campaign.loads)
    system = campaign.system
    state: dict[str, FloatArray] = {}
    with np.errstate(all="ignore"):  # what is not finite is told of the effect
        if effect.states:
            state = integrate(effect, campaign, mu, shape)
        memory = EffectContext(mu=mu[:, None], state=state, system=system)
        columns = called(effect, "basis", len(effect.amplitudes), OPS, L, shape, memory)
    finite(effect, "basis", columns, shape)
    return columns


def contribution(
    effect: Effect,
    campaign: BinnedTests,
    mu: FloatArray,
    shape: Mapping[str, FloatArray | float],
    amplitudes: Iterable[float],
) -> FloatArray:
    """Return what an effect with these parameters adds to mu on all points, shape (n,)."""
    columns = evaluate_points(effect, campaign, mu, shape)
    parts = zip(amplitudes, columns, strict=True)
    return np.asarray(sum(a * np.broadcast_to(c, (len(mu), 1))[:, 0] for a, c in parts))
