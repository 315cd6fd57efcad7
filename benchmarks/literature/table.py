"""Print what a results file says: ``python -m benchmarks.literature.table results.jsonl [more.jsonl ...]``."""

from __future__ import annotations

import argparse
import json
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Literal

import numpy as np

from .calibration import reliability
from .law import Law
from .line import Line
from .names import in_twin_group
from .registry import get

#: Scores that are yes or no.
YesNo = Literal[
    "false_alarm",
    "first",
    "first_or_twin",
    "in_set",
    "in_set_or_twin",
    "exact",
    "exact_or_twin",
    "abstains",
    "right",
]
TIMES: tuple[Literal["t_make", "t_diagnose", "t_refine"], ...] = ("t_make", "t_diagnose", "t_refine")


def load(paths: Iterable[Path]) -> list[Line]:
    """Lines of results files; the last line of a case counts, broken lines are skipped."""
    found: dict[str, Line] = {}
    for path in paths:
        for text in path.read_text().splitlines():
            try:
                line = json.loads(text)
            except json.JSONDecodeError:
                continue
            found[line["id"]] = line
    return list(found.values())


def _kind(lines: list[Line], *kinds: str) -> list[Line]:
    return [x for x in lines if x["case"]["kind"] in kinds]


def _ok(lines: list[Line]) -> list[Line]:
    return [x for x in lines if x["status"] == "ok"]


def _failed_is_false(lines: list[Line], key: YesNo) -> list[bool]:
    """Values of a score; a crash, refusal or time-out counts as a failure."""
    return [bool(x["score"][key]) if x["status"] == "ok" else False for x in lines]


def _share(values: list[bool]) -> str:
    if not values:
        return "   -      (0)"
    n, k = len(values), sum(values)
    # Wilson interval: honest for small numbers and shares near 0 or 1.
    z, p = 1.96, k / n
    middle = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n)) / (1 + z * z / n)
    return f"{p:5.3f}  ({k}/{n}; {max(middle - half, 0):.2f} - {min(middle + half, 1):.2f})"


def _laws(line: Line) -> list[Law]:
    return [get(key) for key in line["case"]["laws"]]


def _no_twins(line: Line) -> bool:
    return not any(in_twin_group(law.accept) for law in _laws(line))


def _quantiles(values: list[float]) -> str:
    if not values:
        return "-  (0)"
    a = np.asarray(values)
    return f"median {np.median(a):6.3f}   10th percentile {np.quantile(a, 0.1):6.3f}   (n = {len(a)})"


def false_alarms(lines: list[Line]) -> list[str]:
    """Answers other than nothing missing on data with nothing missing, by recipe."""
    null = _kind(lines, "null")
    text = ["False alarms (nothing is missing)"]
    by: dict[str, list[bool]] = defaultdict(list)
    for x in _ok(null):
        by[x["case"]["recipe"]].append(bool(x["score"]["false_alarm"]))
    text += [f"  {recipe:18s} {_share(values)}" for recipe, values in by.items()]
    text.append(f"  {'all recipes':18s} {_share([v for values in by.values() for v in values])}")
    said = Counter(
        e
        for x in _ok(null)
        if x["score"]["false_alarm"]
        for e in (x["answer"]["effects"] or [x["answer"]["verdict"]])
    )
    if said:
        text.append("  said instead: " + ", ".join(f"{k} {n}" for k, n in said.most_common(8)))
    return text


def single_effects(lines: list[Line]) -> list[str]:
    """Right first, in the set, size of the set."""
    single = _kind(lines, "single")
    physics = [x for x in single if not any(law.fault for law in _laws(x))]
    faults = [x for x in single if any(law.fault for law in _laws(x))]
    clear = [x for x in physics if _no_twins(x)]
    told = [x["answer"]["verdict"] == "data_problem" for x in _ok(faults)]
    sizes = [x["score"]["set_size"] for x in _ok(physics) if x["score"]["set_size"]]
    text = [
        "Single effects (a crash, refusal or time-out counts as wrong)",
        f"  right first, outside inherent twins   {_share(_failed_is_false(clear, 'first'))}",
        f"  right first, all, strict              {_share(_failed_is_false(physics, 'first'))}",
        f"  right first, all, twins accepted      {_share(_failed_is_false(physics, 'first_or_twin'))}",
        f"  truth in set, strict                  {_share(_failed_is_false(physics, 'in_set'))}",
        f"  truth in set, twins accepted          {_share(_failed_is_false(physics, 'in_set_or_twin'))}",
        f"  mean size of the set                  {np.mean(sizes) if sizes else float('nan'):5.2f}  ({len(sizes)})",
        f"  faults: right first                   {_share(_failed_is_false(faults, 'first'))}",
        f"  faults: verdict data_problem          {_share(told)}",
    ]
    for low, high in ((0.0, 0.8), (0.8, 1.5), (1.5, 10.0)):
        part = [x for x in physics if "truth" in x and low <= x["truth"]["laws"][0]["ratio"] < high]
        text.append(
            f"  size {low:.1f} - {high:4.1f} of the scatter: first   {_share(_failed_is_false(part, 'first'))}"
        )
    return text


def by_law(lines: list[Line]) -> list[str]:
    """One line a law of single effects: right first, in the set, what was said."""
    text = ["Single effects by law: first (twin) in set | answers"]
    groups: dict[str, list[Line]] = defaultdict(list)
    for x in _kind(lines, "single", "outside"):
        groups[x["case"]["laws"][0]].append(x)
    for key, some in groups.items():
        said = Counter("+".join(x["answer"]["effects"]) or x["answer"]["verdict"] for x in _ok(some))
        if get(key).outside:
            marks = f"{sum(_failed_is_false(some, 'abstains'))}/{len(some)} abstains "
        else:
            marks = (
                f"{sum(_failed_is_false(some, 'first'))}/{len(some)} "
                f"({sum(_failed_is_false(some, 'first_or_twin'))}) {sum(_failed_is_false(some, 'in_set'))}      "
            )
        text.append(f"  {key:24s} {marks:16s} | " + ", ".join(f"{k} {n}" for k, n in said.most_common(4)))
    return text


def several(lines: list[Line]) -> list[str]:
    """Pairs and triples."""
    text = ["Several effects"]
    for kind in ("pair", "triple"):
        some = _kind(lines, kind)
        text += [
            f"  {kind}: exact, strict                {_share(_failed_is_false(some, 'exact'))}",
            f"  {kind}: exact, twins accepted        {_share(_failed_is_false(some, 'exact_or_twin'))}",
            f"  {kind}: first is one of them         {_share(_failed_is_false(some, 'first_or_twin'))}",
            f"  {kind}: no wrong name accepted       {_share([not x['score']['wrong_names'] for x in _ok(some)])}",
        ]
    return text


def outside(lines: list[Line]) -> list[str]:
    """Outside the catalogue, thin and foreign data."""
    strange, mixed = _kind(lines, "outside"), _kind(lines, "mixed")
    verdicts = Counter(x["answer"]["verdict"] for x in _ok(strange))
    text = [
        "Outside the catalogue",
        f"  abstains or partly without wrong name {_share(_failed_is_false(strange, 'abstains'))}",
        "  verdicts: " + ", ".join(f"{k} {n}" for k, n in verdicts.most_common()),
        f"  known and unknown law together: same  {_share(_failed_is_false(mixed, 'abstains'))}",
        f"  known and unknown: known one in set   {_share(_failed_is_false(mixed, 'in_set_or_twin'))}",
        f"  unrecorded group: no wrong name       {_share(_failed_is_false(_kind(lines, 'hidden_group'), 'abstains'))}",
        "Thin and foreign data",
    ]
    for kind in ("thin", "foreign"):
        some = _kind(lines, kind)
        calm = [bool(x["score"]["abstains"]) for x in _ok(some)]
        said = Counter(x["answer"]["verdict"] if x["status"] == "ok" else x["status"] for x in some)
        text += [
            f"  {kind}: no wrong name accepted, of those answered {_share(calm)}",
            f"  {kind}: " + ", ".join(f"{k} {n}" for k, n in said.most_common()),
        ]
    return text


def refinement(lines: list[Line]) -> list[str]:
    """What accepted additions do on held-out tests."""
    some = [x for x in _ok(lines) if x.get("refinement")]
    accepted = [x for x in some if x["refinement"]["accepted"]]
    harms = [bool(x["refinement"]["harms"]) for x in accepted if x["refinement"]["harms"] is not None]
    away = [x["id"] for x in accepted if x["refinement"]["harms"]]
    text = [
        "Refinement on held-out tests (other loads, same law, no noise)",
        f"  accepted additions that lead away     {_share(harms)}",
    ]
    text += [f"    {name}" for name in away[:12]]
    groups: tuple[tuple[str, Callable[[Line], bool]], ...] = (
        ("single", lambda x: x["case"]["kind"] == "single"),
        ("pair and triple", lambda x: x["case"]["kind"] in ("pair", "triple")),
        ("all in catalogue", lambda x: x["case"]["kind"] in ("single", "pair", "triple")),
    )
    for label, chosen in groups:
        part = [x for x in some if chosen(x) and x["refinement"]["avoidable"]]
        named = [x["refinement"]["removed"] for x in part if x["refinement"]["removed"] is not None]
        every = [x["refinement"]["removed"] or 0.0 for x in part]
        text += [
            f"  removed, {label}, something named:  {_quantiles(named)}",
            f"  removed, {label}, all (0 if none):  {_quantiles(every)}",
        ]
    errors = Counter(
        (x["refinement"]["refine_error"] or "")[:80] for x in some if x["refinement"]["refine_error"]
    )
    text += [f"  refine failed: {k} ({n})" for k, n in errors.most_common(5)]
    own = Counter(x["refinement"]["base_by"] for x in some)
    text.append("  linear base by: " + ", ".join(f"{k} {n}" for k, n in own.most_common()))
    return text


def confidences(lines: Iterable[Line]) -> list[tuple[float, bool]]:
    """Confidence of every answer that is right or wrong, and whether it is right."""
    return [
        (x["answer"]["confidence"], x["score"]["right"])
        for x in lines
        if x["status"] == "ok" and x["answer"]["confidence"] is not None and x["score"]["right"] is not None
    ]


def confidence(lines: list[Line]) -> list[str]:
    """Expected calibration error and reliability table."""
    pairs = confidences(lines)
    error, table = reliability([c for c, _ in pairs], [r for _, r in pairs])
    text = [
        f"Confidence: expected calibration error {error:5.3f}  ({len(pairs)} answers)",
        "  said          n    mean   right",
    ]
    text += [f"  {b.low:.1f} - {b.high:.1f}  {b.n:5d}   {b.said:5.2f}   {b.was:5.2f}" for b in table if b.n]
    sure = [r for c, r in pairs if c >= 0.9]
    return [*text, f"  right at confidence of 0.9 and more   {_share(sure)}"]


def times(lines: list[Line]) -> list[str]:
    """Times and what did not finish."""
    text = ["Times [s] and failures"]
    for key in TIMES:
        a = [time for x in lines if (time := x.get(key)) is not None]
        if a:
            text.append(
                f"  {key:11s} median {np.median(a):6.2f}  90 % {np.quantile(a, 0.9):6.2f}  max {max(a):6.2f}"
            )
    text.append(
        "  status: " + ", ".join(f"{k} {n}" for k, n in Counter(x["status"] for x in lines).most_common())
    )
    for x in lines:
        if x["status"] not in ("ok",):
            text.append(f"    {x['id']}: {x['status']} {str(x.get('error', ''))[:110]}")
    return text


def report(lines: list[Line], laws: bool = True) -> str:
    """All tables as text.

    Parameters
    ----------
    lines : list of Line
        Results.
    laws : bool
        Include the table by law.

    Returns
    -------
    str
        Text of several lines.
    """
    parts = [false_alarms, single_effects, several, outside, refinement, confidence, times]
    blocks = ["\n".join(part(lines)) for part in parts]
    if laws:
        blocks.insert(2, "\n".join(by_law(lines)))
    return f"{len(lines)} cases, all synthetic\n\n" + "\n\n".join(blocks) + "\n"


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", type=Path, nargs="+")
    parser.add_argument("--short", action="store_true", help="without the table by law")
    options = parser.parse_args()
    print(report(load(options.results), laws=not options.short))


if __name__ == "__main__":
    main()
