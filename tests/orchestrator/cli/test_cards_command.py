"""`cards`, and `card:NAME` wherever a model is taken on the command line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from fmus.runtime.running import RunningFmu, UnpackedFmu
from friction_models import load_card, load_model
from friction_models.loads import LOAD_NAMES, DataSet
from orchestrator.cli.main import run
from orchestrator.cosim.swapping import friction_fmu
from tests.friction_models.made_up import campaign
from tests.friction_models.test_friction_cards import CONTENT


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("cards") / "data"
    names = [f"t{k:02d}" for k in range(10)]
    roles = pd.DataFrame({"test_id": names, "role": ["train"] * 6 + ["test"] * 4})
    DataSet(campaign(10, 12), roles, {"synthetic": True}).save(folder)
    return str(folder)


def test_cards_are_listed_searched_shown_and_drawn(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["cards"]) == 0
    listed = capsys.readouterr().out.splitlines()
    assert len(listed) >= 20 and any(x.startswith("seal-kdn ") and "held-out RMSE" in x for x in listed)
    page, result = tmp_path / "rock.html", tmp_path / "rock.json"
    assert run(["cards", "--search", "Byerlee rock", "--report", str(page), "--json", str(result)]) == 0
    assert {"rock-byerlee", "rock-granite-ground"} <= set(json.loads(result.read_text()))
    html = page.read_text()
    assert "10.1007/BF00876528" in html and html.count("plotly") and "Friction of rocks" in html
    assert run(["cards", "--search", "unobtainium"]) == 0
    assert "no card holds the words 'unobtainium'" in capsys.readouterr().out
    assert run(["cards", "seal-kdn"]) == 0
    assert "licence" not in (shown := capsys.readouterr().out) and "CC0 1.0" in shown
    assert run(["cards", "seal-kd"]) == 2
    assert "did you mean 'seal-kdn'?" in capsys.readouterr().err
    assert run(["cards", "seal-kdn", "--search", "x"]) == 2


def test_own_cards_from_a_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "soap.yaml").write_text(yaml.safe_dump(CONTENT), encoding="utf-8")
    assert run(["cards", "--folder", str(tmp_path)]) == 0
    assert capsys.readouterr().out == "soap  Soap on steel (synthetic)\n"
    assert run(["cards", "soap", "--folder", str(tmp_path), "--report", str(tmp_path / "soap.html")]) == 0
    assert "synthetic" in (tmp_path / "soap.html").read_text()
    out = tmp_path / "soap.fmu"
    assert run(["pack", f"card:{tmp_path / 'soap'}", "-o", str(out)]) == 0
    with RunningFmu(UnpackedFmu.of(out)) as fmu:
        fmu.set_real(LOAD_NAMES, np.array([50.0, 80.0, 1500.0, 0.0, 1.0]))
        assert fmu.get_real(["mu"])[0] == pytest.approx(0.07, rel=1e-14)
    (tmp_path / "soap.yaml").write_text(yaml.safe_dump({**CONTENT, "law": "open('x')"}), encoding="utf-8")
    assert run(["cards", "--folder", str(tmp_path)]) == 2
    assert "holds Call; allowed: numbers" in capsys.readouterr().err


def test_a_card_stands_wherever_a_model_is_taken(
    data: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    name = "card:cold-forging-median"
    assert run(["evaluate", name, "--data", data]) == 0
    assert run(["predict", name, "--data", data, "-o", str(tmp_path / "p.csv")]) == 0
    assert set(pd.read_csv(tmp_path / "p.csv")["mu_model"]) == {0.08}
    assert run(["compare", "--models", name, "card:cold-forging-zinc-free", "0.06", "--data", data]) == 0
    assert "card:cold-forging-zinc-free" in capsys.readouterr().out
    assert run(["pack", name, "--target", "calculix", "-o", str(tmp_path / "ccx")]) == 0
    assert "mu = 0.08 is off by at most" in capsys.readouterr().out  # what remains is told
    refined = [
        "refine",
        "--data",
        data,
        "--model",
        name,
        "--add",
        "stribeck",
        "-o",
        str(tmp_path / "refined"),
    ]
    assert run(refined) == 0
    assert load_model(tmp_path / "refined").name == "formula + stribeck"
    fmu = friction_fmu(
        "card:seal-pk", tmp_path / "seal.fmu", nodes=1
    )  # as `simulate --swap` and `predict-sct` do
    with RunningFmu(UnpackedFmu.of(fmu)) as running:
        running.set_real(LOAD_NAMES, np.array([7.0, 20.0, 0.3, 0.0, 1.0]))
        expected = load_card("seal-pk").model().predict([[7.0, 20.0, 0.3, 0.0, 1.0]])[0]
        assert running.get_real(["mu"])[0] == pytest.approx(expected, rel=1e-13)
    assert run(["pack", "card:seal-qk", "-o", str(tmp_path / "no.fmu")]) == 2
    assert "did you mean 'seal-pk'?" in capsys.readouterr().err


def test_train_from_a_card(data: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["train", "linear", "--data", data, "-o"]
    assert run([*arguments, str(tmp_path / "m"), "--from", "card:cold-forging-median"]) == 0
    assert "prior: card cold-forging-median, as much as" in capsys.readouterr().out
    strong = [*arguments, str(tmp_path / "s"), "--from", "card:cold-forging-median", "--prior-tests", "1e5"]
    assert run(strong) == 0
    points = DataSet.load(data).points
    assert load_model(tmp_path / "s").predict_frame(points).to_numpy() == pytest.approx(0.08, abs=1e-3)
    assert load_model(tmp_path / "m").card["data"]["provenance"]["prior"] == "card cold-forging-median"
    assert run([*arguments, str(tmp_path / "x"), "--prior-tests", "3"]) == 2
    assert "allowed: with --from card:NAME" in capsys.readouterr().err
