"""Which tests would tell rivals apart: protocols with set points and the separation to expect."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..effects.base import Memory
from ..loads import FloatArray, TriboLoads
from .analysis import Round
from .binning import Campaign
from .candidates import OPS, integrate, load_columns
from .scan import Fit, Projector

POINTS = 60


def propose(campaign: Campaign, found: Round, rivals: list[Fit], mu: FloatArray) -> list[dict[str, Any]]:
    """Return protocols that separate the first of `rivals` from the others, the most telling first.

    The expected t is that of one test, with base offset and slopes left free within it and drift and sensor
    noise of the floor; the scatter between tests cannot hurt because every protocol varies a load within a test.
    """
    if len(rivals) < 2:
        return []
    proposals: list[dict[str, Any]] = []
    typical = float(np.median(mu))
    for name, loads, setpoints in _protocols(campaign):
        for rival in rivals[1:4]:
            t = _separation(campaign, found, rivals[0], rival, loads, typical)
            proposals.append(
                {
                    "protocol": name,
                    "setpoints": setpoints,
                    "separates": [rivals[0].name, rival.name],
                    "expected_t": t,
                }
            )
    names = {r.name for r in rivals}
    if "force_zero" in names:
        other = next(r.name for r in rivals if r.name != "force_zero")
        proposals.append(
            {
                "protocol": "zero reading",
                "setpoints": {"sigma_n [MPa]": 0.0, "duration [s]": 10.0},
                "separates": ["force_zero", other],
                "expected_t": 10.0,
            }
        )
    proposals.sort(key=lambda p: -p["expected_t"])
    return proposals[:5]


def _protocols(campaign: Campaign) -> list[tuple[str, TriboLoads, dict[str, Any]]]:
    """Return loads of protocols within the tested range: speed step, pressure ramp, hold, long run."""
    array = campaign.loads.as_array()
    low, middle, high = np.quantile(array, [0.05, 0.5, 0.95], axis=0)
    distance = float(np.median(campaign.distance[np.r_[campaign.point_starts[1:], len(array)] - 1]))
    step = np.linspace(0.0, 1.0, POINTS)
    sd = distance * step

    def test(
        v: FloatArray, s: FloatArray, rest: FloatArray | None = None, length: FloatArray = sd
    ) -> TriboLoads:
        dt = np.diff(length, prepend=0.0) / np.maximum(v, 1e-9)
        t = np.cumsum(dt + (rest if rest is not None else 0.0))
        full = np.ones(POINTS)
        return TriboLoads(v, middle[1] * full, s, length, max(middle[4], 1e-3) * full, t=t)

    flat_v, flat_s = np.full(POINTS, max(middle[0], 1e-9)), np.full(POINTS, middle[2])
    slow, fast = max(low[0], 0.02 * high[0], 1e-9), max(high[0], 1e-9)
    levels = np.array([slow, fast, np.sqrt(slow * fast), slow, fast])
    stepped = levels[np.minimum((step * 5).astype(int), 4)]
    ramp = low[2] + (high[2] - low[2]) * step
    hold = np.zeros(POINTS)
    hold[POINTS // 2] = 60.0
    return [
        ("speed step", test(stepped, flat_s), {"v_rel [mm/s]": [_round(v) for v in levels]}),
        ("pressure ramp", test(flat_v, ramp), {"sigma_n [MPa]": [_round(ramp[0]), _round(ramp[-1])]}),
        ("hold", test(flat_v, flat_s, hold), {"v_rel [mm/s]": _round(flat_v[0]), "rest [s]": 60.0}),
        ("long run", test(flat_v, flat_s, length=2.0 * sd), {"sd [mm]": _round(2.0 * distance)}),
    ]  # fmt: skip


def _separation(
    campaign: Campaign, found: Round, first: Fit, second: Fit, loads: TriboLoads, mu: float
) -> float:
    """Return the t value with which one such test would tell two fitted effects apart."""
    difference = _response(campaign, first, loads, mu) - _response(campaign, second, loads, mu)
    gaps = np.abs(loads.sd[:, None] - loads.sd[None, :])
    floor = found.floor
    points = max(float(campaign.count.sum()) / len(campaign.tests) / POINTS, 1.0)
    S = floor.drift**2 * np.exp(-gaps / max(floor.drift_length, 1e-9))
    S[np.diag_indices(POINTS)] += max(floor.bin_sensor**2 / points, 1e-12)
    root = np.linalg.inv(np.linalg.cholesky(S))
    array = loads.as_array()
    varying = array[:, np.ptp(array, axis=0) > 0]
    free = Projector(root @ np.column_stack([np.ones(POINTS), varying - varying.mean(axis=0)]))
    rest = free(root @ difference)
    return float(np.sqrt(rest @ rest))


def _response(campaign: Campaign, fit: Fit, loads: TriboLoads, mu: float) -> FloatArray:
    effect, shape = fit.prepared.candidate.effect, fit.shape
    system = {k: np.full((POINTS, 1), float(v.mean())) for k, v in campaign.system.items()}
    made = Campaign(
        loads, np.full(POINTS, mu), ["protocol"], np.array([0]), np.arange(POINTS), np.ones(POINTS),
        np.zeros(POINTS, dtype=int), np.arange(POINTS), loads.sd, system,
    )  # fmt: skip
    state = integrate(effect, made, made.mu, shape) if effect.states else {}
    basis = effect.basis(OPS, load_columns(loads), shape, Memory(made.mu[:, None], state, system))
    return np.sum([a * np.broadcast_to(b, (POINTS, 1))[:, 0] for a, b in zip(fit.amplitudes, basis)], axis=0)


def _round(value: float) -> float:
    return float(f"{value:.3g}")
