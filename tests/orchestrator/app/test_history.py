"""The history: what it makes of broken lines, and where the loop stands after it."""

from __future__ import annotations

import json
from pathlib import Path

from orchestrator.app.project import history
from orchestrator.app.project.history import ACCEPTED, CHOSEN, ENDED, TAKEN_BACK, Story


def refined(model: str, code: int = 0) -> dict[str, object]:
    return {"event": ENDED, "code": code, "round": {"model": model, "added": ["stribeck"]}}


def test_lines_are_kept_and_broken_ones_left_out(tmp_path: Path) -> None:
    file = tmp_path / "history.jsonl"
    history.add(file, CHOSEN, data="data/sct", model="linear")
    history.add(file, ENDED, code=0, command="tribofmu pack é")
    with file.open("a") as stream:
        stream.write(
            '[]\n"x"\n{"no": "event"}\n{"event": 3}\n' + "[" * 20_000 + '\n{"event": "started", "comm'
        )
    assert [line["event"] for line in history.read(file)] == [CHOSEN, ENDED]
    assert history.read(tmp_path / "none.jsonl") == []
    assert all(json.loads(x)["time"].endswith("+00:00") for x in file.read_text().splitlines()[:2])


def test_an_addition_counts_when_it_is_accepted_and_can_be_taken_back() -> None:
    chosen = {"event": CHOSEN, "data": "data/sct", "model": "linear"}
    lines: list[dict[str, object]] = [chosen, refined("models/a"), {"event": ACCEPTED}, refined("models/b")]
    story = Story.of(lines)
    assert story.model == "models/a" and story.candidate is not None and story.candidate.model == "models/b"
    dismissed = Story.of([*lines, {"event": TAKEN_BACK}])
    assert dismissed.model == "models/a" and dismissed.candidate is None
    undone = Story.of([*lines, {"event": ACCEPTED}, {"event": TAKEN_BACK}, {"event": TAKEN_BACK}])
    assert undone.model == "linear" and len(undone.rounds) == 1
    assert Story.of([*lines, chosen]).rounds[0].model == "linear"


def test_each_of_several_additions_can_be_decided_on() -> None:
    lines: list[dict[str, object]] = [
        {"event": CHOSEN, "data": "data/sct", "model": "linear"},
        refined("models/a"),
        refined("models/b"),
        refined("models/a"),
    ]
    assert [r.model for r in Story.of(lines).waiting] == ["models/b", "models/a"]
    earlier = Story.of([*lines, {"event": ACCEPTED, "model": "models/b"}])
    assert earlier.model == "models/b" and earlier.waiting == []
    left = Story.of([*lines, {"event": TAKEN_BACK, "model": "models/a"}])
    assert left.model == "linear" and [r.model for r in left.waiting] == ["models/b"]
    # The others belong to the model before: they cannot be accepted any more.
    late = [*lines, {"event": ACCEPTED, "model": "models/b"}, {"event": ACCEPTED, "model": "models/a"}]
    assert [r.model for r in Story.of(late).rounds] == ["linear", "models/b"]
    # Another loop in between takes none of them away.
    away = {"event": CHOSEN, "data": "data/b", "model": "linear"}
    assert len(Story.of([*lines, away, {**away, "data": "data/sct"}]).waiting) == 2


def test_a_loop_that_was_left_goes_on_where_it_was() -> None:
    def chosen(data: str, model: str) -> dict[str, object]:
        return {"event": CHOSEN, "data": data, "model": model}

    lines = [chosen("data/a", "linear"), refined("models/x"), {"event": ACCEPTED}, refined("models/y"), {"event": ACCEPTED}]  # fmt: skip
    lines.append(chosen("data/b", "linear"))
    back = Story.of([*lines, chosen("data/a", "models/y")])
    assert [r.model for r in back.rounds] == ["linear", "models/x", "models/y"]
    # An earlier model is the way to it; taking back leads on from there; other measurements, or the start, begin anew.
    way = [*lines, chosen("data/a", "models/x"), {"event": TAKEN_BACK}]
    assert [r.model for r in Story.of(way).rounds] == ["linear"]
    assert [r.model for r in Story.loops(way)[1].rounds] == ["linear", "models/x", "models/y"]
    assert [r.model for r in Story.of([*lines, chosen("data/b", "models/y")]).rounds] == ["models/y"]
    assert [r.model for r in Story.of([*lines, chosen("data/a", "linear")]).rounds] == ["linear"]


def test_the_model_at_the_start_cannot_be_taken_back_and_failed_commands_change_nothing() -> None:
    lines: list[dict[str, object]] = [
        {"event": CHOSEN, "data": "d", "model": "linear"},
        {"event": TAKEN_BACK},
        {"event": ACCEPTED},
        refined("models/a", code=2),
    ]
    story = Story.of(lines)
    assert story.model == "linear" and story.candidate is None


def test_wrong_kinds_of_values_do_no_harm() -> None:
    lines: list[dict[str, object]] = [
        {"event": CHOSEN, "data": 3, "model": None},
        {"event": ENDED, "code": 0, "round": {"added": "stribeck"}},
        {"event": ENDED, "code": 0, "round": "models/a"},
    ]
    story = Story.of(lines)
    assert story.data == "3" and story.candidate is not None and story.candidate.added == []


def test_a_line_behind_one_that_broke_off_is_not_lost(tmp_path: Path) -> None:
    file = tmp_path / "history.jsonl"
    file.write_text('{"event": "chosen", "data": "data/sct", "mod')
    history.add(file, ACCEPTED, model="models/a")
    history.add(file, TAKEN_BACK)
    assert [line["event"] for line in history.read(file)] == [ACCEPTED, TAKEN_BACK]
    assert "\n\n" not in file.read_text()


def test_a_line_holds_any_text(tmp_path: Path) -> None:
    file = tmp_path / "history.jsonl"
    texts = ["a\u2028b\x85c\x1dd", "half \ud800 of a letter", "é"]
    for text in texts:
        history.add(file, ENDED, command=text)
    assert [line["command"] for line in history.read(file)] == texts


def test_a_decision_that_is_told_twice_counts_once() -> None:
    """A button pressed twice, or in two tabs."""
    chosen: dict[str, object] = {"event": CHOSEN, "data": "data/sct", "model": "linear"}
    a: list[dict[str, object]] = [chosen, refined("models/a"), {"event": ACCEPTED, "model": "models/a"}]
    back: dict[str, object] = {"event": TAKEN_BACK, "model": "models/b"}
    story = Story.of([*a, refined("models/b"), back, back])
    assert story.model == "models/a" and story.candidate is None
    b = [*a, refined("models/b"), {"event": ACCEPTED, "model": "models/b"}]
    assert Story.of([*b, back, back]).model == "models/a"
    # One tab took it back and got another before the other tab accepted what it showed.
    late = Story.of(
        [*a, refined("models/b"), back, refined("models/c"), {"event": ACCEPTED, "model": "models/b"}]
    )
    assert late.model == "models/a" and late.candidate is not None and late.candidate.model == "models/c"


def test_an_addition_belongs_to_the_loop_that_asked_for_it() -> None:
    def chosen(data: str, model: str = "linear") -> dict[str, object]:
        return {"event": CHOSEN, "data": data, "model": model}

    def added(data: str, model: str, out: str) -> dict[str, object]:
        line = f"tribofmu refine --data {data} --model {model} --add stribeck -o {out}"
        return {**refined(out), "command": line}

    lines = [chosen("data/a"), chosen("data/b"), added("data/a", "linear", "models/x")]
    assert Story.of(lines).candidate is None
    back = Story.of([*lines, chosen("data/a")])
    assert back.candidate is not None and back.candidate.model == "models/x"
    assert Story.of([*lines, chosen("data/b")]).candidate is None
    # What two tabs added to the same model: the second does not hold the first, and is no round behind it.
    both = [chosen("data/a"), added("data/a", "linear", "models/x"), {"event": ACCEPTED, "model": "models/x"}]
    story = Story.of([*both, added("data/a", "linear", "models/y")])
    assert story.model == "models/x" and story.candidate is None
