"""How far further tests would tell two effects apart."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations_with_replacement, product

import numpy as np

from ..effects.base import Memory
from ..loads import FloatArray, TriboLoads
from .analysis import Round
from .base_law import BaseLaw
from .binning import Campaign
from .candidates import OPS, integrate, load_columns
from .protocols import POINTS, READING, Proposal, Settings
from .scan import Fit, Projector

#: Independent readings of a force cell in one second without load.
READINGS = 20.0
#: Constant tests of one proposal.
SEVERAL = 3
#: Shapes of a rival that are tried.
SHAPES = 20


class Bench:
    """Tests that are there and new ones, seen through the same noise floor."""

    def __init__(self, campaign: Campaign, found: Round, mu: FloatArray, base: BaseLaw) -> None:
        self.campaign, self.found, self.typical = campaign, found, float(np.median(mu))
        family = base.name.split("+")[0]
        self.degree = {"constant": 0, "polynomial": 2}.get(family, 1)
        array = campaign.loads.as_array()
        self.centre = array.mean(axis=0)
        spread = array.std(axis=0)
        self.scale = np.where(spread > 1e-9 * np.maximum(1.0, np.abs(self.centre)), spread, np.inf)
        self.old_base = found.whiten(self._terms(campaign.average(array)))
        self.old: dict[str, FloatArray] = {}

    def _terms(self, loads: FloatArray) -> FloatArray:
        z = (loads - self.centre) / self.scale
        columns = [np.ones(len(z))]
        for d in range(1, self.degree + 1):
            columns += [np.prod(z[:, list(c)], axis=1) for c in combinations_with_replacement(range(5), d)]
        return np.column_stack(columns)

    def separation(self, first: Fit, second: Fit, tests: Sequence[TriboLoads]) -> float:
        """Return by how many standard errors the tests would tell two effects apart, whichever is true."""
        before = min(self._distance(a, b, []) for a, b in ((first, second), (second, first)))
        after = min(self._distance(a, b, tests) for a, b in ((first, second), (second, first)))
        return float(np.sqrt(max(after - before, 0.0)))

    def _distance(self, truth: Fit, rival: Fit, tests: Sequence[TriboLoads]) -> float:
        """Return the whitened squared error that the rival leaves where `truth` holds."""
        roots = [self._root(loads) for loads in tests]
        base = np.vstack(
            [self.old_base, *(r @ self._terms(x.as_array()) for r, x in zip(roots, tests, strict=True))]
        )
        project = Projector(base)
        signal = (
            self._stacked(truth, roots, tests)[:, self._sets(truth).index(truth.index)] @ truth.amplitudes
        )
        signal = project(signal)
        columns = project(self._stacked(rival, roots, tests))
        power = float(signal @ signal)
        gram = np.einsum("mga,mgb->gab", columns, columns)
        score = np.einsum("mga,m->ga", columns, signal)
        ridge = 1e-9 * np.trace(gram, axis1=1, axis2=2)[:, None, None] * np.eye(
            gram.shape[1]
        ) + 1e-30 * np.eye(gram.shape[1])
        explained = np.einsum("ga,ga->g", score, np.linalg.solve(gram + ridge, score[:, :, None])[:, :, 0])
        return max(power - float(explained.max()), 0.0)

    def _stacked(self, fit: Fit, roots: Sequence[FloatArray], tests: Sequence[TriboLoads]) -> FloatArray:
        """Return the whitened basis of an effect at all shapes, old tests and new, [m, g, amplitudes]."""
        raw = fit.prepared.candidate.columns[:, self._sets(fit)]
        if fit.name not in self.old:
            self.old[fit.name] = self.found.whiten(raw.reshape(len(raw), -1)).reshape(raw.shape)
        parts = [self.old[fit.name]]
        for root, loads in zip(roots, tests, strict=True):
            new = self._basis(fit, loads)
            parts.append((root @ new.reshape(POINTS, -1)).reshape(new.shape))
        return np.concatenate(parts)

    @staticmethod
    def _sets(fit: Fit) -> list[int]:
        """Return which sets of shape parameters take part: the best one, and some of the others evenly."""
        count = fit.prepared.candidate.columns.shape[1]
        some = np.linspace(0, count - 1, min(count, SHAPES)).round().astype(int)
        return sorted({int(k) for k in some} | {fit.index})

    def _basis(self, fit: Fit, loads: TriboLoads) -> FloatArray:
        """Return the basis of an effect along a new test, [POINTS, g, amplitudes]."""
        candidate = fit.prepared.candidate
        effect = candidate.effect
        chosen = self._sets(fit)
        shape = {name: values[None, chosen] for name, values in candidate.shapes.items()}
        sets = len(chosen)
        system = {k: np.full((POINTS, 1), float(v.mean())) for k, v in self.campaign.system.items()}
        made = Campaign(
            loads, np.full(POINTS, self.typical), ["new"], np.array([0]), np.arange(POINTS), np.ones(POINTS),
            np.zeros(POINTS, dtype=int), np.arange(POINTS), loads.sd, system,
        )  # fmt: skip
        state = integrate(effect, made, made.mu, shape) if effect.states else {}
        basis = effect.basis(OPS, load_columns(loads), shape, Memory(made.mu[:, None], state, system))
        return np.stack([np.broadcast_to(b, (POINTS, sets)) for b in basis], axis=2)

    def _root(self, loads: TriboLoads) -> FloatArray:
        """Return what whitens a new test: its own offset, drift along it, sensor noise."""
        floor = self.found.floor
        gaps = np.abs(loads.sd[:, None] - loads.sd[None, :])
        points = max(float(self.campaign.count.sum()) / len(self.campaign.tests) / POINTS, 1.0)
        S = floor.test**2 + floor.drift**2 * np.exp(-gaps / max(floor.drift_length, 1e-9))
        S[np.diag_indices(POINTS)] += max(floor.bin_sensor**2 / points, 1e-12)
        return np.asarray(np.linalg.inv(np.linalg.cholesky(S)))

    def points(self, first: Fit, second: Fit) -> tuple[Proposal, float] | None:
        """Return the constant tests at corners of the plan that separate best together, and by how much."""
        s = Settings.of(self.campaign)
        corners = list(product(*(sorted({x[0], x[2]}) for x in (s.pressure, s.speed, s.tool))))
        if len(corners) < 2:
            return None

        def loads(corner: tuple[float, ...]) -> TriboLoads:
            sigma, v, tool = corner
            return s.loads(np.full(POINTS, v), np.full(POINTS, sigma), tool, s.distance)

        each = [self.separation(first, second, [loads(c)]) for c in corners]
        best = [corners[k] for k in np.argsort(each)[::-1][:SEVERAL]]
        rows = [s.row(sigma, v, tool, s.distance) for sigma, v, tool in best]
        names = ("sigma_n [MPa]", "v_rel [mm/s]", "T_tool [degC]")
        shown = {n: [c[k] for c in best] for k, n in enumerate(names)}
        t = self.separation(first, second, [loads(c) for c in best])
        return Proposal("points of the plan", shown, rows, []), t

    def zero_reading(self, fault: Fit) -> float:
        """Return by how many standard errors a reading without load shows the zero that the fault needs."""
        loads = self.campaign.loads
        friction = np.abs(fault.binned) * self.campaign.average(
            loads.sigma_n
        )  # what the cell reads at no load
        noise = self.found.floor.sensor * float(np.median(loads.sigma_n)) / np.sqrt(READING * READINGS)
        return float(np.median(friction) / max(noise, 1e-12))
