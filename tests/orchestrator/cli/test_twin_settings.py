"""`tribofmu twin --set`: settings of the twin from the command line."""

from __future__ import annotations

import json
from importlib.resources import files
from pathlib import Path

import pandas as pd
import pytest
import yaml
from typer.testing import CliRunner

from friction_models.common import InputError
from friction_models.loads.dataset import DataSet
from orchestrator.cli.app import app


def refusal(*arguments: str) -> str:
    """Return why the command refuses; empty where it does not."""
    done = CliRunner().invoke(app, ["twin", *arguments])
    assert done.exception is None or isinstance(done.exception, InputError)
    return str(done.exception or "")


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("materal=steel", "unknown setting of the twin 'materal'; allowed: material, mesh_size,"),
        ("mesh_size=9", "SCT twin: mesh_size = 9 mm; allowed: 0.2 to 1.5 mm"),
        ("uniform_pressure=perhaps", "SCT twin: uniform_pressure = 'perhaps'; allowed: True or False"),
        ("material=nowhere.yaml", "nowhere.yaml"),
    ],
)
def test_a_setting_that_cannot_be_is_refused(tmp_path: Path, setting: str, words: str) -> None:
    assert words in refusal(str(tmp_path), "--set", setting, "-o", str(tmp_path / "data"))
    assert not (tmp_path / "data").exists()


def test_another_steel_is_warmed_by_its_own_work(tmp_path: Path) -> None:
    plan = tmp_path / "plan.csv"
    row = {"test_id": "a", "sigma_set": 1200.0, "v_set": 100.0, "sd_set": 10.0, "T_tool": 20.0}
    pd.DataFrame([row]).to_csv(plan, index=False)
    campaign = tmp_path / "campaign"
    done = CliRunner().invoke(app, ["lab", "--plan", str(plan), "-o", str(campaign), "--jobs", "1"])
    assert done.exit_code == 0, done.output
    steel = tmp_path / "steel.yaml"
    shipped = yaml.safe_load((files("forming.materials") / "16MnCr5.yaml").read_text(encoding="utf-8"))
    shipped["flow_curve"]["A"] *= 1.3
    steel.write_text(yaml.safe_dump(shipped | {"name": "harder"}))
    for name, more in (("usual", []), ("other", ["--set", f"material={steel}"])):
        assert not refusal(str(campaign), *more, "-o", str(tmp_path / name), "--jobs", "1")
    settings = json.loads((tmp_path / "other" / "dataset.json").read_text())["twin"]["settings"]
    assert settings["material"]["name"] == "harder"
    # both fill the bore; the harder one is warmer by then
    warm = [DataSet.load(tmp_path / name).tests["T_start"].iloc[0] for name in ("usual", "other")]
    assert warm[1] - 20.0 > 1.15 * (warm[0] - 20.0)
