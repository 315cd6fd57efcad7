"""Counts the judged answers and lists the failures of the half for development."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np

from benchmarks.blind.judge import Judged
from benchmarks.literature.calibration import by_counting

BINS = (0.0, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0001)
POWERS = (0.0, 7.85, 30.0, 100.0, 1000.0, np.inf)


def _rate(values: Iterable[bool]) -> str:
    flags = list(values)
    return f"{sum(flags)} of {len(flags)} ({100 * sum(flags) / len(flags):.0f} %)" if flags else "none"


def abstains(j: Judged) -> bool:
    """Outside the catalogue: says so, or names only true parts and that something remains; or two effects cannot be told from it."""
    return (
        j.imitated
        or j.verdict == "unknown_structure"
        or (j.verdict == "partly_explained" and not j.wrong_names)
    )


def numbers(judged: Sequence[Judged]) -> dict[str, int | str]:
    """The numbers of a set of cases."""
    of = {
        kind: [j for j in judged if j.case.kind == kind]
        for kind in ("null", "single", "pair", "triple", "outside")
    }
    seen = [j for j in of["single"] if j.visible]
    plain = [j for j in seen if not j.twin]
    named = [j for j in seen if j.rivals]
    sure = [j for j in judged if j.confidence >= 0.9]
    out: dict[str, int | str] = {
        "cases": len(judged),
        "crashes and time-outs": _rate(j.verdict in ("crash", "time-out") for j in judged),
        "false alarms (nulls)": _rate(not j.right for j in of["null"]),
        "false alarms (effects below the oracle's limit, other name said)": _rate(
            bool(j.wrong_names) for j in of["single"] if not j.visible
        ),
        "single: right first, outside twins": _rate(j.first for j in plain),
        "single: right first, with twins (a twin counts)": _rate(j.first for j in seen),
        "single: truth in the set": _rate(j.in_set for j in seen),
        "single: mean size of the set, where named": f"{np.mean([len(set(j.rivals)) for j in named]):.2f}"
        if named
        else "none",
        "single: a wrong name among the effects": _rate(bool(j.wrong_names) for j in seen),
        "single: nothing_missing": _rate(j.verdict == "nothing_missing" for j in seen),
        "single: unknown_structure": _rate(j.verdict == "unknown_structure" for j in seen),
        "single: partly_explained": _rate(j.verdict == "partly_explained" for j in seen),
        "pairs exact": _rate(j.exact for j in of["pair"]),
        "pairs: truth in the set": _rate(j.in_set for j in of["pair"]),
        "pairs: a wrong name": _rate(bool(j.wrong_names) for j in of["pair"]),
        "triples exact": _rate(j.exact for j in of["triple"]),
        "triples: a wrong name": _rate(bool(j.wrong_names) for j in of["triple"]),
        "outside: abstains, or partly without a wrong name": _rate(abstains(j) for j in of["outside"]),
        "right, all": _rate(j.right for j in judged),
        "right at confidence 0.9 and above": _rate(j.right for j in sure),
    }
    for low, high in pairwise(POWERS):
        inside = [j for j in of["single"] if low <= j.truth.get("noncentrality", 0) < high]
        out[f"single, non-centrality {low:g} to {high:g}: right first"] = _rate(j.first for j in inside)
    error = 0.0
    for low, high in pairwise(BINS):
        inside = [j for j in judged if low <= j.confidence < high]
        if inside:
            share, mean = np.mean([j.right for j in inside]), np.mean([j.confidence for j in inside])
            error += len(inside) / len(judged) * abs(float(share - mean))
            out[f"confidence {low:g} to {min(high, 1):g}"] = (
                f"{len(inside)} answers, mean {mean:.2f}, right {share:.2f}"
            )
    out["expected calibration error"] = f"{error:.3f}"
    out["... of as many answers that are right just as often as they say"] = (
        f"{by_counting([j.confidence for j in judged]):.3f}"
    )
    return out


def by_recipe(judged: Sequence[Judged]) -> list[str]:
    """False alarms of the nulls for each recipe of noise and each plan."""
    nulls = [j for j in judged if j.case.kind == "null"]
    out = []
    for what in ("noise", "plan", "base"):
        for value in sorted({getattr(j.case, what) for j in nulls}):
            flags = [not j.right for j in nulls if getattr(j.case, what) == value]
            if any(flags):
                out.append(f"{what} {value}: {_rate(flags)}")
    return out


def failed(j: Judged) -> bool:
    """Whether a case belongs on the list of failures."""
    if j.case.kind == "null":
        return not j.right
    if j.case.kind == "outside":
        return not abstains(j)
    return not (j.exact or (not j.visible and j.verdict == "nothing_missing"))


def failure(j: Judged) -> str:
    """One failure: what was said, and what is true."""
    truth = "; ".join(
        f"{law['law']} (accepted {'/'.join(sorted({*law['names'], *law['twins']})) or 'none'}, non-centrality {law['noncentrality']:g}, share {law['share_of_variance']:.2f}, "
        f"closest {', '.join(f'{k} {v:.2f}' for k, v in list(law['near'].items())[:3])})"
        for law in j.truth["laws"]
    )
    rivals = [r for r in j.rivals if r not in j.effects]
    said = f"{j.verdict} {', '.join(j.effects)}" + (f" [or {', '.join(rivals)}]" if rivals else "")
    two = j.truth.get("imitation")
    if two:
        truth += f"; two effects follow {two['share']:.2f} of it at best ({' + '.join(two['effects'])})"
    return f"{j.case.name}{f' (seed {j.case.seed})' if j.case.seed else ''}\n    said {said} ({j.confidence:.2f}); true: {truth or 'nothing is missing'}{'' if not j.right else '; counts as right for the confidence'}"
