"""Several campaigns as one: names, roles, order, columns."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from benchmarks.discovery_campaigns import campaign
from friction_models.common import InputError
from friction_models.discovery.further_tests.joined import join_campaigns
from friction_models.loads import DataSet
from orchestrator.cli.main import run


def part(
    names: list[str], tests: pd.DataFrame | None = None, synthetic: bool = True, **more: float
) -> DataSet:
    points = pd.DataFrame(
        {
            "test_id": names,
            "v_rel": 10.0,
            "T": 50.0,
            "sigma_n": 900.0,
            "sd": 1.0,
            "psi": 1.1,
            "mu": 0.08,
            **more,
        }
    )
    return DataSet(points, tests, {"synthetic": synthetic})


def test_names_roles_and_order_go_on() -> None:
    old = part(["a", "b"], pd.DataFrame({"test_id": ["a", "b"], "role": ["train", "test"], "order": [2, 1]}))
    new = part(["b", "c"], pd.DataFrame({"test_id": ["b", "c"], "order": [1, 2], "hold": [60.0, None]}))
    data, said = join_campaigns({"old": old, "new": new, "third": part(["c"])})
    assert data.tests is not None and data.points["test_id"].tolist() == ["a", "b", "new b", "c", "third c"]
    assert data.tests["test_id"].tolist() == ["a", "b", "new b", "c", "third c"]
    assert data.tests["role"].tolist() == ["train", "test", "train", "train", "train"]
    assert data.tests["order"].tolist() == [2, 1, 3, 4, 5], "tests without an order follow as they stand"
    assert said == [
        "new: test names that are taken: 'b' is called 'new b'",
        "third: test names that are taken: 'c' is called 'third c'",
    ]
    assert (
        data.synthetic
        and data.points.attrs["synthetic"]
        and data.info["campaigns"] == ["old", "new", "third"]
    )


def test_what_does_not_fit_is_said_or_refused() -> None:
    data, said = join_campaigns({"old": part(["a"], t=0.1), "own": part(["b"], synthetic=False, F_n=9e4)})
    assert list(data.points.columns) == ["test_id", "v_rel", "T", "sigma_n", "sd", "psi", "mu"]
    assert len(said) == 2 and "time t" in said[0] and "all of it counts as synthetic" in said[1]
    cold = part(["a"])
    cold.points = cold.points.drop(columns="T")
    with pytest.raises(InputError, match=r"cold: column 'T' \[degC\] is missing, old has it"):
        join_campaigns({"old": part(["a"]), "cold": cold})
    with pytest.raises(InputError, match="none was given"):
        join_campaigns({})


def test_one_command_diagnoses_old_and_new_tests(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    points, tests, _ = campaign("stribeck", seed=61, strength=2.0, thin=20)
    points = points.drop(columns="psi")
    for name, keep in (("old", tests["test_id"][:-3]), ("new", tests["test_id"][-3:])):
        (tmp_path / name).mkdir()
        number = {t: f"t{k}" for k, t in enumerate(keep)}
        for table, file in ((points, "points.csv"), (tests, "tests.csv")):
            own = table[table["test_id"].isin(keep)]
            own.assign(test_id=own["test_id"].map(number)).to_csv(tmp_path / name / file, index=False)
    both = ["--data", str(tmp_path / "old"), "--data", str(tmp_path / "new")]
    assert run(["diagnose", *both, "--model", "linear"]) == 0
    said = capsys.readouterr().out
    assert "new: test names that are taken: 't0' is called 'new t0', 2 more alike" in said
    assert "the data lack psi" in said
    for wrong, message in (
        (["--data", str(tmp_path / "old"), "--data", str(tmp_path / "old")], "given twice"),
        ([*both, "--tests", str(tmp_path / "old" / "tests.csv")], "beside 2 --data"),
        ([*both, "--after", "a.json", "--after", "b.json"], "'--after': given 2 times; allowed: once"),
        ([*both, "--isolate", "--no-isolate"], "given 2 times; allowed: once"),
        ([*both, "--seed", "-5"], "greater than or equal to 0"),
    ):
        assert run(["diagnose", *wrong, "--model", "linear"]) == 2
        assert message in capsys.readouterr().err
