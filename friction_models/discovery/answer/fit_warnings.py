"""Warnings about fitted parameters: what of them is not known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...common.wording import listed
from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.campaign.curves import transformed
from ...estimation.fit.open_gaps import OpenGap, open_gaps
from ...estimation.fit.parameters import FittedTerms
from ...estimation.search.law_signs import runs_against, turning_point
from ...estimation.search.zero_reading import share_of_mu
from ...loads import POINT_UNITS
from ...loads.contract import behind

#: A fault of the data that makes more than this share of the measured mu of a test is worth a look at the rig.
LARGE_FAULT = 0.1


def about_the_fit(campaign: BinnedTests, fitted: FittedTerms) -> list[str]:
    """Return warnings about parameters at bounds and at the end of the search, pairs that the data tie to each other, and sizes that are not known."""
    at_bounds = [
        f"{term.name}: the fit drives {shape.name} to {bound:.4g}, the bound of what is allowed: the law may have another form, and "
        "the intervals of its parameters hold for this value only"
        for term in fitted.terms
        for shape in term.effect.shapes
        if shape.name in term.at_bounds
        for bound in [min(shape.lower, shape.upper, key=lambda b: abs(b - term.shape[shape.name]))]
    ]
    at_limits = [
        f"{term.name}: the fit drives {name} to {term.shape[name]:.4g}{behind(shape.unit)}, as far as it is sought for these tests "
        f"({low:.4g} to {high:.4g}): they show a part of the law only, so {name} is not known, and the other intervals hold beside this value only"
        for term in fitted.terms
        for name in term.at_limits
        for shape in term.effect.shapes
        if shape.name == name
        for low, high in [term.sought[name]]
    ]
    highest = campaign.largest_mu
    opposed = [
        f"{term.name} contributes up to {largest:.2g}, more than the largest mu ({highest:.2g}): model and effect make up for each other "
        "there, and only their sum is known"
        for term in fitted.terms
        if (largest := float(np.max(np.abs(term.binned)))) > highest
    ]
    faults = [
        f"{term.name} makes up to {np.max(np.abs(term.binned)):.2g} of mu, and {100 * share:.0f} % of what one test measured: `refine` takes it off "
        "the measurements, so if it is no fault the law gets worse by that; check it on the rig first"
        for term in fitted.terms
        if term.effect.kind == "fault" and (share := share_of_mu(campaign, term.binned)) > LARGE_FAULT
    ]
    tied = {name for first, second, _ in fitted.correlations for name in (first, second)}
    unsized = [
        f"{term.name}: the interval of {a.name} ({low:.2g} to {high:.2g}) reaches 0: by itself it is not known, beside the other "
        "parameters and the model it is tied to; whether the effect is there, unseen tests say"
        for term in fitted.terms
        for a in term.effect.amplitudes
        if a.sign and a.name in term.intervals and f"{term.name}.{a.name}" not in tied
        for low, high in [term.intervals[a.name]]
        if low <= 0.0 <= high
    ]
    known = at_bounds + at_limits + tied_text(fitted.correlations) + opposed + faults + unsized
    return [*known, *_turning(campaign, fitted), *_between(campaign, fitted)]


def tied_text(correlations: Sequence[tuple[str, str, float]]) -> list[str]:
    """Return a warning for each set of parameters that the data tie to one another.

    Examples
    --------
    >>> pairs = [("a.n", "a.delta", 0.99), ("b.n", "b.delta", -0.95), ("a.delta", "a.scale", -0.93)]
    >>> for line in tied_text(pairs):
    ...     print(line)
    the data tie a.n, a.delta, a.scale to one another (correlations of 0.93 to 0.99): each alone is poorly known
    the data tie b.n, b.delta to one another (correlation -0.95): each alone is poorly known
    """
    sets: list[list[str]] = []
    for first, second, _ in correlations:
        joined = [names for names in sets if first in names or second in names]
        sets = [names for names in sets if names not in joined]
        sets.append(list(dict.fromkeys([*(n for names in joined for n in names), first, second])))
    lines = []
    for names in sorted(sets, key=lambda names: min(k for k, c in enumerate(correlations) if c[0] in names)):
        values = [value for first, _, value in correlations if first in names]
        low, high = (f"{f(map(abs, values)):.2f}" for f in (min, max))
        size = f"correlations of {low} to {high}" if low != high else f"correlations of {high}"
        if len(values) == 1:
            size = f"correlation {values[0]:+.2f}"
        lines.append(f"the data tie {', '.join(names)} to one another ({size}): each alone is poorly known")
    return lines


def _turning(campaign: BinnedTests, fitted: FittedTerms) -> list[str]:
    """Return warnings about laws that turn along the load of an effect, which goes one way, or run the other way."""
    if not fitted.terms:
        return []
    base, said = fitted.base(campaign), []
    for term in fitted.terms:
        name, *others = term.effect.driver
        if others or name not in campaign.varied or term.effect.needs_state:
            continue
        turn = turning_point(campaign, name, base, term.binned)
        falls = np.corrcoef(transformed(campaign, name), term.binned)[0, 1] < 0.0
        way, other, least = ("falls", "rises", "lowest") if falls else ("rises", "falls", "highest")
        beside = f"{term.name} {way} with {name}, and the model beside it {other}"
        if turn is not None:
            said.append(f"{beside}: together mu is {least} at about {turn:.3g}{behind(POINT_UNITS[name])}")
        elif runs_against(campaign, name, base, term.binned):
            said.append(f"{beside} by more: together mu {other}")
    return said


def _between(campaign: BinnedTests, fitted: FittedTerms) -> list[str]:
    """Return warnings about loads that were not measured where the formula of an effect alone says how it changes."""
    by_load: dict[tuple[str, str], list[OpenGap]] = {}
    for found in open_gaps(campaign, fitted):
        by_load.setdefault((found.effect, found.gap.load), []).append(found)
    said = []
    for (effect, name), gaps in by_load.items():
        unit = behind(POINT_UNITS[name])
        where = ", nor ".join(f"between {g.gap.low:.3g} and {g.gap.high:.3g}{unit}" for g in gaps)
        changes = listed(f"{g.change:.2g}" for g in gaps)
        middles = listed(f"{g.gap.middle:.3g}" for g in gaps)
        tests = "tests" if len(gaps) > 1 else "a test"
        said.append(
            f"no test measured {name} {where}, and {effect} changes by {changes} in between: how, only its formula says, and "
            f"prediction of unseen tests at the same levels cannot tell; {tests} at about {middles}{unit} would"
        )
    return said
