"""The section of the benchmark page: the third kept apart, whatever the results are."""

from __future__ import annotations

import pytest

from benchmarks import __main__ as benchmarks_page
from benchmarks.literature import Case, cases, page
from benchmarks.literature.answers import Answer, score
from benchmarks.literature.line import Line, begun
from benchmarks.literature.noise import RECIPES
from benchmarks.literature.registry import get


def lines(right: set[str]) -> list[Line]:
    """Return results of an oracle for the cases `right`, and time-outs for the others."""
    found: list[Line] = []
    for case in cases():
        line = begun(case, "timeout")
        if case.id in right:
            law = get(case.laws[0]) if case.laws else None
            known = law is not None and not law.outside and case.kind == "single"
            names = [sorted(law.right())[0]] if law and known else []
            verdict = "explained" if known else "nothing_missing" if not law else "unknown_structure"
            line["status"] = "ok"
            line["answer"] = {"verdict": verdict, "effects": names, "confusion": names, "confidence": 0.95}
            line["score"] = score(case, Answer(verdict, names, names, 0.95))
        found.append(line)
    return found


def rows(results: list[Line]) -> dict[str, list[str]]:
    found = page.summary(results)["lines"]
    cells = [[c.strip() for c in text.strip("|").split("|")] for text in found if text.startswith("|")]
    return {c[0]: c[1:] for c in reversed(cells)}


def test_every_third_case_is_kept_apart() -> None:
    unseen = page.ids_apart()
    assert len(unseen) == 90 and cases()[2].id in unseen and cases()[5].id in unseen
    assert not {cases()[0].id, cases()[1].id, cases()[3].id} & unseen


def test_that_third_is_counted_apart() -> None:
    found = rows(lines(page.ids_apart()))
    unseen, other = found["one law: right effect first"][0], found["one law: right effect first"][2]
    assert unseen.endswith("(100 %)") and other.startswith("0 of ")
    assert found["false alarms, nothing missing"][0].startswith("0 of ")
    assert found["false alarms, nothing missing"][2].endswith("(100 %)")  # no answer is no right answer
    assert found["crashes and time-outs"][:3:2] == ["0 of 90 (0 %)", "180 of 180 (100 %)"]
    assert found["one law: right effect first"][1] != ""  # an interval


def test_a_part_of_the_cases_is_called_a_part() -> None:
    some = lines(page.ids_apart())[:6]
    assert "This run holds 6 of the 270 cases." in page.summary(some)["text"]
    assert "This run holds" not in page.summary(lines(set()))["text"]


def test_the_page_says_what_was_seen() -> None:
    text = page.summary(lines(set()))["text"]
    for words in ("synthetic", "0, 3, 6", "1, 4, 7", "2, 5, 8", "have been read", "before it was tried"):
        assert words in text
    assert set(page.SAID) == set(RECIPES)
    assert benchmarks_page.PARTS["literature"]


@pytest.mark.parametrize("status", ["refused", "crash"])
def test_tables_with_few_tests_may_be_refused_but_not_crash(status: str) -> None:
    line = begun(Case("x", "thin", (), "plain", 1), status)
    assert page.nothing_wrong(line) is (None if status == "refused" else False)
