"""How often `attribute` names the right cause, and how often it blames something where nothing is wrong.

``python -m benchmarks.attribution --seeds 10`` prints the table; runs are kept, so that more seeds cost little.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from forming.press import PressLevel
from friction_models.training.interval_coverage import wilson
from orchestrator.attribution.curves import LevelForces, fingerprint, on_common_stroke
from orchestrator.attribution.fit import attribution
from orchestrator.attribution.result import Attribution
from orchestrator.attribution.scatter import Scatter
from orchestrator.attribution.sensitivities import Sensitivities
from sct_twin.virtual_lab.press import VirtualPress

from .attribution_curves import LEVELS, MU, TRUE_MESHES, TRUTHS, USER_MESHES, Store, Truth
from .common import Section, Table, section

SEEDS = 20
REPEATS = 5
#: Levels that the press curves hold.
CURVES = {"rod and cup": (0, 1, 2), "rod alone": (0, 1), "rod, one level": (0,)}
#: Relative change of the force for a relative change of friction, of these short strokes.
FRICTION_SHARE = 0.37


@dataclass(frozen=True)
class Count:
    """Counts of one true situation.

    Attributes
    ----------
    truth : Truth
    draws, blamed, first, held, kinds, peak : int
        How many draws; in how many something was named, the truth came first, was in the set of what cannot be told
        apart, was of a kind that was named, came first from the peak forces alone.
    names : int
        Names in the sets together.
    """

    truth: Truth
    draws: int
    blamed: int
    first: int
    held: int
    kinds: int
    peak: int
    names: int


def measure(kept: Path) -> Section:
    """Count over all true situations, meshes and seeds."""
    return both(Store.of(kept), range(SEEDS))


def both(store: Store, seeds: Sequence[int]) -> Section:
    """Return the section, of all levels and of the rod alone."""
    return report({name: counts(store, seeds, chosen) for name, chosen in CURVES.items()})


def counts(
    store: Store, seeds: Sequence[int], chosen: Sequence[int], truths: Sequence[Truth] = TRUTHS
) -> list[Count]:
    """Return the counts of each situation from the `chosen` levels.

    Every seed has another mesh of the user, and where nothing is wrong all meshes of the truth.
    """
    found = []
    for truth in truths:
        answers = []
        for seed in seeds:
            user = USER_MESHES[seed % len(USER_MESHES)]
            for mesh in TRUE_MESHES if not truth.cause else TRUE_MESHES[:1]:
                answers.append(_judged(store, truth, user, mesh, seed, chosen))
        found.append(_count(truth, answers))
        print(found[-1], flush=True)
    return found


def _judged(
    store: Store, truth: Truth, user: float, mesh: float, seed: int, chosen: Sequence[int]
) -> tuple[Attribution, str]:
    """Return the answer for one draw, and what the peak forces alone would name."""
    known = store.sensitivities(user)
    known = replace(
        known,
        base=[known.base[k] for k in chosen],
        remeshed=[known.remeshed[k] for k in chosen],
        moved={key: [curves[k] for k in chosen] for key, curves in known.moved.items()},
    )
    press = pressed(store, truth, mesh, seed)
    levels = [
        on_common_stroke(press[k], base, known.mesh_size) for k, base in zip(chosen, known.base, strict=True)
    ]
    return attribution(levels, known, synthetic=True), first_by_peaks(levels, known)


def pressed(store: Store, truth: Truth, mesh: float, seed: int) -> list[PressLevel]:
    """Return synthetic press curves: the scatter of billets, lubricant and sensors of the virtual press."""
    reality = VirtualPress()
    give = truth.strength if truth.cause == "compliance" else 0.0
    levels = []
    for k, (kind, T, speed) in enumerate(LEVELS):
        rng = np.random.default_rng([seed, k, 6300])
        stroke, force = store.true_curve(k, mesh, truth)
        parts = []
        for number in range(1, REPEATS + 1):
            billet, gain, zero = rng.standard_normal(3)
            scatter = np.hypot(reality.flow_stress_scatter, FRICTION_SHARE * reality.mu_scatter / MU)
            own = force * (1.0 + scatter * billet) * (1.0 + reality.gain * gain)
            travel = np.maximum.accumulate(stroke + give * np.maximum.accumulate(own))
            at = np.linspace(travel[0], travel[-1], 600)
            noise = reality.zero * zero + reality.force_noise * rng.standard_normal(len(at))
            seen = np.maximum.accumulate(at + reality.stroke_noise * rng.standard_normal(len(at)))
            parts.append(
                pd.DataFrame({"stroke": seen, "force": np.interp(at, travel, own) + noise, "repeat": number})
            )
        table = pd.concat(parts, ignore_index=True)
        levels.append(PressLevel(kind, T, speed, "made up", f"{kind}_{k}.csv", table, synthetic=True))
    return levels


def first_by_peaks(levels: Sequence[LevelForces], found: Sensitivities) -> str:
    """Return the cause that explains the highest forces of all levels best, with the same scatter."""
    start = np.cumsum([0, *(len(v.stroke) for v in levels)])
    at = np.array([s + int(np.argmax(v.measured)) for s, v in zip(start[:-1], levels, strict=True)])
    factor = np.linalg.cholesky(Scatter.of(levels, found, []).covariance[np.ix_(at, at)])
    y = np.linalg.solve(factor, np.concatenate([v.measured - v.simulated for v in levels])[at])
    drops: dict[str, float] = {}
    for cause in found.causes:
        x = np.linalg.solve(factor, np.concatenate(fingerprint(cause, levels, found))[at])
        strength = float(x @ y) / max(float(x @ x), 1e-300)
        drop = strength * float(x @ y) if cause.sign * strength >= 0.0 else 0.0
        drops[cause.name] = max(drop, drops.get(cause.name, 0.0))
    return max(drops, key=lambda name: drops[name])


def _count(truth: Truth, answers: Sequence[tuple[Attribution, str]]) -> Count:
    sets = [a.confusion_set for a, _ in answers]
    kind = [next((f.kind for f in a.ranking if f.cause == truth.cause), "") for a, _ in answers]
    return Count(
        truth,
        len(sets),
        sum(bool(s) for s in sets),
        sum(s[:1] == [truth.cause] for s in sets),
        sum(truth.cause in s for s in sets),
        sum(k in a.kinds for k, (a, _) in zip(kind, answers, strict=True)),
        sum(peak == truth.cause for _, peak in answers),
        sum(len(s) for s in sets),
    )


def report(found: Mapping[str, Sequence[Count]]) -> Section:
    """Return the section: rates with Wilson intervals."""
    table = Table(
        ["curves", "what is wrong", "draws", "something named", "right cause first", "right cause in the set", "right kind named",
         "names in a set", "peak forces only: right cause first"]
    )  # fmt: skip
    for name, c in ((name, c) for name, each in found.items() for c in each):
        blank = not c.truth.cause
        table.rows.append(
            (name, c.truth.label, c.draws, _rate(c.blamed, c.draws), *("" if blank else _rate(n, c.draws) for n in (c.first, c.held, c.kinds)),
             f"{c.names / max(c.blamed, 1):.1f}", "" if blank else _rate(c.peak, c.draws))
        )  # fmt: skip
    return section(
        "Forming attribution: how often it is right",
        f"A rod (two levels) and a cup (one), {REPEATS} repeats with the scatter of the virtual press; the user's element sizes "
        f"{', '.join(f'{m:g}' for m in sorted(USER_MESHES))} mm, under the measured curves {', '.join(f'{m:g}' for m in sorted(TRUE_MESHES))} mm "
        f"(cup: times 0.75). All causes are judged. 95 % intervals (Wilson) count draws of scatter; there are only {len(USER_MESHES)} by "
        f"{len(TRUE_MESHES)} pairs of meshes. Peak forces only: which cause fits the highest force of each level best, nothing else known. Synthetic.",
        table,
    )


def _rate(hits: int, draws: int) -> str:
    low, high = wilson(hits / draws, draws)
    return f"{100 * hits / draws:.0f} % ({100 * low:.0f} to {100 * high:.0f})"


def main() -> None:
    """Print the table of some seeds."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.attribution", description=__doc__)
    parser.add_argument("--kept", type=Path, default=Path("build/benchmarks"))
    parser.add_argument("--seeds", type=int, default=SEEDS)
    chosen = parser.parse_args()
    began = time.process_time()
    found = both(Store.of(chosen.kept), range(chosen.seeds))
    print("\n".join([found["text"], *found["lines"]]))
    print(f"{time.process_time() - began:.0f} s of CPU")


if __name__ == "__main__":
    main()
