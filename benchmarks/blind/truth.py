"""The truth of a case: which laws an oracle can see, which effects are right for each, and which are inherent twins."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NotRequired, TypedDict

import numpy as np

from benchmarks.blind.campaign import Array, Campaign
from benchmarks.blind.law import Law
from benchmarks.blind.oracle import LIMIT, Oracle, raw_share, share_explained
from benchmarks.blind.shapes import has_direction, rivals

SAME_FORM = 0.985
DOMINANT = 0.80


@dataclass(frozen=True)
class Hidden:
    """One law of a case with its contribution to mu."""

    law: Law
    strength: float
    term: Array


class LawTruth(TypedDict):
    """What is true of one hidden law: which names are right, and how well an oracle sees it."""

    law: str
    source: str
    strength: float
    noncentrality: float
    visible: bool
    share_of_variance: float
    range_mu: float
    names: list[str]
    partial: list[str]
    twins: dict[str, float]
    own_shape_share: float
    near: dict[str, float]


class Imitation(TypedDict, total=False):
    """Two effects that follow a law outside the catalogue best; empty where no such law is hidden alone."""

    effects: list[str]
    share: float
    left: float
    hidden: bool


class Truth(TypedDict):
    """What is true of a case; of one that was not built, only the first three are known."""

    laws: list[LawTruth]
    merged: dict[str, float]
    nothing: bool
    imitation: NotRequired[Imitation]
    noncentrality: NotRequired[float]
    share_of_variance: NotRequired[float]
    mu_range: NotRequired[list[float]]


def _along_total(oracle: Oracle, total: Array, shape: Array) -> bool:
    """Whether friction as a whole runs the way of a rival (beside a constant alone)."""
    constant = oracle.whiten(np.ones(len(total)))
    q = constant / np.linalg.norm(constant)
    a, b = (w - q @ (q.T @ w) for w in (oracle.whiten(total), oracle.whiten(shape[:, :1])))
    return float(a[:, 0] @ b[:, 0]) > 0


def imitation(target: Array, shapes: list[tuple[str, Array, Array]], oracle: Oracle) -> Imitation:
    """How well two effects of the catalogue together follow a law outside it (best partners of the ten best shapes)."""
    projected = [(name, w - oracle.base @ (oracle.base.T @ w)) for name, _, w in shapes]
    alone = sorted(
        ((share_explained(target, w, has_direction(n)), i) for i, (n, w) in enumerate(projected)),
        reverse=True,
    )
    best, names = 0.0, list[str]()
    for _, i in alone[:10]:
        first, w1 = projected[i]
        for second, w2 in projected:
            if second == first:
                continue
            both = np.hstack([w1, w2])
            amplitude, *_ = np.linalg.lstsq(both, target, rcond=None)
            opposed = (has_direction(first) and amplitude[0] < 0) or (
                has_direction(second) and amplitude[w1.shape[1]] < 0
            )
            share = 1 - float(np.sum((target - both @ amplitude) ** 2)) / float(target @ target)
            if share > best and not opposed:
                best, names = share, [first, second]
    left = (1 - best) * float(target @ target)
    return {
        "effects": names,
        "share": round(best, 3),
        "left": round(left, 1),
        "hidden": left < LIMIT or best >= SAME_FORM,
    }


def truth_of(c: Campaign, base: Array, hidden: list[Hidden], oracle: Oracle, design: Array) -> Truth:
    """Judge every hidden law against all rival shapes on the noiseless truth."""
    shapes = [(name, z, oracle.whiten(z)) for name, z in rivals(c)] if hidden else []
    sum_of_terms = base + sum((h.term for h in hidden), np.zeros(len(base)))
    laws: list[LawTruth] = []
    for i, h in enumerate(hidden):
        others = [oracle.whiten(o.term) for j, o in enumerate(hidden) if j != i]
        beside = np.hstack(others) if others else None
        target = oracle.project(h.term, beside)[:, 0]
        power = float(target @ target)
        basis = oracle.base if beside is None else np.linalg.qr(np.hstack([oracle.base, beside]))[0]
        best: dict[str, float] = {}
        for name, z, white in shapes:
            share = share_explained(target, white - basis @ (basis.T @ white), one_sided=has_direction(name))
            if share > best.get(name, 0.0) and (
                not has_direction(name) or share < 0.5 or _along_total(oracle, sum_of_terms, z)
            ):
                best[name] = share
        twins = {
            name: share
            for name, share in best.items()
            if name not in h.law.names
            and share >= DOMINANT
            and ((1 - share) * power < LIMIT or share >= SAME_FORM)
        }
        own = oracle.bins.mean(h.term)
        laws.append(
            {
                "law": h.law.key,
                "source": h.law.source,
                "strength": h.strength,
                "noncentrality": round(power, 1),
                "visible": power >= LIMIT,
                "share_of_variance": round(raw_share(oracle, design, h.term), 4),
                "range_mu": round(float(np.ptp(own)), 4),
                "names": sorted(h.law.names),
                "partial": sorted(h.law.partial),
                "twins": {k: round(v, 3) for k, v in sorted(twins.items(), key=lambda kv: -kv[1])},
                "own_shape_share": round(max((best.get(n, 0.0) for n in h.law.names), default=0.0), 3),
                "near": {k: round(v, 3) for k, v in sorted(best.items(), key=lambda kv: -kv[1])[:5]},
            }
        )
    everything = sum((h.term for h in hidden), np.zeros(len(base)))
    signal = oracle.project(everything)[:, 0] if hidden else np.zeros(0)
    power = float(signal @ signal)
    merged: dict[str, float] = {}
    if len(hidden) > 1 and power > 0:
        for name, _, white in shapes:
            share = share_explained(
                signal, white - oracle.base @ (oracle.base.T @ white), one_sided=has_direction(name)
            )
            if (1 - share) * power < LIMIT and share >= DOMINANT:
                merged[name] = round(max(share, merged.get(name, 0.0)), 3)
    return {
        "imitation": imitation(signal, shapes, oracle)
        if hidden and not any(h.law.names for h in hidden)
        else {},
        "laws": laws,
        "merged": merged,
        "noncentrality": round(power, 1),
        "share_of_variance": round(raw_share(oracle, design, everything), 4),
        "nothing": not any(law["visible"] for law in laws),
    }
