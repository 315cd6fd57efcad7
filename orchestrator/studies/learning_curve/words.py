"""The findings of the learning-curve study in words, its table, and the paper's numbers beside ours."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from friction_models import PolynomialFriction
from friction_models.training.learning_curve import NeededTests

from .jobs import AVERAGE, MEAN, SERIES
from .result import APART, AT_ONCE, NO_DIFFERENCE, Comparison, Curve, LearningCurves

#: Lowest error that the paper reaches with time series.
PAPER_LOWEST = 0.007


def findings(curves: LearningCurves) -> list[str]:
    """Return what the study says, one sentence or two each: the answer first, then why."""
    return [*_answer(curves), *_why(curves), *_lowest(curves)]


def headline(curves: LearningCurves) -> str:
    """Return whether time-series-based data needs fewer tests, in one line."""
    asked = f"MAE < {curves.accuracy:g}"
    found = curves.comparisons
    if not found:
        return "Learning curves of friction models"
    fewer = sum(c.verdict == "fewer" for c in found)
    more = sum(c.verdict == "more" for c in found)
    if fewer > more:
        return f"Time-series data needs fewer tests for {asked} in {fewer} of {len(found)} cases"
    if more > fewer:
        return f"Time-series data needs more tests for {asked} in {more} of {len(found)} cases"
    return f"Time-series data does not clearly need fewer tests for {asked}"


def _answer(curves: LearningCurves) -> list[str]:
    lines = []
    for found, what in (
        (curves.comparisons, f"for an MAE below {curves.accuracy:g} with 95 % probability"),
        (curves.apart, f"at {APART:g} times the lowest error of the model, where the models come apart"),
        (
            curves.strict,
            "to come within 10 % of the lowest error that a model reaches with either collection",
        ),
    ):
        if found:
            lines.append(f"{what[0].upper()}{what[1:]}, {_counted(found, curves)}.")
    return lines


def _counted(found: Sequence[Comparison], curves: LearningCurves) -> str:
    """Return in how many cases which data collection needs fewer tests."""
    of = {
        verdict: [c for c in found if c.verdict == verdict]
        for verdict in ("fewer", "more", NO_DIFFERENCE, AT_ONCE)
    }
    text = (
        f"time-series-based data needs fewer tests than average-based data in {_of_all(of['fewer'], found)}"
    )
    text += f", more in {_of_all(of['more'], found)}"
    if of[NO_DIFFERENCE]:
        text += f"; there is no clear difference in {len(of[NO_DIFFERENCE])} of {len(found)}"
    if of[AT_ONCE]:
        smallest = min(c.sizes[0] for c in curves.curves)
        text += f"; in {len(of[AT_ONCE])} of {len(found)} the smallest training set, {smallest} tests, suffices with either"
    return text


def _of_all(cases: Sequence[Comparison], found: Sequence[Comparison]) -> str:
    said = (f"{c.model} {c.lubricant}: {_number(c.series)} against {_number(c.average)}" for c in cases)
    return f"{len(cases)} of {len(found)} cases ({', '.join(said)})" if cases else "none"


def _number(needed: NeededTests) -> str:
    if needed.tests is None:
        return "not reached"
    return f"{'at most ' if needed.at_most else ''}{math.ceil(needed.tests)}"


def _why(curves: LearningCurves) -> list[str]:
    lines = []
    if any(c.model == "polynomial" and c.verdict == "fewer" for c in curves.comparisons):
        terms = len(PolynomialFriction().terms) + 1
        lines.append(
            f"One point a test does not determine a polynomial of {terms} coefficients before there are about as many "
            "tests; within a time series distance, temperature and speed move, which ties more of them down."
        )
    for lubricant, f in curves.facts.items():
        between, within = f["scatter_between_tests"] ** 2, f["scatter_within_tests"] ** 2
        share = between / (between + within) if between + within > 0 else 0.0
        text = (
            f"{lubricant}: {share:.0%} of the variance of mu in the held-out tests lies between tests, {1 - share:.0%} within "
            "them. Averages hold the first part only: a model that knew the mean of every test, and nothing else, would "
            f"have an MAE of {f['mae_own_mean_of_test']:.4f}."
        )
        mean = curves.curve(lubricant, SERIES, MEAN)
        if mean is not None and mean.percentile[0] < curves.accuracy:
            text += (
                f" The mean of {mean.sizes[0]} tests, without any model, is already off by only "
                f"{mean.percentile[0]:.4f} (0.95 percentile): mu varies so little that {curves.accuracy:g} says when a "
                "model stops failing, not when it is good. The limits nearer to the lowest error say the latter."
            )
        lines.append(text)
    same = sorted({name for f in curves.facts.values() for name in f["not_varied"]})
    if same:
        lines.append(
            f"The averages of {', '.join(same)} are nearly the same in all tests: average-based models do not get what is "
            "left of it, which follows other loads and would be taken for a cause."
        )
    return lines


def _lowest(curves: LearningCurves) -> list[str]:
    lines = []
    for collection in (SERIES, AVERAGE):
        found = _of(curves, collection)
        if found:
            best = min(found, key=lambda c: c.lowest[0])
            low, high = min(c.lowest[0] for c in found), max(c.lowest[0] for c in found)
            lines.append(
                f"Lowest 0.95 percentile of the MAE with {collection}-based data: {low:.4f} ({best.model}, "
                f"{best.lubricant}) to {high:.4f}."
            )
    return lines


def _of(curves: LearningCurves, collection: str, model: str | None = None) -> list[Curve]:
    return [
        c
        for c in curves.curves
        if c.collection == collection and (c.model == model if model else c.model != MEAN)
    ]


def beside_paper(curves: LearningCurves) -> list[tuple[str, str, str]]:
    """Return (quantity, paper, here) of every number that the paper gives."""
    asked = f"tests for MAE < {curves.accuracy:g} with 95 % probability"

    def here(found: Iterable[Curve]) -> str:
        return "; ".join(f"{c.lubricant} {c.needed(curves.accuracy).text()}" for c in found) or "-"

    rows = [
        (f"ffnn, time-series: {asked}", "17", here(_of(curves, SERIES, "ffnn"))),
        (f"polynomial, time-series: {asked}", "25", here(_of(curves, SERIES, "polynomial"))),
        (f"ffnn, average: {asked}", "45 (model not named)", here(_of(curves, AVERAGE, "ffnn"))),
        (f"polynomial, average: {asked}", "45 (model not named)", here(_of(curves, AVERAGE, "polynomial"))),
    ]
    for collection, tests, errors in (
        (SERIES, "about 30", "0.007 - 0.011"),
        (AVERAGE, "about 70", "0.008 - 0.012"),
    ):
        found = _of(curves, collection)
        if found:
            at = [math.ceil(c.converged.tests) for c in found if c.converged.tests is not None]
            never = [f"{c.model} {c.lubricant}" for c in found if c.converged.tests is None]
            low = [c.lowest[0] for c in found]
            said = (f"{min(at)} - {max(at)}" if at else "-") + (f" (not {', '.join(never)})" if never else "")
            rows.append((f"{collection}: converged at (tests)", tests, said))
            rows.append((f"{collection}: error where converged", errors, f"{min(low):.4f} - {max(low):.4f}"))
    return rows


def differs(curves: LearningCurves) -> list[str]:
    """Return what is not as in the paper."""
    lines = []
    if curves.virtual:
        lines.append(
            "The tests are those of a virtual laboratory with laws of its own for the lubricants: errors say how well a model "
            "follows those laws, not the paper's lubricants."
        )
    lowest = [c.lowest[0] for c in curves.curves if c.model != MEAN]
    if lowest and min(lowest) < PAPER_LOWEST:
        lines.append(
            f"The lowest error here, {min(lowest):.4f}, is below the paper's lowest, {PAPER_LOWEST:g}: the limit is further from what "
            "the models reach, and is met with fewer tests."
        )
    other = [m for m in curves.models if m not in ("linear", "polynomial", "ffnn")]
    named = f"The paper names linear, polynomial and ffnn; {' and '.join(other)} {'are' if len(other) > 1 else 'is'} our choice. "
    return [
        *lines,
        "Both collections are judged by the time series of the held-out tests, with loads clamped to the trained "
        "domain as the friction FMUs do; the paper does not say what its average-based models were judged by.",
        f"{named if other else ''}A case is a model with a lubricant.",
        f"Intervals come from resampling repeats and held-out tests together; {curves.repeats} repeats know little of their worst case, so "
        "they are too narrow rather than too wide. With all tests the repeats have one training set, and differ by random starts only.",
        "The paper gives two numbers each for the saving (62 and 73 % fewer tests, 58 and 59 % less error); we compare "
        "with neither.",
    ]


def text_table(curves: LearningCurves) -> str:
    """Return the result as text: a block a lubricant."""
    origin = "virtual laboratory" if curves.virtual else "as the data says of itself"
    lines = [f"synthetic measurements ({origin})"] if curves.synthetic else []
    head = (
        f"{'':20}{'time-series':>22}{'average':>22}  {'time-series needs':20}{'lowest, series':>16}"
        f"{'lowest, average':>17}"
    )
    for lubricant in curves.lubricants:
        lines += [
            "",
            f"{lubricant}: tests for an MAE below {curves.accuracy:g} with 95 % probability (95 % interval)",
            head,
        ]
        for c in (c for c in curves.comparisons if c.lubricant == lubricant):
            low = [
                curve.lowest[0] if (curve := curves.curve(lubricant, k, c.model)) else math.nan
                for k in (SERIES, AVERAGE)
            ]
            lines.append(
                f"{c.model:20}{c.series.text():>22}{c.average.text():>22}  {c.verdict:20}{low[0]:16.4f}{low[1]:17.4f}"
            )
    if curves.missing:
        lines += ["", f"{curves.missing} jobs have no result; see failed.json"]
    return "\n".join([*lines, "", *findings(curves)[:2]])
