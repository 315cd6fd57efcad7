"""How far further tests would tell two effects apart.

Both effects may deviate from their formulas as in the ranking (`form_error`), so the expected lead is one of evidence. A lead
that `significance.confusion_set` would not count is not promised.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement, product

import numpy as np

from ...effects.base import Memory
from ...estimation.campaign.binning import Campaign
from ...estimation.campaign.curves import curve, on_scale
from ...estimation.search.base_law import BaseLaw
from ...estimation.search.candidates import OPS, integrate, load_columns
from ...estimation.search.form_error import KNOTS, bends, evidence, form_variance
from ...estimation.search.scan import Fit, Prepared, Projector, best_fit, drops, prepare_candidate
from ...estimation.search.search_round import SearchRound
from ...estimation.search.significance import SAME, TWINS
from ...loads import LOAD_NAMES, FloatArray, TriboLoads
from .protocols import POINTS, Proposal, Settings

#: Standard errors that are enough: rivals that are further apart leave the confusion set.
ENOUGH = 3.0
#: Constant tests of one proposal.
SEVERAL = 3
#: Sets of shape parameters of an effect that are tried, of those that were scanned.
SHAPES = 100
#: A shape is possible if its squared error in the existing tests exceeds that of the best one by less than this.
ALLOWED = 6.0


@dataclass(frozen=True)
class Separation:
    """Standard errors by which tests tell two effects apart: against noise, and also against errors of the formulas."""

    noise: float
    t: float


def separated(before: float, after: float, whole: float, likeness: float = 0.0) -> Separation:
    """Return the standard errors by which a lead grows; below `ENOUGH` if it may come from the formulas.

    Parameters
    ----------
    before, after : float
        Lead in evidence of one effect over another without and with further tests.
    whole : float
        Evidence of the leading effect with them.
    likeness : float
        Correlation of the two contributions with them.
    """
    growth = float(np.sqrt(max(after - before, 0.0)))
    lead = np.sqrt(max(after, 0.0) / max(SAME * whole, 1e-12))
    unlike = np.sqrt(max(1.0 - likeness, 0.0) / (1.0 - TWINS))
    return Separation(growth, min(growth, ENOUGH * float(min(lead, unlike))))


@dataclass(frozen=True)
class Lead:
    """By how much evidence the true effect leads, of how much of its own, and the correlation of the two."""

    evidence: float
    whole: float
    likeness: float


@dataclass(frozen=True)
class Weighed:
    """Evidence of an effect for a signal, its correlation with it, deviations of its form and the variance of each."""

    evidence: float
    likeness: float
    q: FloatArray
    variance: float


class Bench:
    """Existing and new tests with the same noise floor."""

    def __init__(self, campaign: Campaign, found: SearchRound, mu: FloatArray, base: BaseLaw) -> None:
        self.campaign, self.found = campaign, found
        family = base.name.split("+")[0]
        self.degree = {"constant": 0, "polynomial": 2}.get(family, 1)
        array = campaign.loads.as_array()
        self.centre = array.mean(axis=0)
        spread = array.std(axis=0)
        self.scale = np.where(spread > 1e-9 * np.maximum(1.0, np.abs(self.centre)), spread, np.inf)
        self.base = self.terms(campaign.average(array))
        # mu drives heat and work of an effect: along a new test it changes as the base says
        self.friction = np.linalg.lstsq(self.base, campaign.average(mu), rcond=1e-9)[0]
        self.before: dict[tuple[str, str], float] = {}
        self.there = Stack(self, [])

    def terms(self, loads: FloatArray) -> FloatArray:
        """Return what the base may follow, shape (n, p)."""
        z = (loads - self.centre) / self.scale
        columns = [np.ones(len(z))]
        for d in range(1, self.degree + 1):
            columns += [np.prod(z[:, list(c)], axis=1) for c in combinations_with_replacement(range(5), d)]
        return np.column_stack(columns)

    def separation(self, first: Fit, second: Fit, tests: Sequence[TriboLoads]) -> Separation:
        """Return how far the tests would tell two effects apart, whichever is true, unless the lead is clear already."""
        with_them = Stack(self, tests)
        clear = first.evidence - second.evidence >= max(SAME * first.evidence, ENOUGH**2)
        each = []
        for truth, rival in ((first, second),) if clear else ((first, second), (second, first)):
            pair = (truth.name, rival.name)
            if pair not in self.before:
                self.before[pair] = self.there.lead(truth, rival).evidence
            after = with_them.lead(truth, rival)
            now = truth.evidence - rival.evidence
            each.append(separated(now, now + after.evidence - self.before[pair], after.whole, after.likeness))
        return min(each, key=lambda s: s.t)

    def plausible(self, fit: Fit) -> list[tuple[int, FloatArray, float]]:
        """Return shapes of an effect that the existing tests allow: index in `sets`, amplitudes, weight."""
        prepared, chosen = fit.prepared, self.sets(fit)
        scores = np.einsum("mga,m->ga", prepared.columns, self.found.residual)
        drop, amplitudes = drops(prepared, scores)
        least = drop[fit.index] - ALLOWED
        found = [
            (k, amplitudes[g], float(np.exp(0.5 * (drop[g] - drop[fit.index]))))
            for k, g in enumerate(chosen)
            if drop[g] > max(least, 0.0)
        ]
        return found or [(chosen.index(fit.index), fit.amplitudes, 1.0)]

    @staticmethod
    def sets(fit: Fit) -> list[int]:
        """Return the sets of shape parameters that are tried: the best one, and some of the others evenly."""
        count = fit.prepared.candidate.columns.shape[1]
        some = np.linspace(0, count - 1, min(count, SHAPES)).round().astype(int)
        return sorted({int(k) for k in some} | {fit.index})

    def basis(self, fit: Fit, loads: TriboLoads) -> FloatArray:
        """Return the basis of an effect along a new test, [POINTS, g, amplitudes]."""
        candidate = fit.prepared.candidate
        effect = candidate.effect
        chosen = self.sets(fit)
        shape = {name: values[None, chosen] for name, values in candidate.shapes.items()}
        sets = len(chosen)
        system = {k: np.full((POINTS, 1), float(v.mean())) for k, v in self.campaign.system.items()}
        friction = np.maximum(self.terms(loads.as_array()) @ self.friction, 1e-4)
        made = Campaign(
            loads, friction, ["new"], np.array([0]), np.arange(POINTS), np.ones(POINTS),
            np.zeros(POINTS, dtype=int), np.arange(POINTS), loads.sd, system,
        )  # fmt: skip
        state = integrate(effect, made, made.mu, shape) if effect.states else {}
        basis = effect.basis(OPS, load_columns(loads), shape, Memory(made.mu[:, None], state, system))
        return np.stack([np.broadcast_to(b, (POINTS, sets)) for b in basis], axis=2)

    def root(self, loads: TriboLoads) -> FloatArray:
        """Return what whitens a new test: its own offset, drift along it, sensor noise."""
        floor = self.found.floor
        gaps = np.abs(loads.sd[:, None] - loads.sd[None, :])
        points = max(float(self.campaign.count.sum()) / len(self.campaign.tests) / POINTS, 1.0)
        S = floor.test**2 + floor.drift**2 * np.exp(-gaps / max(floor.drift_length, 1e-9))
        S[np.diag_indices(POINTS)] += max(floor.bin_sensor**2 / points, 1e-12)
        return np.asarray(np.linalg.inv(np.linalg.cholesky(S)))

    def points(self, first: Fit, second: Fit) -> tuple[Proposal, Separation] | None:
        """Return the constant tests at corners of the plan that separate the effects best, and by how much."""
        s = Settings.of(self.campaign)
        corners = list(product(*(sorted({x[0], x[2]}) for x in (s.pressure, s.speed, s.tool))))
        if len(corners) < 2:
            return None

        def loads(corner: tuple[float, ...]) -> TriboLoads:
            sigma, v, tool = corner
            return s.loads(np.full(POINTS, v), np.full(POINTS, sigma), tool, s.distance)

        each = [self.separation(first, second, [loads(c)]).noise for c in corners]
        best = [corners[k] for k in np.argsort(each)[::-1][:SEVERAL]]
        rows = [s.row(sigma, v, tool, s.distance) for sigma, v, tool in best]
        names = ("sigma_n [MPa]", "v_rel [mm/s]", "T_tool [degC]")
        shown = s.shown({n: [c[k] for c in best] for k, n in enumerate(names)})
        t = self.separation(first, second, [loads(c) for c in best])
        return Proposal("points of the plan", shown, rows, []), t


class Stack:
    """Existing tests with some new ones, whitened, and the base refitted on both.

    Parameters
    ----------
    bench : Bench
    tests : sequence of TriboLoads
        Loads along each new test.
    """

    def __init__(self, bench: Bench, tests: Sequence[TriboLoads]) -> None:
        self.bench, self.tests = bench, tests
        self.roots = [bench.root(loads) for loads in tests]
        terms = np.vstack([bench.base, *(bench.terms(x.as_array()) for x in tests)])
        self.project = Projector(self._white(terms))
        self.curves: dict[str, FloatArray] = {}
        self.ready: dict[str, Prepared] = {}

    def lead(self, truth: Fit, rival: Fit) -> Lead:
        """Return by how much the true one of two effects should lead.

        The true effect has shapes that the existing tests allow, and deviations from its formula. Both effects are judged
        as in the ranking. The result is the median over the shapes.
        """
        own, other = self._prepared(truth), self._prepared(rival)
        each, weights = [], []
        for k, amplitudes, weight in self.bench.plausible(truth):
            signal = self.project(self._white(own.candidate.columns[:, k] @ amplitudes))
            each.append(self._lead(own, other, signal))
            weights.append(weight)
        order = np.argsort([e.evidence for e in each])
        below = np.cumsum(np.array(weights)[order])
        return each[order[min(int(np.searchsorted(below, 0.5 * below[-1])), len(each) - 1)]]

    def _lead(self, truth: Prepared, rival: Prepared, signal: FloatArray) -> Lead:
        own, other = self._weighed(truth, signal), self._weighed(rival, signal)
        taken = [w.variance / (1.0 + w.variance) for w in (own, other)]
        # noise that passes for deviations
        noise = own.q.shape[1] * taken[0] - other.q.shape[1] * taken[1]
        # of the deviations of nature the true effect takes up its share, the rival what lies along its own
        seen = own.q.shape[1] * taken[0] - taken[1] * float(np.sum((other.q.T @ own.q) ** 2))
        return Lead(own.evidence - other.evidence + noise + own.variance * seen, own.evidence, other.likeness)

    def _weighed(self, prepared: Prepared, signal: FloatArray) -> Weighed:
        best = best_fit(prepared, signal)
        q = self._deviations(best)
        own = best.signal
        size = float(np.sqrt((own @ own) * (signal @ signal)))
        likeness = float(own @ signal) / size if size > 0.0 else 0.0
        return Weighed(evidence(best, q, signal), likeness, q, form_variance(best, max(q.shape[1], 1)))

    def _prepared(self, fit: Fit) -> Prepared:
        """Return an effect at some shapes in old tests and new ones."""
        if fit.name not in self.ready:
            old = fit.prepared.candidate.columns[:, self.bench.sets(fit)]
            columns = np.concatenate([old, *(self.bench.basis(fit, loads) for loads in self.tests)])
            candidate = replace(fit.prepared.candidate, columns=columns)
            self.ready[fit.name] = prepare_candidate(candidate, self._white, self.project)
        return self.ready[fit.name]

    def _deviations(self, fit: Fit) -> FloatArray:
        """Return orthonormal deviations of the form, as `FormErrors` has them."""
        loads = [
            d for d in fit.prepared.candidate.effect.driver if d in LOAD_NAMES and np.ptp(self._load(d)) > 0.0
        ]
        blocks = [self._curve(n) for n in loads]
        if len(loads) > 1:
            blocks.append(self.project(self._white(bends(fit.binned))))
        return Projector(np.column_stack(blocks)).q if blocks else np.empty((len(fit.binned), 0))

    def _curve(self, name: str) -> FloatArray:
        if name not in self.curves:
            self.curves[name] = self.project(self._white(curve(on_scale(name, self._load(name)), KNOTS)))
        return self.curves[name]

    def _load(self, name: str) -> FloatArray:
        campaign = self.bench.campaign
        old = campaign.distance if name == "sd" else getattr(campaign.loads, name)
        return np.concatenate([campaign.average(old), *(getattr(x, name) for x in self.tests)])

    def _white(self, values: FloatArray) -> FloatArray:
        """Return whitened values of old and new tests, shape (m, ...)."""
        flat = values.reshape(len(values), -1)
        count = len(self.bench.campaign.starts)
        parts = [self.bench.found.whiten(flat[:count])]
        parts += [r @ flat[count + k * POINTS : count + (k + 1) * POINTS] for k, r in enumerate(self.roots)]
        return np.concatenate(parts).reshape(values.shape)
