"""Commands at work: their files, their record, cancelling, waiting."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import pytest

from orchestrator.app import history
from orchestrator.app.commands import Command
from orchestrator.app.project import HISTORY, WORK, Project
from orchestrator.app.worker import CANCELLED, DONE, FAILED, RUNNING, Job, Worker, shown_line


@pytest.fixture
def worker(example: Project) -> Iterator[Worker]:
    """A worker on a copy of the example."""
    made = Worker(example)
    yield made
    made.close()


def wait(what: Callable[[], bool]) -> None:
    """Wait until something holds; far longer than it takes."""
    for _ in range(1200):
        if what():
            return
        time.sleep(0.05)
    raise AssertionError("it never came")


def ended(worker: Worker, *arguments: str) -> Job:
    job = worker.start(Command("a command", arguments))
    wait(lambda: job.ended)
    return job


def test_a_command_writes_its_files_and_the_history_holds_the_line(worker: Worker, example: Project) -> None:
    command = Command("Pack", ("pack", "0.08", "--target", "c", "-o", "fmus/constant"), {"mark": 1})
    job = worker.start(command)
    assert worker.start(command) is job
    wait(lambda: job.ended)
    assert job.state == DONE, list(job.lines)
    assert (example.root / "fmus/constant/export.json").is_file()
    lines = history.read(example.root / HISTORY)
    assert [line["event"] for line in lines] == ["started", "ended"]
    assert lines[1]["command"] == "tribofmu pack 0.08 --target c -o fmus/constant"
    assert lines[1]["code"] == 0 and lines[1]["mark"] == 1
    assert "written: fmus/constant" in (example.root / WORK / "00001.log").read_text()


def test_a_refused_command_says_why_and_what_it_was_to_leave_is_not_recorded(
    worker: Worker, example: Project
) -> None:
    job = worker.start(Command("Check", ("check", "fmus/none.fmu"), {"round": {"model": "m"}}))
    wait(lambda: job.ended)
    assert job.state == FAILED
    assert "none.fmu" in job.problem() and "error" not in job.problem()
    (end,) = [x for x in history.read(example.root / HISTORY) if x["event"] == "ended"]
    assert end["code"] == 2 and "round" not in end


def test_cancelling_ends_the_command_and_those_that_wait_and_leaves_nothing_half_written(
    worker: Worker, example: Project
) -> None:
    arguments = ("lab", "--plan", "factorial-81", "--seed", "1", "-o", "runs/campaign", "--jobs", "1")
    running = worker.start(Command("Laboratory", arguments))
    waiting = worker.start(Command("Check", ("check", "fmus/none.fmu")))
    wait(lambda: running.state == RUNNING)
    worker.cancel(waiting)
    time.sleep(1.0)
    worker.cancel(running)
    wait(lambda: len(history.read(example.root / HISTORY)) == 2)
    assert running.state == waiting.state == CANCELLED
    assert history.read(example.root / HISTORY)[-1]["code"] == 130
    assert not (example.root / "runs/campaign").exists()
    assert worker.current() == []


def test_the_files_of_the_user_do_not_run_as_modules(worker: Worker, example: Project) -> None:
    (example.root / "json.py").write_text("raise SystemExit('planted')")
    job = ended(worker, "--version")
    assert job.state == DONE and job.lines[-1].startswith("tribofmu ")


def test_what_commands_say_is_shown_without_control_characters() -> None:
    assert shown_line(b"\x1b[31mred\x00\xff" + b"x" * 1000).startswith(" [31mred ")
    assert len(shown_line(b"x" * 1000)) == 400


def test_progress_and_time_left(example: Project) -> None:
    import io

    made = Worker.__new__(Worker)
    made.changes = 0
    job = Job(1, Command("Twin", ("twin",)), RUNNING, began=time.monotonic() - 10.0)
    made._listen(job, io.BytesIO(b"twin: 20/80 twin of test sct020\nnote: 3 of 4\n"), io.BytesIO())
    assert job.progress == 0.25
    left = job.left()
    assert left is not None and 29.0 < left < 40.0
    assert job.saying == "note: 3 of 4"
