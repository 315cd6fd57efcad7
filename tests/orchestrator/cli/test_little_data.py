"""One test, or one point: commands go on, and say how little that tells; what stands twice, or means nothing, is refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from orchestrator.cli.main import run

HEAD = "test_id,v_rel,sigma_n,mu\n"
Said = Callable[..., tuple[int, str, str]]


@pytest.fixture
def told(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Said:
    """Run a command in an empty folder; its exit code and what it printed."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments: str) -> tuple[int, str, str]:
        code = run(arguments)
        printed = capsys.readouterr()
        return code, printed.out, printed.err

    return call


def test_one_point_is_told_as_such_from_table_to_comparison(told: Said, tmp_path: Path) -> None:
    (tmp_path / "one.csv").write_text(HEAD + "a,10,100,0.1\n")
    code, out, _ = told("points", "one.csv", "-o", "data")
    assert code == 0 and "(1 test, 1 point; not measured: T, sd, psi)" in out
    code, out, err = told("train", "linear", "--data", "data", "-o", "linear")
    assert code == 0 and "trained on 1 test (1 point): the errors above say nothing about new tests" in err
    assert "no prediction interval: interval: 1 test, allowed" in out
    code, out, _ = told("compare", "--models", "linear", "0.2", "--data", "data", "--report", "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert code == 0 and "linear is ahead, but not clearly, of 0.2 on 1 test (1 point)\n" in out
    assert "too few were measured to tell models apart" in page
    assert all("trained on the only test" in text and "not known" in text for text in (out, page))
    assert "nan" not in out


def test_a_model_that_stands_twice_is_not_dropped_silently(told: Said, tmp_path: Path) -> None:
    (tmp_path / "one.csv").write_text(HEAD + "a,10,100,0.1\nb,20,200,0.2\n")
    told("points", "one.csv", "-o", "data")
    code, _, err = told("compare", "--models", "0.1", "0.2", "0.1", "--data", "data")
    assert code == 2 and "--models: 0.1 stands 2 times; allowed: each model once" in err


def test_pounds_a_square_inch_are_a_pressure(told: Said, tmp_path: Path) -> None:
    (tmp_path / "inch.csv").write_text("test_id,p [psi],mu\na,1000,0.1\n")
    (tmp_path / "map.yaml").write_text("columns: {p: sigma_n, mu: mu, test_id: test_id}\n")
    assert told("points", "inch.csv", "--map", "map.yaml", "-o", "data")[0] == 0
    stored = (tmp_path / "data/points.csv").read_text().splitlines()[2].split(",")[1]
    # 1 lbf = 4.4482216152605 N on 1 in2 = 645.16 mm2.
    assert float(stored) == pytest.approx(1000 * 4.4482216152605 / 645.16, rel=1e-12)


def test_a_time_of_building_that_is_none_is_refused_by_its_name(
    told: Said, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "today")
    code, _, err = told("cards")
    assert code == 2 and "SOURCE_DATE_EPOCH: 'today'; allowed: seconds since 1970" in err


@pytest.mark.parametrize("command", [["train", "linear", "-o", "m"], ["diagnose", "--model", "linear"]])
def test_roles_without_one_to_learn_from_are_named(command: list[str], told: Said, tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "data/points.csv").write_text(HEAD + "a,10,100,0.1\nb,20,100,0.1\n")
    (tmp_path / "data/tests.csv").write_text("test_id,role\na,test\nb,test\n")
    code, _, err = told(*command, "--data", "data")
    assert (
        code == 2 and "data: no test has the role 'train', the table holds test; allowed: at least one" in err
    )
    (tmp_path / "data/tests.csv").write_text("test_id,role\na,tset\nb,tset\n")
    code, _, err = told(*command, "--data", "data")
    assert code == 2 and "role 'tset' of 2 tests is none of train, test; did you mean 'test'?" in err
    (tmp_path / "data/tests.csv").write_text("test_id,role\na,train\nb,test\nplanned,train\n")
    _, _, err = told(*command, "--data", "data")
    assert "1 test of the table without points (planned)" in err


@pytest.mark.parametrize("command", ["evaluate", "predict", "train"])
def test_points_that_no_table_describes_and_distances_that_fall_are_told(
    command: str, told: Said, tmp_path: Path
) -> None:
    (tmp_path / "data").mkdir()
    head, rows = "test_id,t,v_rel,sd,mu\n", "a,0,10,0,0.1\na,1,10,5,0.1\nb,0,20,0,0.2\nb,1,20,5,0.1\n"
    (tmp_path / "data/points.csv").write_text(head + rows)
    (tmp_path / "data/tests.csv").write_text("test_id,role\na,train\nb,test\n")
    assert told("train", "linear", "--data", "data", "-o", "m")[0] == 0
    arguments = {
        "evaluate": ["m", "--data", "data"],
        "predict": ["m", "--data", "data", "-o", "p.csv"],
        "train": ["linear", "--data", "data", "-o", "n"],
    }[command]
    _, _, err = told(command, *arguments)
    assert "of tests" not in err and "falls" not in err
    (tmp_path / "data/points.csv").write_text(head + rows + "c,0,10,5,0.1\nc,1,10,0,0.1\n")
    code, _, err = told(command, *arguments)
    assert code == 0 and "1 test without a row in the table of tests (c): for training" in err
    assert "sd falls within one test" in err


def test_an_earlier_answer_that_is_not_there_is_told(told: Said, tmp_path: Path) -> None:
    (tmp_path / "data.csv").write_text(HEAD + "a,10,100,0.1\nb,20,100,0.1\n")
    code, _, err = told("diagnose", "--data", "data.csv", "--model", "linear", "--after", "nope.json")
    assert code == 2 and "nope.json: no such file" in err


def test_several_effects_in_one_word_are_told_apart(told: Said, tmp_path: Path) -> None:
    (tmp_path / "data.csv").write_text(HEAD + "a,10,100,0.1\nb,20,100,0.1\n")
    code, _, err = told(
        "refine", "--data", "data.csv", "--model", "linear", "--add", "stribeck,batch", "-o", "m"
    )
    assert code == 2 and "allowed: --add stribeck --add batch" in err
