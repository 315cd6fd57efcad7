"""Which tests would settle the answer: those expected to reduce its entropy most per test.

The answer is a probability of each effect that may be true, and of none of the catalogue (`hypotheses`). Tests that the rig can run
(`protocols`) are judged by what their outcomes would leave of its entropy (`information`).
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any, NotRequired, TypedDict, cast

import numpy as np

from ...common.wording import listed
from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.campaign.gaps import Gap
from ...estimation.campaign.metadata import levels_text
from ...estimation.fit.open_gaps import OpenGap
from ...estimation.search.base_law import BaseLaw
from ...estimation.search.importance import LEAST_SHARE, weighted_rms
from ...estimation.search.scan import Fit
from ...estimation.search.search_round import SearchRound
from ...estimation.search.unseen_loads import driven_by_load
from ...estimation.search.zero_reading import ZERO, expected, zero_is_known
from ...loads import FloatArray
from ...loads.contract import ORDER
from .formula_error import ENOUGH, allowance
from .hypotheses import Hypotheses
from .information import Outcomes
from .protocols import BETWEEN, READING, PlannedTest, PlanRow, SetPoints, possible_tests
from .questions import Answer, Question, weighed

#: Tests of one proposal at several points, and how many of the most telling ones are tried for it.
SEVERAL, TRIED_TOGETHER = 3, 12
#: Most repeats that are asked for.
MOST_REPEATS = 12
#: A proposal with fewer bits, or that tells its pair apart by fewer standard errors, is not made.
LEAST_BITS, USELESS = 0.01, 0.5
#: Protocol of a reading of the cell without load.
READ = "zero reading"
#: Most proposals, and most of them in gaps.
SHOWN, MOST_GAPS = 5, 3


class NextTest(TypedDict):
    """A proposed test.

    What is set in it, which two effects it separates most (one, or none where nothing is missing, if it shows only what friction does between the
    levels of the plan), by how many standard errors, how many repeats that takes, the tests as rows of a plan, by how many bits all of them together are
    expected to reduce the entropy of the answer, and how many tests they are.
    """

    protocol: str
    setpoints: SetPoints
    separates: list[str]
    expected_t: float
    repeats: NotRequired[int]
    plan: list[PlanRow]
    entropy_reduction: float
    tests: int


def propose(
    campaign: BinnedTests,
    questions: Sequence[Question],
    mu: FloatArray,
    base: BaseLaw,
    answer: Answer,
    gaps: Sequence[OpenGap] = (),
    read_first: bool = False,
) -> tuple[list[NextTest], list[str]]:
    """Return the tests that are expected to reduce the entropy of the answer most per test, and remarks.

    `mu`, shape (n,), is the friction of the base, for effects that need one. For each question the best settings of each protocol
    are proposed. A reading without load is among them wherever it tells; it leads if it is to be `read_first`. So is a test in
    each of the `gaps`, whatever it tells of rivals. There is a remark for each rival that no proposal separates, and on what to do
    where loads cannot tell.
    """
    tests = possible_tests(campaign)
    answers = [_for_question(campaign, question, mu, base, answer, tests) for question in questions]
    entries = [e for found, _ in answers for e in found]
    largest: dict[Gap, OpenGap] = {}  # two names may change over one gap
    for open_gap in sorted(gaps, key=lambda g: -g.change):
        if any(t.fills == open_gap.gap for t in tests):
            largest.setdefault(open_gap.gap, open_gap)
    by_effects = [gap for gap in largest.values() if gap.effect]
    in_gaps = [_in_gap(gap, entries, tests) for gap in by_effects[:MOST_GAPS]]
    taken = [w["plan"][0] for w in in_gaps]
    entries = [*(e for e in entries if _tells(e) and e["plan"][0] not in taken), *in_gaps]
    entries.sort(key=lambda e: -e["entropy_reduction"] / e["tests"])
    wanted = [*in_gaps, *[e for e in entries if e["protocol"] == READ][:1]]
    others = [e for e in entries if e not in wanted][: SHOWN - len(wanted)]
    shown = [e for e in entries if e in wanted or e in others]
    # where nothing is missing, what the model alone says of a gap takes no place of a test that tells effects apart
    known = [e["plan"] for e in shown]
    by_model = [_form_in(gap, tests) for gap in largest.values() if not gap.effect][:MOST_GAPS]
    shown = [*shown, *(e for e in by_model if e["plan"] not in known)][: max(SHOWN, len(shown))]
    if read_first:
        shown.sort(key=lambda e: e["protocol"] != READ)
    return shown, [remark for _, remarks in answers for remark in remarks]


def _for_question(
    campaign: BinnedTests,
    question: Question,
    mu: FloatArray,
    base: BaseLaw,
    answer: Answer,
    tests: list[PlannedTest],
) -> tuple[list[NextTest], list[str]]:
    """Return the best test of each protocol, and in each gap, for one question, and its remarks."""
    found, rivals = question.found, question.rivals
    fits, weight = weighed(campaign, question)
    if len(fits) < 2:
        return [], []
    driving = {load for f in fits for load in f.effect.driver}
    tests = [t for t in tests if not t.about or t.about in driving]
    held = {f.name for f in rivals[: question.held]}
    prior = answer.prior(weight, np.array([f.name in held for f in fits]))
    allowed = allowance(max(f.evidence for f in rivals))
    known = Hypotheses(campaign, found, mu, base, fits, prior, tests, question.given, allowed)
    named = known.names
    single = [([t], known.predict([t])) for t in tests] if len(named) > 1 else []
    entries = []
    for kind in dict.fromkeys((s[0][0].protocol, s[0][0].fills) for s in single):
        own = [s for s in single if (s[0][0].protocol, s[0][0].fills) == kind]
        entries.append(_entry(known, named, *max(own, key=lambda s: s[1].reduction)))
    several = _several(known, single)
    if several is not None:
        entries.append(_entry(known, named, *several))
    if ZERO in named and not zero_is_known(campaign, found.floor.sensor):
        entries.append(_zero_reading(campaign, found, fits, prior, tests))
    for entry in entries:
        entry["entropy_reduction"] = round(answer.missing * entry["entropy_reduction"], 3)
    proposed = [o for _, o in single] + ([] if several is None else [several[1]])
    return entries, _remarks(campaign, found, rivals, known.place, proposed)


def _tells(entry: NextTest) -> bool:
    """Return whether an entry is worth a test."""
    return entry["entropy_reduction"] >= LEAST_BITS and entry["expected_t"] >= USELESS


def _in_gap(gap: OpenGap, entries: Sequence[NextTest], tests: Sequence[PlannedTest]) -> NextTest:
    """Return a test in a gap: what tells rivals apart there, too, or one that shows the form of the effect alone."""
    rows = [t.row for t in tests if t.fills == gap.gap]
    telling = [e for e in entries if e["plan"][0] in rows and _tells(e)]
    return max(telling, key=lambda e: e["entropy_reduction"]) if telling else _form_in(gap, tests)


def _form_in(gap: OpenGap, tests: Sequence[PlannedTest]) -> NextTest:
    """Return a test that shows the form of an effect, or of friction, in a gap."""
    inside = next(t for t in tests if t.fills == gap.gap)
    return {
        "protocol": BETWEEN,
        "setpoints": inside.setpoints,
        "separates": [gap.effect] if gap.effect else [],
        "expected_t": 0.0,
        "plan": [inside.row],
        "entropy_reduction": 0.0,
        "tests": 1,
    }


def _several(
    known: Hypotheses, single: Sequence[tuple[list[PlannedTest], Outcomes]]
) -> tuple[list[PlannedTest], Outcomes] | None:
    """Return constant tests that tell most together: the best one, then what adds most."""
    constant = sorted((s for s in single if s[0][0].protocol == "constant"), key=lambda s: -s[1].reduction)
    constant = constant[:TRIED_TOGETHER]
    if len(constant) < 2:
        return None
    chosen = constant[0]
    while len(chosen[0]) < SEVERAL:
        tried = [[*chosen[0], s[0][0]] for s in constant if s[0][0] is not chosen[0][-1]]
        chosen = max(((t, known.predict(t)) for t in tried), key=lambda s: s[1].reduction)
    return chosen


def _entry(known: Hypotheses, names: list[str], tests: list[PlannedTest], outcomes: Outcomes) -> NextTest:
    pair = max(combinations(range(len(names)), 2), key=lambda p: outcomes.pair_reduction(*p))
    t = outcomes.separation(*pair)
    setpoints = tests[0].setpoints
    if len(tests) > 1:
        setpoints = {k: [cast(float, test.setpoints[k]) for test in tests] for k in setpoints}
    entry: dict[str, object] = {
        "protocol": tests[0].protocol if len(tests) == 1 else "points of the plan",
        "setpoints": setpoints,
        "separates": [names[k] for k in pair],
        "expected_t": round(t, 2),
        "plan": [test.row for test in tests],
        "entropy_reduction": round(outcomes.reduction, 3),
        "tests": len(tests),
    }
    repeats = _repeats(known, tests, pair, t)
    return cast(NextTest, entry | ({} if repeats is None else {"repeats": repeats}))


def _repeats(known: Hypotheses, tests: list[PlannedTest], pair: tuple[int, int], t: float) -> int | None:
    """Return how many runs reach `ENOUGH`; None where as many as are asked for do not help: forms differ too little."""
    if t >= ENOUGH:
        return 1

    def enough(count: int) -> bool:
        return known.predict(tests, 1.0 / count).separation(*pair) >= ENOUGH

    if not enough(MOST_REPEATS):
        return None
    return bisect_left(range(MOST_REPEATS), True, lo=2, key=enough)


def _zero_reading(
    campaign: BinnedTests, found: SearchRound, fits: list[Fit], prior: FloatArray, tests: list[PlannedTest]
) -> NextTest:
    """Return a reading without load: it tells the fault of the cell from all laws of pressure."""
    names = [f.name for f in fits]
    place = names.index(ZERO)
    t = expected(campaign, found.floor.sensor, fits[place], READING)
    means = np.zeros((len(prior), 1))
    means[place] = t
    outcomes = Outcomes(prior, np.arange(len(prior)), np.ones(len(prior)), means, np.ones((len(prior), 1, 1)))
    others = [k for k in range(len(fits)) if k != place]
    other = max(others, key=lambda k: prior[k])
    usual = next(test for test in tests if test.protocol == "constant")
    row: PlanRow = {**usual.row, "protocol": "zero_reading", "zero_reading": READING}
    return {
        "protocol": READ,
        "setpoints": {"sigma_n [MPa]": 0.0, "duration [s]": READING},
        "separates": [ZERO, names[other]],
        "expected_t": round(outcomes.separation(place, other), 2),
        "repeats": int(np.ceil((ENOUGH / max(t, 0.1)) ** 2)),
        "plan": [row],
        "entropy_reduction": round(outcomes.reduction, 3),
        "tests": 1,
    }


def _remarks(
    campaign: BinnedTests,
    found: SearchRound,
    rivals: list[Fit],
    place: Mapping[str, int],
    outcomes: Sequence[Outcomes],
) -> list[str]:
    """Return what no proposed test tells apart, and how to tell what no load drives."""
    result = []
    first, *others = rivals
    unloaded = [f for f in rivals if not driven_by_load(f.effect)]
    for rival in others:
        if ZERO in (first.name, rival.name) or not {first.name, rival.name} <= set(place):
            continue
        if first in unloaded and rival in unloaded:
            continue
        pair = place[first.name], place[rival.name]
        best = max(o.separation(*pair) for o in outcomes)
        if best < ENOUGH:
            result.append(_inseparable(campaign, found, first, rival, best))
    return [*result, _crossed(campaign, unloaded)] if len(unloaded) > 1 else result


def _crossed(campaign: BinnedTests, unloaded: list[Fit]) -> str:
    """Return how to tell effects apart that columns of the test table drive; nobody sets the run order of a test that is done."""
    drivers = dict.fromkeys(f.effect.driver[0] for f in unloaded)
    columns = listed(levels_text(campaign.loads, name) for name in drivers if name != ORDER)
    how = f"run the same loads again with {columns} crossed, that is each value of the one with each of the other"
    if ORDER in drivers:
        how = "repeat early tests at the end, in another order"
        how += f", and one test at the beginning and the end of each value of {columns}" if columns else ""
    return f"{listed(f.name for f in unloaded)}: no load drives them, so no setting of the rig tells them apart; {how}"


def _inseparable(campaign: BinnedTests, found: SearchRound, first: Fit, rival: Fit, best: float) -> str:
    """Return a remark about two effects that no proposed test tells apart."""
    drivers = [f.effect.driver for f in (first, rival)]
    apart = weighted_rms(found.change(first) - found.change(rival), campaign.count)
    text = f"{first.name} and {rival.name}: "
    if drivers[0] == drivers[1]:
        text += f"same driver ({', '.join(drivers[0])}), other formula; "
    if best < USELESS:
        text += "no test that could be proposed tells them apart; "
    else:
        text += f"no test that could be proposed is expected to separate them (at best {best:.3g} standard errors, {ENOUGH:g} are needed); "
    text += f"in the tests that are there they differ by {apart:.2g} in mu (rms)"
    if apart**2 < LEAST_SHARE * found.floor.total**2:
        text += ", too little to matter: within the tested range either predicts alike"
    return text


def plan_rows(next_tests: Sequence[Mapping[str, Any]]) -> list[dict[str, str | float]]:
    """Return the rows of all proposed tests, each once, as one plan."""
    rows: list[dict[str, str | float]] = []
    for entry in next_tests:
        rows += [dict(r) for r in entry["plan"] if dict(r) not in rows]
    return rows
