"""Which tests would tell rivals apart: protocols as rows of a test plan, with the separation to expect.

The expected separation is that of the tests that are there and the new ones together, less what the tests that are
there separate already: the base is refitted on both, the rival chooses its best strength and shape, and a new test has
its own offset, drift and sensor noise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement, product
from typing import Any

import numpy as np

from ..effects.base import Memory
from ..loads import FloatArray, TriboLoads
from .analysis import Round
from .base_law import BaseLaw
from .binning import Campaign
from .candidates import OPS, integrate, load_columns
from .heating import Heating
from .scan import Fit, Projector

POINTS = 60
#: Rivals of the winner for which tests are sought.
RIVALS = 3
#: Sliding distance that a tribometer reaches [mm].
LONGEST = 60.0
#: A rest in a test [s], and a reading without load [s].
REST, READING = 60.0, 10.0
#: Independent readings of a force cell in one second without load.
READINGS = 20.0
#: Largest separation that is promised.
MOST = 50.0
#: Constant tests of one proposal.
SEVERAL = 3
#: A pressure ramp ends at this share of the lowest tested pressure: less force on the same contact is always possible.
RELIEVED = 0.2
#: A test that separates by less tells nothing; one that separates by more is enough.
USELESS, ENOUGH = 0.5, 3.0
#: Sliding distance of a proposed test where the data do not say how far tests slide [mm].
USUAL_DISTANCE = 20.0
#: What sets a load; a load that the data lack is left out of the proposed rows.
SET_BY = {"v_rel": "v_set", "T": "T_tool", "sigma_n": "sigma_set"}
#: Shapes of a rival that are tried.
SHAPES = 20


@dataclass(frozen=True)
class Proposal:
    """Further tests.

    Attributes
    ----------
    protocol : str
        Name for people.
    setpoints : dict
        What is set, for people.
    plan : list of dict
        The tests as rows of a plan: ``protocol``, ``sigma_set`` [MPa], ``v_set`` [mm/s], ``T_tool`` [degC],
        ``sd_set`` [mm], where it is known ``psi_set``, and what the protocol needs: ``v_levels`` (text, speeds on
        equal parts of the distance), ``sigma_end``, ``hold_at`` [mm] and ``hold`` [s], ``zero_reading`` [s].
    loads : list of TriboLoads
        Loads to expect in each of them.
    """

    protocol: str
    setpoints: dict[str, Any]
    plan: list[dict[str, Any]]
    loads: list[TriboLoads]


def propose(
    campaign: Campaign, found: Round, rivals: list[Fit], mu: FloatArray, base: BaseLaw
) -> list[dict[str, Any]]:
    """Return protocols that separate the first of `rivals` from the others, the most telling first.

    Parameters
    ----------
    campaign : Campaign
    found : Round
        The scan that gave the rivals.
    rivals : list of Fit
        The winner first.
    mu : ndarray, shape (n,)
        Friction of the base, for effects that need one.
    base : BaseLaw
        What else is refitted.
    """
    if len(rivals) < 2:
        return []
    bench = _Bench(campaign, found, mu, base)
    first, result = rivals[0], []
    proposals = protocols(campaign)
    for rival in rivals[1 : 1 + RIVALS]:
        pair = [first.name, rival.name]
        for proposal in proposals:
            t = bench.separation(first, rival, proposal.loads)
            result.append(_entry(proposal, pair, t))
        points = bench.points(first, rival, proposals[0])
        if points is not None:
            result.append(_entry(points[0], pair, points[1]))
    names = [r.name for r in rivals]
    if "force_zero" in names:
        fault = rivals[names.index("force_zero")]
        other = next(n for n in names if n != "force_zero")
        row = {**proposals[0].plan[0], "protocol": "zero_reading", "zero_reading": READING}
        row.pop("v_levels", None)
        reading = Proposal("zero reading", {"sigma_n [MPa]": 0.0, "duration [s]": READING}, [row], [])
        result.append(_entry(reading, ["force_zero", other], bench.zero_reading(fault)))
    result.sort(key=lambda p: -p["expected_t"])
    telling = [p for p in result if p["expected_t"] >= USELESS]
    return (telling or result[:1])[:5]


def _entry(proposal: Proposal, pair: list[str], t: float) -> dict[str, Any]:
    return {
        "protocol": proposal.protocol,
        "setpoints": proposal.setpoints,
        "separates": pair,
        "expected_t": round(min(t, MOST), 2),
        "repeats": int(np.ceil((ENOUGH / max(t, 0.1)) ** 2)),
        "plan": proposal.plan,
    }


@dataclass(frozen=True)
class _Settings:
    """Levels within what was tested, and what a test with them looks like."""

    speed: tuple[float, float, float]
    pressure: tuple[float, float, float]
    tool: tuple[float, float, float]
    psi: float
    psi_set: float | None
    distance: float
    heating: Heating
    unknown: tuple[str, ...] = ()

    @classmethod
    def of(cls, campaign: Campaign) -> _Settings:
        array = campaign.loads.as_array()
        low, middle, high = np.quantile(array, [0.05, 0.5, 0.95], axis=0)
        firsts = campaign.point_starts
        tool = campaign.system.get("T_tool")
        cold = array[firsts, 1] if tool is None else tool[firsts, 0]
        rise = array[:, 1] - np.repeat(cold, np.diff(np.r_[firsts, len(array)]))
        shapes = campaign.system.get("psi_set")
        usual = None
        if shapes is not None:
            values, counts = np.unique(shapes[firsts, 0], return_counts=True)
            usual = float(values[np.argmax(counts)])
        lasts = np.r_[firsts[1:], len(array)] - 1
        fast = max(float(high[0]), 1e-9)
        slow = max(float(low[0]), 0.01 * fast, 1e-9)
        distance = _round(float(np.median(campaign.distance[lasts])))
        if "sd" in campaign.absent or campaign.count.size == len(campaign.tests) or not distance > 0.0:
            distance = USUAL_DISTANCE
        return cls(
            (_round(slow), _round(float(np.sqrt(slow * fast))), _round(fast)),
            (_round(low[2]), _round(middle[2]), _round(high[2])),
            (_round(cold.min()), _round(np.median(cold)), _round(cold.max())),
            max(float(middle[4]), 1e-3),
            usual,
            distance,
            Heating.learn(array[:, 2], array[:, 0], array[:, 3], rise),
            tuple(SET_BY[n] for n in campaign.absent if n in SET_BY),
        )

    def row(self, sigma: float, v: float, tool: float, distance: float) -> dict[str, Any]:
        row: dict[str, Any] = {
            "protocol": "constant", "sigma_set": sigma, "v_set": v, "T_tool": tool, "sd_set": distance,
        }  # fmt: skip
        row = {k: value for k, value in row.items() if k not in self.unknown}
        return row | ({"psi_set": self.psi_set} if self.psi_set is not None else {})

    def loads(
        self, v: FloatArray, sigma: FloatArray, tool: float, distance: float, rest_at: int | None = None
    ) -> TriboLoads:
        """Return the loads along a test, at equal distances; a rest is a point that does not move."""
        sd = distance * (np.arange(POINTS) + 1.0) / POINTS
        t = np.cumsum(distance / POINTS / np.maximum(v, 1e-9))
        mean = sd / np.maximum(t, 1e-12)
        T = tool + self.heating.rise(sigma, mean, sd)
        if rest_at is not None:
            t = t + np.where(np.arange(POINTS) >= rest_at, REST, 0.0)
        return TriboLoads(v, T, sigma, sd, np.full(POINTS, self.psi), t=t)


def protocols(campaign: Campaign) -> list[Proposal]:
    """Return protocols within the tested range: speed step, pressure ramp, hold, long run."""
    s = _Settings.of(campaign)
    (slow, middle, fast), (low, usual, high), tool = s.speed, s.pressure, s.tool[1]
    levels = (slow, fast, middle, slow, fast)
    part = np.minimum(np.arange(POINTS) * len(levels) // POINTS, len(levels) - 1)
    flat, even = np.full(POINTS, middle), np.full(POINTS, usual)
    distance = s.distance
    found = [
        Proposal(
            "speed step",
            {"v_rel [mm/s]": list(levels), "sigma_n [MPa]": usual},
            [
                {
                    **s.row(usual, slow, tool, distance),
                    "protocol": "speed_step",
                    "v_levels": ";".join(f"{v:g}" for v in levels),
                }
            ],
            [s.loads(np.array(levels)[part], even, tool, distance)],
        )
    ]
    low = _round(RELIEVED * low)
    if high > low > 0.0:
        ramp = high + (low - high) * np.arange(POINTS) / (POINTS - 1)
        found.append(
            Proposal(
                "pressure ramp",
                {"sigma_n [MPa]": [high, low], "v_rel [mm/s]": middle},
                [{**s.row(high, middle, tool, distance), "protocol": "pressure_ramp", "sigma_end": low}],
                [s.loads(flat, ramp, tool, distance)],
            )
        )
    half = _round(0.5 * distance)
    if half > 0.0:
        found.append(
            Proposal(
                "hold",
                {"v_rel [mm/s]": middle, "rest [s]": REST, "after [mm]": half},
                [{**s.row(usual, middle, tool, distance), "protocol": "hold", "hold_at": half, "hold": REST}],
                [s.loads(flat, even, tool, distance, POINTS // 2)],
            )
        )
    longer = _round(min(2.0 * distance, LONGEST))
    if longer > 1.2 * distance > 0.0:
        found.append(
            Proposal(
                "long run",
                {"sd [mm]": longer, "v_rel [mm/s]": middle},
                [s.row(usual, middle, tool, longer)],
                [s.loads(flat, even, tool, longer)],
            )
        )
    return found


class _Bench:
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

    def points(self, first: Fit, second: Fit, like: Proposal) -> tuple[Proposal, float] | None:
        """Return the constant tests at corners of the plan that separate best together, and by how much."""
        s = _Settings.of(self.campaign)
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


def plan_rows(next_tests: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return the rows of all proposed tests, each once, as one plan."""
    rows: list[dict[str, Any]] = []
    for entry in next_tests:
        rows += [dict(r) for r in entry["plan"] if dict(r) not in rows]
    return rows


def _round(value: float) -> float:
    return float(f"{value:.3g}")
