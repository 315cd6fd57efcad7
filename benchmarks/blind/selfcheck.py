"""`python -m benchmarks.blind.selfcheck`: the judge on answers whose worth is known, and the oracle's level and power.

A perfect answer must count everywhere, a silent one only where nothing can be seen, a wrong name nowhere; the oracle's test
must be wrong in 5 % of campaigns of pure noise and find 7.85 in 80 %.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.blind.bases import design, true_base
from benchmarks.blind.build import build
from benchmarks.blind.campaign import generator
from benchmarks.blind.cases import Case, all_cases
from benchmarks.blind.judge import judge
from benchmarks.blind.laws import LAWS
from benchmarks.blind.noise import RECIPES
from benchmarks.blind.oracle import LIMIT, Oracle
from benchmarks.blind.plans import PLANS
from benchmarks.blind.record import Answer
from benchmarks.blind.score import failed
from benchmarks.blind.truth import Truth

Say = Callable[[Case, Truth], tuple[str, list[str]]]


def perfect(case: Case, truth: Truth) -> tuple[str, list[str]]:
    """What an oracle would say."""
    names = [min(law["names"]) for law in truth["laws"] if law["visible"] and law["names"]]
    if names:
        return "explained", names
    return ("unknown_structure" if case.kind == "outside" else "nothing_missing"), []


def silent(case: Case, truth: Truth) -> tuple[str, list[str]]:
    """Nothing, whatever the data."""
    return "nothing_missing", []


def wrong(case: Case, truth: Truth) -> tuple[str, list[str]]:
    """A name that no law has."""
    return "explained", ["phlogiston"]


def share_right(say: Say, cases: list[tuple[Case, Truth]]) -> tuple[float, float]:
    """Shares of answers that are right, and that are not failures."""
    judged = []
    for case, truth in cases:
        verdict, effects = say(case, truth)
        answer: Answer = {
            "verdict": verdict,
            "effects": effects,
            "confusion_set": effects,
            "confidence": 0.9,
            "sentence": "",
        }
        judged.append(judge(case, answer, truth))
    return float(np.mean([j.right for j in judged])), float(np.mean([not failed(j) for j in judged]))


def level_and_power(plan: str, noise: str, key: str, draws: int = 300) -> tuple[float, float]:
    """How often the oracle's test of a law is wrong on pure noise, and finds a law at the limit."""
    rng = generator("selfcheck", plan, noise)
    c = PLANS[plan](rng)
    base = true_base("linear", c, rng)
    oracle = Oracle.of(c, base, RECIPES[noise], design("linear", c, base), generator("selfcheck"))
    z = oracle.project(LAWS[key].term(c, base, rng))[:, 0]
    z /= np.linalg.norm(z)
    t = np.array(
        [
            z @ oracle.whiten(RECIPES[noise](generator("selfcheck", i), c, base) - base)[:, 0]
            for i in range(draws)
        ]
    )
    return float(np.mean(np.abs(t) > 1.96)), float(np.mean(np.abs(t + np.sqrt(LIMIT)) > 1.96))


def main() -> None:
    """Print both checks."""
    cases = [(c, build(c).truth) for c in all_cases() if c.half == "a"]
    for say in (perfect, silent, wrong):
        right, passed = share_right(say, cases)
        print(f"{say.__name__:8s} answers: right {right:.3f}, no failure {passed:.3f}")
    for plan, noise, key in (
        ("latin30", "white", "stribeck_lorentz"),
        ("latin30", "random_walk", "tribofilm"),
        ("factorial36", "two_kinds", "johnson_cook"),
        ("averages50", "odd_tests", "torn_film"),
        ("few8", "skewed", "briscoe"),
    ):
        level, power = level_and_power(plan, noise, key)
        print(f"{plan:12s} {noise:12s} {key:18s} level {level:.3f}, power at the limit {power:.3f}")


if __name__ == "__main__":
    main()
