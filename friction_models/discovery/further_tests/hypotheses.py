"""What may be true by the existing tests, and what each possibility predicts of further ones.

A hypothesis is the base, refitted, with one effect whose form may deviate from its formula by smooth curves along its loads, as
the ranking allows it (`estimation.search.form_error`); or with any smooth curves along all loads: none of the catalogue. The
existing tests leave the coefficients of each normally distributed, one normal distribution for each set of shape parameters
that they allow. A lead in evidence that may be a matter of formulas rules no shape out: a rival can be refitted to a new test.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement

import numpy as np

from ...effects.base import EffectContext
from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.noise.regular import regular_root
from ...estimation.search.base_law import BaseLaw
from ...estimation.search.candidates import load_columns
from ...estimation.search.form_error import FORM_ERROR
from ...estimation.search.memory import OPS, integrate
from ...estimation.search.rivalry import rivalry
from ...estimation.search.scan import Fit, drops
from ...estimation.search.search_round import SearchRound
from ...estimation.search.unseen_loads import driven_by_load
from ...loads import LOAD_NAMES, FloatArray, TriboLoads
from ...loads.contract import ORDER
from .deviations import Deviations
from .formula_error import owed
from .information import Outcomes
from .protocols import POINTS, PlannedTest

#: Averages along a new test, finer near its start, as exponent of their edges.
PARTS, FINENESS = 10, 1.5
#: Sets of shape parameters of an effect that are looked at, and that stand for all that are possible.
LOOKED_AT, SHAPES = 100, 8
#: A set that is less likely than the best one by this factor is left out.
UNLIKELY = 0.02
#: "None of the catalogue" explains as much as the best effect does.
NONE_SIZE = 1.0
#: Least share of smooth curves that counts as seen beside the base. Loads of two levels show none: a straight line takes up all of it.
SEEN = 0.01
#: Relative prior precision of what is not bounded, and least one of anything; keeps equations regular.
FLAT = 1e-8


@dataclass(frozen=True)
class _Possible:
    """One set of shapes of a hypothesis: coefficients of base, effect and deviations."""

    index: int | None  #: Which set of shapes; None for "none of the catalogue".
    used: list[int]  #: Amplitudes that are not zero.
    share: float  #: Of the hypothesis.
    mean: FloatArray  #: Shape (d,).
    root: FloatArray  #: The covariance is ``root @ root.T``, shape (d, d).


class Hypotheses:
    """Effects that may be true, and "none of the catalogue" as the last one.

    `mu`, shape (n,), is the friction of the base at every point, for effects that need one; `prior`, shape (len(fits) + 1,),
    the probability of each effect, that of none last; `tests` are all that may be asked for. Effects that are `given` are there
    whichever holds, with the shapes of their fits; the search `found` was made beside them. A lead in evidence counts for 1/`allowance`.
    Effects that no load drives count as one: no setting of a rig tells them apart. `place` holds the number of each effect.
    """

    def __init__(
        self,
        campaign: BinnedTests,
        found: SearchRound,
        mu: FloatArray,
        base: BaseLaw,
        fits: Sequence[Fit],
        prior: FloatArray,
        tests: Sequence[PlannedTest],
        given: Sequence[Fit] = (),
        allowance: float = 1.0,
    ) -> None:
        self.given, self.allowance = given, allowance
        self.campaign, self.found, self.fits, self.prior = campaign, found, list(fits), prior
        unloaded = [f for f in self.fits if not driven_by_load(f.effect)]
        self.names = [f.name for f in self.fits if f not in unloaded[1:]]
        self.place = {f.name: self.names.index((unloaded[0] if f in unloaded else f).name) for f in self.fits}
        self._owner = [*self.place.values(), len(self.names)]
        self._joined = np.asarray(np.bincount(self._owner, prior), dtype=np.float64)
        family = base.name.split("+")[0]
        self.degree = 0 if base.columns.shape[1] == 1 else {"polynomial": 2}.get(family, 1)
        array = campaign.loads.as_array()
        self.centre = array.mean(axis=0)
        spread = array.std(axis=0)
        self.scale = np.where(spread > 1e-9 * np.maximum(1.0, np.abs(self.centre)), spread, np.inf)
        # mu drives heat and work of an effect: along a new test it changes as the base says
        levels = self.terms(campaign.average(array), max(self.degree, 1))
        self.friction = np.linalg.lstsq(levels, campaign.average(mu), rcond=1e-9)[0]
        self.farthest = float(campaign.loads.sd.max())
        self.deviations = Deviations(campaign, tests)
        self._white_base = found.whiten(self.terms(campaign.average(array)))
        self._white_y = found.whiten(found.y)
        self._tests = tests  # kept, so that no other test gets the identity by which one is known below
        self._new: dict[tuple[int, str], FloatArray] = {}
        # Where existing tests do not follow the formulas to the noise, new ones will not either.
        doubts = [rivalry(campaign, found, fits[:1], [f]).overdispersion for f in fits[1:]]
        self.overdispersion = float(np.average(doubts, weights=prior[1:-1])) if doubts else 1.0
        best = {k: max(f.evidence for f in fits if self.place[f.name] == k) for k in range(len(self.names))}
        self._owed = owed(np.array([*best.values(), max(best.values())]), allowance) / self.overdispersion
        self.possible = [self._of_effect(f) for f in self.fits] + [self._of_none()]

    def terms(self, loads: FloatArray, degree: int | None = None) -> FloatArray:
        """Return what the base may follow, shape (n, p)."""
        z = (loads - self.centre) / self.scale
        columns = [np.ones(len(z))]
        for d in range(1, (self.degree if degree is None else degree) + 1):
            columns += [np.prod(z[:, list(c)], axis=1) for c in combinations_with_replacement(range(5), d)]
        return np.column_stack(columns)

    def _ahead(self, loads: TriboLoads, degree: int | None = None) -> FloatArray:
        """Return what the base may follow along a further test, shape (n, p).

        Beyond the tested distance it stays level. Its trend along the tests makes up for what an effect does there, by another
        amount beside each effect; carried on it would tell them apart by what none of them says.
        """
        array = loads.as_array()
        column = LOAD_NAMES.index("sd")
        array[:, column] = np.minimum(array[:, column], self.farthest)
        return self.terms(array, degree)

    # --- what the existing tests leave ------------------------------------------------------------

    def _of_effect(self, fit: Fit) -> list[_Possible]:
        """Return the sets of shapes of an effect that are possible, with their coefficients."""
        prepared, found = fit.prepared, self.found
        chosen = self._sets(fit)
        bends = self.deviations.old(self._curved(fit))
        white = found.whiten(bends)
        beyond = found.project(white)
        u, s, _ = np.linalg.svd(beyond, full_matrices=False)
        variance = _variance(FORM_ERROR**2 * float(fit.signal @ fit.signal), white, beyond)
        taken = variance * s**2 / (self.allowance + variance * s**2)
        some = prepared.columns[:, chosen]
        m, sets, amplitudes = some.shape
        along = (u.T @ some.reshape(m, -1)).reshape(-1, sets, amplitudes)
        gram = prepared.gram[chosen] - np.einsum("k,kga,kgb->gab", taken, along, along)
        scores = np.einsum("mga,m->ga", some, found.residual) - np.einsum(
            "kga,k->ga", along, taken * (u.T @ found.residual)
        )
        part = replace(prepared, columns=some, gram=gram, usable=prepared.usable[chosen])
        drop, best = drops(part, scores)
        likely = np.exp(0.5 * (drop - drop.max()) / self.allowance) * (drop > 0.0)
        likely = np.where(likely < UNLIKELY, 0.0, likely)
        if not likely.any():
            likely[chosen.index(fit.index)] = 1.0
            best[chosen.index(fit.index)] = fit.amplitudes
        below = np.cumsum(likely) / likely.sum()
        picked = np.searchsorted(below, (np.arange(SHAPES) + 0.5) / SHAPES)
        result = []
        for g, count in zip(*np.unique(np.minimum(picked, sets - 1), return_counts=True), strict=True):
            used = np.flatnonzero(best[g]).tolist()
            columns = prepared.candidate.columns[:, chosen[g]][:, used]
            result.append(self._posterior(int(chosen[g]), used, count / SHAPES, columns, bends, variance))
        return result

    def _of_none(self) -> list[_Possible]:
        """Return smooth curves along all loads, together as large as the best effect."""
        found = self.found
        bends = self.deviations.old(self._varied)
        white = found.whiten(bends)
        best = max((float(f.signal @ f.signal) for f in self.fits), default=0.0)
        variance = _variance(NONE_SIZE * max(best, 1.0), white, found.project(white))
        return [self._posterior(None, [], 1.0, np.empty((len(bends), 0)), bends, variance)]

    def _posterior(
        self,
        index: int | None,
        used: list[int],
        share: float,
        columns: FloatArray,
        bends: FloatArray,
        variance: float,
    ) -> _Possible:
        white = self.found.whiten
        columns = np.column_stack([columns, *(f.columns for f in self.given)])
        design = np.column_stack([self._white_base, white(columns), white(bends)]) / np.sqrt(self.allowance)
        scale = np.linalg.norm(design, axis=0)
        scale = np.where(scale > 0.0, scale, 1.0)
        design = design / scale
        free = self._white_base.shape[1] + columns.shape[1]
        precision = design.T @ design
        precision[np.diag_indices(len(scale))] += np.r_[
            np.full(free, FLAT), 1.0 / np.clip(variance * scale[free:] ** 2, 1e-12, 1.0 / FLAT)
        ]
        root = np.linalg.inv(regular_root(precision)).T
        mean = root @ (root.T @ (design.T @ self._white_y)) / np.sqrt(self.allowance)
        return _Possible(index, used, share, mean / scale, root / scale[:, None])

    @staticmethod
    def _sets(fit: Fit) -> list[int]:
        """Return the sets of shape parameters that are looked at: the best one, and some of the others evenly."""
        count = fit.prepared.candidate.columns.shape[1]
        some = np.linspace(0, count - 1, min(count, LOOKED_AT)).round().astype(int)
        return sorted({int(k) for k in some} | {fit.index})

    @property
    def _varied(self) -> list[str]:
        return [n for n in LOAD_NAMES if self.campaign.varies(n)]

    def _curved(self, fit: Fit | None) -> list[str]:
        """Return the loads along which the form of an effect may deviate."""
        if fit is None:
            return self._varied
        return [d for d in fit.effect.driver if d in self._varied]

    # --- what further tests would show ------------------------------------------------------------

    def predict(self, tests: Sequence[PlannedTest], noise: float = 1.0) -> Outcomes:
        """Return what each hypothesis predicts of some tests, run once each.

        `noise` is a factor on the variance of offset, drift and sensor: 1/n for the mean of n repeats.
        """
        fits = [*self.fits, None]
        owner, share, means, covariances = [], [], [], []
        scatter = np.zeros((PARTS * len(tests),) * 2)
        for k, test in enumerate(tests):
            scatter[k * PARTS : (k + 1) * PARTS, k * PARTS : (k + 1) * PARTS] = (
                noise * self.overdispersion * self._scatter(test)
            )
        for h, (fit, sets) in enumerate(zip(fits, self.possible, strict=True)):
            order = [p.index for p in sets if p.index is not None]
            known = [
                (
                    _parts(self._ahead(t.loads)),
                    [*(self._basis(f, [f.index], t)[:, 0] for f in self.given), self._bends(fit, t)],
                )
                for t in tests
            ]
            for p in sets:
                rows = []
                for test, (base, others) in zip(tests, known, strict=True):
                    columns = [base, *others]
                    if fit is not None and p.index is not None:
                        columns.insert(1, self._basis(fit, order, test)[:, order.index(p.index)][:, p.used])
                    rows.append(np.column_stack(columns))
                design = np.concatenate(rows)
                spread = design @ p.root
                owner.append(self._owner[h])
                share.append(p.share * self.prior[h] / self._joined[self._owner[h]])
                means.append(design @ p.mean)
                covariances.append(spread @ spread.T + scatter)
        normal = np.array(owner), np.array(share), np.array(means), np.array(covariances)
        return Outcomes(self._joined, *normal, self._owed)

    def _scatter(self, test: PlannedTest) -> FloatArray:
        """Return the covariance of the parts of a new test: its own offset, drift along it, sensor noise."""
        floor, sd = self.found.floor, test.loads.sd
        points = max(float(self.campaign.count.sum()) / len(self.campaign.tests) / POINTS, 1.0)
        S = floor.test**2 + floor.drift**2 * np.exp(-np.abs(sd[:, None] - sd) / max(floor.drift_length, 1e-9))
        S[np.diag_indices(POINTS)] += max(floor.bin_sensor**2 / points, 1e-12)
        return _parts(_parts(S).T)

    def _bends(self, fit: Fit | None, test: PlannedTest) -> FloatArray:
        """Return the deviations from a formula in the parts of a new test, [PARTS, k]."""
        return _parts(self.deviations.new(self._curved(fit), test.loads))

    def _basis(self, fit: Fit, chosen: list[int], test: PlannedTest) -> FloatArray:
        """Return the basis of an effect in the parts of a new test, by set of shapes, [PARTS, sets, amplitudes]."""
        key = (id(test), fit.name)
        if key not in self._new:
            self._new[key] = self._bases(fit, chosen, test)
        return self._new[key]

    def _bases(self, fit: Fit, chosen: list[int], test: PlannedTest) -> FloatArray:
        candidate = fit.prepared.candidate
        effect, loads = candidate.effect, test.loads
        shape = {name: values[chosen][None, :] for name, values in candidate.shapes.items()}
        system = {
            k: np.full((POINTS, 1), self._metadata(k, v, test)) for k, v in self.campaign.system.items()
        }
        friction = np.maximum(self._ahead(loads, max(self.degree, 1)) @ self.friction, 1e-4)
        made = BinnedTests(
            loads, friction, ["new"], np.array([0]), np.arange(POINTS), np.ones(POINTS),
            np.zeros(POINTS, dtype=int), np.arange(POINTS), loads.sd, system,
        )  # fmt: skip
        state = integrate(effect, made, made.mu, shape) if effect.states else {}
        basis = effect.basis(OPS, load_columns(loads), shape, EffectContext(made.mu[:, None], state, system))
        full = np.stack([np.broadcast_to(b, (POINTS, len(chosen))) for b in basis], axis=2)
        return _parts(full.reshape(POINTS, -1)).reshape(PARTS, *full.shape[1:])

    def _metadata(self, name: str, values: FloatArray, test: PlannedTest) -> float:
        """Return metadata of a new test: what the plan sets, the next place in the run order, else the usual value."""
        given = test.row.get(name)
        if isinstance(given, float):
            return given
        if name == ORDER:
            return float(values.max()) + 1.0
        levels, counts = np.unique(values[self.campaign.point_starts], return_counts=True)
        return float(levels[np.argmax(counts)])


def _variance(size: float, white: FloatArray, beyond: FloatArray) -> float:
    """Return the variance of the coefficients with which smooth curves are of this size where the base leaves them to be seen.

    Where it leaves nearly nothing, all of the curve counts: what no test can show is not large for that.
    """
    return size / max(float(np.sum(beyond**2)), SEEN * float(np.sum(white**2)), 1e-300)


def _parts(values: FloatArray) -> FloatArray:
    """Return means over the parts of a test, shape (PARTS, ...)."""
    edges = np.unique(np.round(POINTS * (np.arange(PARTS) / PARTS) ** FINENESS).astype(int))
    counts = np.diff(np.r_[edges, POINTS]).astype(float)
    return np.asarray(np.add.reduceat(values, edges, axis=0) / counts.reshape(-1, *(1,) * (values.ndim - 1)))
