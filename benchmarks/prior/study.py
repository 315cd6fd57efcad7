"""Diagnoses of campaigns of the prior, the weights of the confidence fitted to them, and how reliable it is."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TypedDict

import numpy as np
from scipy.optimize import minimize_scalar
from sklearn.linear_model import LogisticRegression

from friction_models.common import write_json
from friction_models.discovery import diagnose
from friction_models.discovery.judge.confidence import WEIGHTS

from ..common import Section, Table, section
from ..data import sources
from ..literature.calibration import by_counting, reliability
from .campaigns import campaign
from .others import Judged, row_of, rows_of_others

#: Campaigns below are fitted to, those from here on judge.
JUDGED_FROM = 600_000
#: Bins of the reliability diagram, and from where on an answer is given as sure.
BINS, SURE = 10, 0.9
#: Scatter of a hidden part over that of the noise below which it need not be named.
VISIBLE = 0.3
#: Ridge penalty of the regression, with grounds that are about one wide.
PENALTY = 1.0
#: Kinds whose grounds are weighed by the prior alone: few tests must not make these answers sure. How often they are right in all
#: is a choice of who makes up the campaigns, so that their intercept comes from all authors.
BY_PRIOR = ("unknown_structure", "nothing_missing")


class Answer(TypedDict):
    """A campaign and its answer, as its file keeps them: laws, names and strengths of what is hidden, then the diagnosis."""

    seed: int
    kind: str
    laws: list[str]
    hidden: list[list[str]]
    strengths: list[float]
    verdict: str
    effects: list[str]
    confusion_set: list[str]
    confidence: float
    grounds: dict[str, float]


def right(row: Answer) -> bool:
    """Return whether an answer is right: it names what is hidden and nothing else, or abstains where no effect describes it.

    A part that is too small to be seen may be named, but need not.
    """
    verdict, names = row["verdict"], set(row["effects"])
    every = [set(n) for n in row["hidden"]]
    seen = [n for n, strength in zip(every, row["strengths"], strict=True) if strength >= VISIBLE]
    if verdict == "nothing_missing":
        return not seen
    if row["kind"] == "outside":
        return verdict == "unknown_structure"
    if verdict == "ambiguous":
        return bool(every) and all((names | set(row["confusion_set"])) & n for n in seen)
    if verdict not in {"explained", "data_problem", "partly_explained"} or not names:
        return False
    only = names <= set().union(*every)
    return only and (verdict == "partly_explained" or all(names & n for n in seen))


def answer(seed: int) -> Answer:
    """Diagnose one campaign."""
    made = campaign(seed)
    said = diagnose(made.points, made.tests)
    return {
        "seed": seed,
        "kind": made.kind,
        "laws": [law.key for law in made.laws],
        "hidden": [sorted(law.names) for law in made.laws],
        "strengths": list(made.strengths),
        "verdict": said.verdict,
        "effects": said.effects,
        "confusion_set": said.confusion_set,
        "confidence": said.confidence,
        "grounds": said.grounds,
    }


def answers(folder: Path, seeds: Sequence[int]) -> list[Answer]:
    """Return the answers of campaigns; those that the same code gave before and that are kept in `folder` are read."""
    kept = folder / "prior" / sources("friction_models")
    kept.mkdir(parents=True, exist_ok=True)
    rows: list[Answer] = []
    for seed in seeds:
        path = kept / f"{seed}.json"
        if not path.exists():
            write_json(path, answer(seed))
        rows.append(json.loads(path.read_text(encoding="utf-8")))
    return rows


def kind_of(verdict: str) -> str:
    """Return the entry of `WEIGHTS` that a verdict has."""
    return verdict if verdict in WEIGHTS else "named"


def fitted(
    rows: Sequence[Answer], others: Sequence[Judged] = ()
) -> dict[str, tuple[float, dict[str, float]]]:
    """Return weights like `WEIGHTS`, fitted to answers to the prior and to campaigns of others, every author with the same weight.

    `others` have ``source`` and ``right`` beside verdict and grounds, see `others.rows_of_others`. Answers with a reason to doubt
    them are left out: how sure these are at most is counted, reason by reason.
    """
    judged = [
        r
        for r in [*(row_of("prior", row, right(row)) for row in rows), *others]
        if r["grounds"]["most"] >= 1.0
    ]
    size = Counter(r["source"] for r in judged)
    found = {}
    for kind, (_, weights) in WEIGHTS.items():
        own = [
            r
            for r in judged
            if kind_of(r["verdict"]) == kind
            and r["verdict"] != "out_of_domain"
            and (r["source"] == "prior" or kind not in BY_PRIOR)
        ]
        x = np.array([[r["grounds"][name] for name in weights] for r in own])
        share = np.array([len(judged) / len(size) / size[r["source"]] for r in own])
        regression = LogisticRegression(C=1.0 / PENALTY, max_iter=1000)
        model = regression.fit(x, [r["right"] for r in own], sample_weight=share)
        found[kind] = (
            round(float(model.intercept_[0]), 2),
            {name: round(float(w), 2) for name, w in zip(weights, model.coef_[0], strict=True)},
        )
        if kind in BY_PRIOR:
            intercept, by_prior = found[kind]
            found[kind] = round(intercept + shift(judged, kind, intercept, by_prior), 2), by_prior
    return found


def shift(judged: Sequence[Judged], kind: str, intercept: float, weights: Mapping[str, float]) -> float:
    """Return by how much the score of a kind of answers is too low over the campaigns of all authors, each with the same weight.

    A single number: it holds on campaigns of an author that it was not fitted to, where weights that are fitted anew do not.
    """
    size = Counter(r["source"] for r in judged)
    own = [r for r in judged if kind_of(r["verdict"]) == kind]
    score = np.array([intercept + sum(w * r["grounds"][name] for name, w in weights.items()) for r in own])
    share = np.array([len(judged) / len(size) / size[r["source"]] for r in own])
    sign = np.array([1.0 if r["right"] else -1.0 for r in own])

    def unlikely(by: float) -> float:
        return float(share @ np.logaddexp(0.0, -sign * (score + by)) + 0.5 * PENALTY * by**2)

    return float(minimize_scalar(unlikely, bounds=(-4.0, 4.0), method="bounded").x)


def reliability_tables(judged: Mapping[str, Sequence[Judged]]) -> tuple[Table, Table]:
    """Return how reliable the confidence is by author of the campaigns, and the reliability diagram of all as a table.

    Parameters
    ----------
    judged : mapping
        Rows with ``confidence`` and ``right``, by what the page calls their campaigns.
    """
    by_author = Table(
        [
            "campaigns",
            "answers",
            "mean confidence",
            "right",
            "calibration error",
            "by counting alone",
            "right at 0.9 and above",
        ]
    )
    together = {**judged, "all": [r for own in judged.values() for r in own]}
    for name, rows in together.items():
        said = [r["confidence"] for r in rows]
        was = [bool(r["right"]) for r in rows]
        sure = [w for s, w in zip(said, was, strict=True) if s >= SURE]
        error, bins = reliability(said, was, BINS)
        by_author.rows.append(
            [
                name,
                len(rows),
                f"{np.mean(said):.2f}",
                f"{np.mean(was):.2f}",
                f"{error:.3f}",
                f"{by_counting(said, BINS):.3f}",
                f"{sum(sure)} of {len(sure)}",
            ]
        )
    diagram = Table(["confidence", "answers", "mean confidence", "right"])
    for b in bins:  # of all, which come last
        if b.n:
            diagram.rows.append([f"{b.low:.1f} to {b.high:.1f}", b.n, f"{b.said:.2f}", f"{b.was:.2f}"])
    return by_author, diagram


def measure(folder: Path, campaigns: int = 150) -> Section:
    """Return the section on the confidence: campaigns that it was not fitted to, by three authors."""
    own = answers(folder, range(JUDGED_FROM, JUDGED_FROM + campaigns))
    others = rows_of_others(folder, apart=True)
    judged = {"prior": [row_of("prior", row, right(row)) for row in own]}
    for source in sorted({r["source"] for r in others}):
        judged[f"{source}, cases kept apart"] = [r for r in others if r["source"] == source]
    text = (
        "Answers to campaigns that the confidence was not fitted to (synthetic): of a broad prior of ours (random monotone laws, pairs, "
        "laws outside the catalogue, nothing hidden; random plans, noises and strengths), and of two benchmarks that others wrote "
        "without a look at the diagnosis. Its weights were fitted to other campaigns of the prior and, where an effect is named, to the "
        "cases of these benchmarks that are there for development; the four intercepts to answers to all of them and to campaigns of two more "
        "authors, every author with the same weight. With the intercepts of the other four the error was 0.04 to 0.06 on the campaigns of each "
        "author, and 0.09 on the prior. By counting alone, as many answers that are right just as often as they say have that error on average."
    )
    return section("Confidence of the diagnosis", text, *reliability_tables(judged))
