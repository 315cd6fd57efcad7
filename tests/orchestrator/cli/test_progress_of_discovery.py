"""`diagnose` and `refine` say how far they are; interrupted, they leave no file."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from orchestrator.cli.main import run


@pytest.fixture
def data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Eight made-up tests in which friction falls with temperature; every tick becomes a line."""
    monkeypatch.setenv("TRIBOFMU_PROGRESS_EVERY", "0")
    draw = np.random.default_rng(1)
    place = [(k, j) for k in range(8) for j in range(12)]
    mu = [0.1 - 0.002 * j + 0.0005 * draw.normal() for _, j in place]
    points = pd.DataFrame(place, columns=["test_id", "sd"]).assign(T=[20.0 + 10 * j for _, j in place], mu=mu)
    points["test_id"] = "t" + points["test_id"].astype(str)
    points.to_csv(tmp_path / "points.csv", index=False)
    return tmp_path / "points.csv"


def lines(data: Path, command: str) -> list[str]:
    asked = f"diagnose --data {data} --model constant --json OUT.json --report OUT.html --plan OUT.csv"
    added = f"refine --data {data} --model constant --add thermal_softening -o OUT --report OUT.html"
    return {"diagnose": asked, "refine": added}[command].replace("OUT", str(data.parent / "out")).split()


@pytest.mark.parametrize("command", ["diagnose", "refine"])
def test_a_share_rises_to_the_whole(command: str, data: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert run(lines(data, command)) == 0
    shares = [int(x) for x in re.findall(rf"^{command}: (\d+)/100 \w", capfd.readouterr().err, re.M)]
    assert shares == sorted(shares) and shares[0] == 0 and shares[-1] == 100 and len(set(shares)) > 4
    assert (data.parent / "out.html").is_file()


@pytest.mark.parametrize("command", ["diagnose", "refine"])
def test_interrupted_while_the_page_is_built_nothing_was_written(
    command: str, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> str:
        raise KeyboardInterrupt

    monkeypatch.setattr("orchestrator.report.registry.page_of", interrupted)
    before = sorted(data.parent.iterdir())
    assert run(lines(data, command)) == 130
    assert sorted(data.parent.iterdir()) == before


def test_errors_beside_a_corrected_fault_say_that_the_measurements_hold_it(
    data: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    points = pd.read_csv(data)
    tests = pd.DataFrame({"test_id": points["test_id"].unique()}).assign(order=lambda t: t.index + 1.0)
    points["mu"] += 0.005 * points["test_id"].map(tests.set_index("test_id")["order"])
    points.to_csv(data, index=False)
    tests.to_csv(data.parent / "tests.csv", index=False)
    added = f"refine --data {data.parent} --model linear --add sensor_drift -o OUT --report OUT.html"
    assert run(added.replace("OUT", str(data.parent / "out")).split()) == 0
    said = "The measurements still hold sensor_drift here, which the model leaves out"
    table, _, rounds = capsys.readouterr().out.partition(said)
    assert "Evaluation of after" in table and "Rounds of additions" in rounds
    assert said in (data.parent / "out.html").read_text(encoding="utf-8")
    assert run(lines(data, "refine")) == 0 and said not in capsys.readouterr().out
