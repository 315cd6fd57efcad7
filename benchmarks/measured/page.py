"""``docs/measured-data.md``: what each table is, what the tool says of it, and what it should say."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence

from ..common import Table
from ..discovery.study import wilson
from .answers import LISTS, Answer, Entry, Result, Wanted
from .origins import ORIGINS
from .run import COPIES_RAISE, INVARIANCES, Mean, over_budget, same, tempted

GRADES = ("acceptable", "debatable", "wrong", "refused", "crashed")
SURE = 0.9
#: The budget is a sum of squares of numbers of double precision.
EQUAL = 1e-6

HEAD = """# Measured data

Written by `make bench-measured`; nothing here is typed by hand. What the diagnosis says of friction that other people measured,
beside what it should say. None of it is cold forging: it shows how a diagnosis behaves on measurements that nobody made up. The
acceptable answers were written down before the diagnosis was run on these tables, from statistics that use nothing of it
(`python -m benchmarks.measured.statistics` prints them again); they stand in `benchmarks/measured/answers.yaml`. Base: the linear
model, straight lines in the recorded loads. Loads that were not recorded are left out. The tables are not part of the repository:
without them nothing is measured. Sources and licences are named with each table.

- *acceptable*: the numbers support this answer; *debatable*: it can be defended; *wrong*: whatever stands on neither list.
- *refused*: the table is not taken, with a sentence that says why. It counts as no answer.
- Errors of the reasons are root mean squares on groups that were left out. *Share*: the part of the avoidable squared error that a
  form removes.
"""


def share(hits: int, total: int) -> tuple[str, str]:
    """Return a rate and its 95 % interval as the page shows them."""
    if not total:
        return "none", ""
    low, high = wilson(hits, total)
    return f"{hits} of {total} ({100 * hits / total:.0f} %)", f"{100 * low:.0f} to {100 * high:.0f} %"


def answered(results: Iterable[Result]) -> list[Result]:
    """Return the results with an answer."""
    return [r for r in results if r["answer"]["status"] == "answered"]


def page(results: Sequence[Result], wanted: Mapping[str, Wanted], machine: str) -> str:
    """Return the whole page."""
    lines = [HEAD, f"Measured on: {machine}.", "", "## Summary", "", *summary(results, wanted).lines(), ""]
    lines += ["## Invariance", "", *invariance_text(results), "", *invariances(results).lines(), ""]
    lines += ["## All tables", "", *overview(results).lines(), ""]
    for function in dict.fromkeys(r["call"]["function"] for r in results):
        origin = ORIGINS[function]
        lines += [f"## {origin.title}", "", origin.what, ""]
        lines += [f"Source: {origin.source}. Licence: {origin.licence}.", ""]
        for result in results:
            if result["call"]["function"] == function:
                lines += [*of_set(result, wanted[result["name"]]), ""]
    return "\n".join(lines).rstrip() + "\n"


def summary(results: Sequence[Result], wanted: Mapping[str, Wanted]) -> Table:
    """Return grades, over-confidence, crashes and budget."""
    table = Table(["what", "reached", "95 % interval"])
    grades = Counter(r["grade"] for r in results)
    for grade in GRADES:
        table.rows.append((grade, *share(grades[grade], len(results))))
    own = answered(results)
    sure = [r for r in own if r["answer"]["confidence"] >= SURE]
    table.rows.append(
        (
            f"wrong, of those with a confidence of {SURE:g} or more",
            *share(sum(r["grade"] == "wrong" for r in sure), len(sure)),
        )
    )
    limited = [r for r in own if "confidence_at_most" in wanted[r["name"]]]
    over = [r for r in limited if r["answer"]["confidence"] > wanted[r["name"]]["confidence_at_most"]]
    table.rows.append(
        (
            "more confident than the data allow, of the tables with a stated limit",
            *share(len(over), len(limited)),
        )
    )
    changed = [a for r in results for a in r["changed"].values()]
    crashed = sum(a["status"] == "crashed" for a in [*changed, *(r["answer"] for r in results)])
    table.rows.append(
        ("crashes, changed tables counted as well", *share(crashed, len(changed) + len(results)))
    )
    means: tuple[tuple[Mean, str], ...] = (
        ("mean_square", "each average weighted with its points"),
        ("plain_mean_square", "all averages with the same weight"),
    )
    for mean, words in means:
        off = [over_budget(r["answer"], mean) for r in own]
        table.rows.append(
            (
                "budget off: floor² + explained² + missing² is not the mean square of what the base leaves in the table of "
                f"averages, {words} (largest deviation {max(off, default=0.0):.1g})",
                *share(sum(o > EQUAL for o in off), len(own)),
            )
        )
    return table


def invariance_text(results: Sequence[Result]) -> list[str]:
    """Say what is compared, and whether copies make the diagnosis surer."""
    pairs = [
        (r["answer"], r["changed"]["copies"])
        for r in answered(results)
        if r["changed"]["copies"]["status"] == "answered"
    ]
    surer = sum(b["confidence"] > a["confidence"] + COPIES_RAISE for a, b in pairs)
    return [
        "Share of the answers that stay the same when a table is changed. Another row order, another unit, identical copies and a "
        "column of three random names say nothing new; every second point or a tenth of the tests take a little away. A change is "
        "counted where it does anything: a table of one mean a test cannot be thinned. An answer that turns into a refusal has "
        "changed.",
        "",
        f"Identical copies raise the confidence by more than {COPIES_RAISE:g} in {share(surer, len(pairs))[0]}: they must not.",
    ]


def invariances(results: Sequence[Result]) -> Table:
    """Return one row for each change."""
    table = Table(
        ["change", "verdict and first effect", "95 % interval", "verdict", "first effect", "changed"]
    )
    for change, words in INVARIANCES.items():
        found = {
            r["name"]: same(r["answer"], r["changed"][change])
            for r in answered(results)
            if change in r["changed"]
        }
        both = [verdict and first for verdict, first in found.values()]
        names = ", ".join(n for n, ok in zip(found, both, strict=True) if not ok)
        table.rows.append(
            (
                words,
                *share(sum(both), len(both)),
                f"{sum(v for v, _ in found.values())} of {len(found)}",
                f"{sum(f for _, f in found.values())} of {len(found)}",
                names,
            )
        )
    return table


def overview(results: Sequence[Result]) -> Table:
    """Return one row a table."""
    table = Table(["table", "tests", "points", "verdict", "effects", "confidence", "grade"])
    for r in results:
        own = r["answer"]
        said = (
            (own["verdict"], ", ".join(own["effects"]), f"{own['confidence']:.2f}")
            if own["status"] == "answered"
            else (own["status"], "", "")
        )
        table.rows.append((r["name"], r["tests"], r["points"], *said, r["grade"]))
    return table


def of_set(result: Result, wanted: Wanted) -> Iterator[str]:
    """Yield the lines of one table."""
    own = result["answer"]
    yield f"### {result['name']}"
    yield ""
    yield f"{result['description']} Tests: {result['tests']}, points: {result['points']}."
    yield ""
    yield from says(own)
    yield f"- Grade: **{result['grade']}**."
    limit = wanted.get("confidence_at_most")
    if limit is not None:
        kept = own["status"] == "answered" and own["confidence"] <= limit
        yield f"- Confidence at most {limit:g}: {'kept' if kept else '**not kept**'}."
    if "must_warn" in wanted:
        yield f"- Must warn: {wanted['must_warn']}. Warnings: {'; '.join(own.get('warnings', [])) or 'none'}."
    for word in LISTS:
        if wanted[word]:
            yield f"- {word.capitalize()}: {'; '.join(entry_text(e) for e in wanted[word])}."
    yield "- Why:"
    yield from (f"  - {plain(reason)}" for reason in wanted["because"])
    if result["grade"] == "wrong":
        reasons = list(dict.fromkeys(tempted(own, wanted))) or ["it stands on neither list"]
        yield from (f"- Why the answer is wrong: {plain(reason)}." for reason in reasons)


def says(own: Answer) -> Iterator[str]:
    """Yield what the tool says."""
    if own["status"] != "answered":
        yield f"- The tool {own['status']}: {plain(own['said'])}"
        return
    names = ", ".join(f"`{n}`" for n in own["effects"]) or "no effect"
    alike = ", ".join(f"`{n}`" for n in own["confusion_set"]) or "nothing"
    yield f"- The tool says: `{own['verdict']}`, {names}; confusion set: {alike}; confidence {own['confidence']:.2f}."
    budget = own["budget"]
    off = over_budget(own)
    check = "equal" if off <= EQUAL else f"**off by {off:.1%}**"
    yield (
        f"- Budget: floor {budget['floor']:.4f}, explained {budget['explained']:.4f}, missing {budget['missing']:.4f}; the "
        f"base leaves {own['mean_square'] ** 0.5:.4f} (squares: {check})."
    )


def entry_text(entry: Entry) -> str:
    """Return one acceptable or debatable answer in words."""
    text = f"`{entry['verdict']}`"
    if entry.get("all_of"):
        text += f" with {' and '.join(entry['all_of'])}"
    if entry.get("any_of"):
        text += f" with {' or '.join(entry['any_of'])}"
    besides = [
        n for n in entry.get("only_from", []) if n not in {*entry.get("all_of", []), *entry.get("any_of", [])}
    ]
    if besides and entry["verdict"] != "ambiguous":
        text += f" (beside it at most {', '.join(besides)})"
    return text


def plain(text: str) -> str:
    """Return text that markdown does not take for its own marks."""
    return " ".join(str(text).split()).replace("|", "/").replace("*", "\\*").replace("<", "&lt;")
