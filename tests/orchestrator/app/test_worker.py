"""Commands at work: their files, their record, cancelling, waiting."""

from __future__ import annotations

import io
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from friction_models.common.processes.child_processes import python_command
from orchestrator.app.commands import Command
from orchestrator.app.project import HISTORY, WORK, Project, history
from orchestrator.app.work.command_run import CANCELLED, DONE, FAILED, RUNNING, CommandRun
from orchestrator.app.work.worker import Worker, interrupted_commands, shown_line


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


def ended(worker: Worker, *arguments: str) -> CommandRun:
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


def test_what_a_command_says_of_its_progress(example: Project) -> None:
    made = Worker.__new__(Worker)
    job = CommandRun(1, Command("Twin", ("twin",)), RUNNING, began=time.monotonic() - 10.0)
    made._listen(job, io.BytesIO(b"twin: 20/80 twin of test sct020\nnote: 3 of 4\n"), io.BytesIO())
    assert job.progress == 0.25
    assert job.saying == "note: 3 of 4"
    # One step says nothing of the others.
    assert job.left() is None


#: When commands said how far they were [s, share], and when they ended [s]; on a machine with other work.
DIAGNOSE = [
    (12.0, 0.0),
    (13.2, 0.09),
    (16.0, 0.18),
    (17.4, 0.25),
    (18.6, 0.45),
    (22.1, 0.54),
    (26.3, 0.75),
    (28.8, 1.0),
]
REFINE = [(11.5, 0.0), (12.1, 0.25), (16.3, 0.75), (20.3, 1.0)]
FORM = [(27.9, 0.0), (61.7, 1 / 3), (62.6, 2 / 3), (63.0, 1.0)]
TWIN = [(3.5, 0.0), (39.3, 1 / 81), (43.0, 6 / 81), (50.8, 11 / 81), (62.5, 19 / 81), (73.2, 25 / 81), (82.9, 34 / 81),
        (97.2, 44 / 81), (113.4, 53 / 81), (122.7, 61 / 81), (136.9, 68 / 81), (152.9, 75 / 81)]  # fmt: skip
LAB = [(8.4, 0.0), (15.9, 7 / 81), (21.3, 12 / 81), (27.0, 19 / 81), (32.4, 25 / 81), (38.8, 30 / 81), (45.6, 38 / 81),
       (50.3, 45 / 81), (55.8, 55 / 81), (61.4, 61 / 81), (66.9, 66 / 81), (72.4, 74 / 81)]  # fmt: skip


def guesses(marks: list[tuple[float, float]], end: float, title: str = "x") -> list[tuple[float, float]]:
    """Return what a job shows as its time left, and what it was, every half second."""
    found: list[tuple[float, float]] = []
    told = iter([*marks, (end, 1.0)])
    at, share = next(told)
    with pytest.MonkeyPatch.context() as patch:
        job = CommandRun(1, Command("", ()), RUNNING, began=0.0)
        for tick in range(int(2.0 * end)):
            now = tick / 2.0
            patch.setattr(time, "monotonic", lambda now=now: now)
            while now >= at:
                job.heard(title, share)
                at, share = next(told)
            left = job.left()
            if left is not None:
                found.append((left, end - now))
    return found


@pytest.mark.parametrize(
    ("marks", "end", "shown"),
    [(DIAGNOSE, 31.2, 3.0), (REFINE, 23.9, 0.0), (FORM, 83.3, 0.0), (TWIN, 165.9, 40.0), (LAB, 77.4, 25.0)],
)
def test_a_guess_of_the_time_left_is_right_by_a_factor_of_two_or_not_shown(
    marks: list[tuple[float, float]], end: float, shown: float
) -> None:
    found = guesses(marks, end)
    assert 0.5 * len(found) >= shown
    off = [pair for pair in found if max(pair) > 2.0 * min(pair)]
    assert len(off) <= 0.05 * len(found), off


def test_a_command_of_several_parts_is_not_guessed_at(example: Project) -> None:
    made = Worker.__new__(Worker)
    job = CommandRun(1, Command("x", ("x",)), RUNNING, began=time.monotonic() - 60.0)
    for k in range(20):
        made._listen(job, io.BytesIO(f"records: {k}/40\n".encode()), io.BytesIO())
        job.began -= 2.0
    assert job.left() is not None
    made._listen(job, io.BytesIO(b"twin: 1/40\n"), io.BytesIO())
    for k in range(2, 20):
        made._listen(job, io.BytesIO(f"twin: {k}/40\n".encode()), io.BytesIO())
        job.began -= 2.0
    assert job.progress is not None and job.left() is None


def test_a_command_whose_process_is_killed_ends_with_a_sentence(worker: Worker) -> None:
    job = worker.start(
        Command("Laboratory", ("lab", "--plan", "factorial-81", "-o", "campaigns/a", "--jobs", "1"))
    )
    wait(lambda: job.process is not None)
    assert job.process is not None
    os.kill(job.process.pid, signal.SIGKILL)
    wait(lambda: job.ended)
    assert job.state == FAILED and "was ended from outside (SIGKILL)" in job.problem()
    assert worker.interrupted == []


def test_what_a_killed_server_had_at_work_ends_with_it_and_is_completed_by_the_next(example: Project) -> None:
    (example.root / "data/plan.csv").write_text(
        "test_id,v_set,sigma_set,T_tool,psi_set\n" + "".join(f"a{k},{5 + k},800,20,1.069\n" for k in range(3))
    )
    arguments = ("lab", "--plan", "data/plan.csv", "-o", "campaigns/a", "--jobs", "1")
    code = (
        "from pathlib import Path; import time; from orchestrator.app.commands import Command;"
        "from orchestrator.app.project import Project; from orchestrator.app.work.worker import Worker;"
        f"w = Worker(Project.open(Path({str(example.root)!r}))); j = w.start(Command('Laboratory', {arguments!r}));"
        "\nwhile j.process is None: time.sleep(0.01)\nprint(j.process.pid, flush=True); time.sleep(600)"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        child = int(server.stdout.readline())
        time.sleep(1.0)
        server.kill()

    def alive() -> bool:
        try:
            return "Z" not in Path(f"/proc/{child}/stat").read_text().rpartition(")")[2].split()[0]
        except OSError:
            return False

    wait(lambda: not alive())
    assert not (example.root / "campaigns/a").exists()
    again = Worker(example)
    try:
        (offered,) = again.interrupted
        assert offered.arguments == arguments and offered.title == "Laboratory"
        job = again.start(offered)
        wait(lambda: job.ended)
        assert job.state == DONE and again.interrupted == []
    finally:
        again.close()
    assert len(list((example.root / "campaigns/a/raw").iterdir())) == 3
    assert Worker(example).interrupted == []


@pytest.mark.parametrize(
    "line",
    ["rm -rf x", "tribofmu app x", "tribofmu pack m -o ../x", "tribofmu pack m --out=/x", "tribofmu pack m -o/x", "tribofmu 'x", "tribofmu check ~/x"],
)  # fmt: skip
def test_a_history_of_others_offers_nothing_that_leads_out(example: Project, line: str) -> None:
    history.add(example.root / HISTORY, history.STARTED, job=1, command=line)
    assert interrupted_commands(example) == []


def test_a_quick_command_runs_beside_a_long_one_unless_they_share_files(worker: Worker) -> None:
    lab = ("lab", "--plan", "factorial-81", "-o", "campaigns/a", "--jobs", "1")
    long = worker.start(Command("Laboratory", lab))
    other = worker.start(Command("Table", ("tests", "campaigns/a"), quick=True))
    quick = worker.start(Command("Table", ("tests", "data/sct"), quick=True))
    wait(lambda: quick.ended)
    assert quick.state == DONE and long.state == RUNNING and other.state == "waiting"
    worker.cancel(long)
    wait(lambda: other.ended)
    assert other.state == FAILED and "no such" in other.problem()


def test_a_silent_command_is_interrupted_when_the_pipe_of_its_server_closes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "silent_sleeper.py").write_text(
        # many short pauses: an interrupt that comes just before a long one would wait for its end
        "import time\ndef main():\n    try:\n        print('up', flush=True)\n"
        "        for _ in range(6000):\n            time.sleep(0.1)\n"
        "    except KeyboardInterrupt:\n        raise SystemExit(130) from None\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    command = python_command("orchestrator.app.work.attached", "silent_sleeper")
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True
    ) as child:
        assert child.stdin is not None and child.stdout is not None
        try:
            assert child.stdout.readline() == b"up\n"
            child.stdin.close()
            assert child.wait(60) == 130
        finally:
            child.kill()


def test_no_command_and_no_file_stops_the_worker(worker: Worker, example: Project) -> None:
    """A thread that ended would leave every later command waiting for ever."""
    (example.root / HISTORY).write_text(
        '{"event": "ended", "code": 0, "command": "tribofmu check a", "seconds": true}\n'
    )
    assert ended(worker, "check", "fmus/none.fmu").state == FAILED
    null = ended(worker, "check", "fmus/a\0b.fmu")
    assert null.state == FAILED and "null byte" in null.problem()
    assert ended(worker, "check", "fmus/\ud800.fmu").state == FAILED
    (example.root / HISTORY).unlink()
    (example.root / HISTORY).mkdir()
    deaf = ended(worker, "check", "fmus/none.fmu")
    assert deaf.state == FAILED and HISTORY in deaf.problem()
    (example.root / HISTORY).rmdir()
    assert "none.fmu" in ended(worker, "check", "fmus/none.fmu").problem()


def test_a_command_that_cannot_be_recorded_is_not_begun(
    worker: Worker, example: Project, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Begun before its log could be opened, it went on with nobody who listened or could cancel it."""
    begun: list[object] = []
    monkeypatch.setattr(subprocess, "Popen", lambda *args, **more: begun.append(args))
    shutil.rmtree(example.root / WORK)
    (example.root / WORK).write_text("in the way")
    job = ended(worker, "check", "fmus/none.fmu")
    assert job.state == FAILED and WORK in job.problem() and begun == []


def test_a_folder_of_logs_that_was_removed_comes_back(worker: Worker, example: Project) -> None:
    shutil.rmtree(example.root / WORK)
    assert "none.fmu" in ended(worker, "check", "fmus/none.fmu").problem()


def test_a_log_that_cannot_grow_does_not_end_its_command(worker: Worker, example: Project) -> None:
    (example.root / WORK / "00001.log").symlink_to("/dev/full")
    assert ended(worker, "--version").state == DONE


def test_numbers_of_jobs_are_never_given_twice(example: Project) -> None:
    history.add(example.root / HISTORY, history.ENDED, job=7, command="tribofmu check a", code=0)
    history.add(example.root / HISTORY, history.ENDED, job=["x"], command="tribofmu check a", code=0)
    (example.root / WORK / "00003.log").write_text("of long ago")
    made = Worker(example)
    try:
        assert ended(made, "check", "fmus/none.fmu").number == 8
    finally:
        made.close()
