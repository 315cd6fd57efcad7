"""The measured tables themselves, and one of them from the data to the page. Skipped without the data."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.measured import DATA, __main__, page, run, tables, variants


@pytest.fixture
def data() -> Path:
    if not (DATA / "real").is_dir():
        pytest.skip("the measured data are not beside the repository")
    return DATA


@pytest.mark.parametrize("name", list(tables.TABLES))
def test_loads_that_were_not_recorded_are_left_out(name: str, data: Path) -> None:
    points, tests, description = run.table_of({"function": name, "arguments": {}}, data)
    assert set(points["test_id"]) == set(tests["test_id"]) and tests["test_id"].is_unique
    assert "psi" not in points and "psi" in description.split("left out:")[-1]
    left_out = description.split("left out:")[-1].strip(" .").split(", ")
    assert not set(left_out) & set(points) and "mu" in points
    assert points.notna().all().all()


def test_changes_change_what_they_say(data: Path) -> None:
    points, tests, _ = run.table_of({"function": "pneumatic_seal", "arguments": {"ring": "PK"}}, data)
    thin, _ = variants.thin(points, tests)
    assert len(thin) == len(points) / 2
    twice, named = variants.copies(points, tests)
    assert len(twice) == 2 * len(points) and named["test_id"].is_unique
    fewer, _ = variants.drop_tests(points, tests)
    assert 0 < fewer["test_id"].nunique() < len(tests)
    assert variants.metres(points, tests)[0]["v_rel"].iloc[0] == points["v_rel"].iloc[0] / 1000
    assert "batch" in variants.random_column(points, tests)[1] and "batch" not in tests
    assert run.applies("thin", points, tests) and not run.applies("drop_tests", points, tests[:5])


def test_one_table_from_the_data_to_the_page(data: Path, tmp_path: Path) -> None:
    names = ["motor_oil_from_3_N"]
    told: list[str] = []
    found = run.run_all(data, tmp_path, told.append, names)
    assert len(told) == 6  # no time series to thin
    assert run.run_all(data, tmp_path, told.append, names) == found and len(told) == 6  # nothing is run again
    (result,) = found
    assert result["grade"] in page.GRADES and result["answer"]["status"] == "answered"
    assert run.over_budget(result["answer"]) < 1e-9
    text = page.page(found, run.expected(), "here")
    for words in ("## Summary", "## Invariance", "### motor_oil_from_3_N", "Licence: MIT", "Grade:", "Why:"):
        assert words in text


@pytest.mark.nightly
def test_of_two_effects_that_cancel_one_that_explains_alone_is_named(data: Path) -> None:
    """Friction of this pair falls with pressure; a second effect of it, tied to the first, predicted a little more, and hid both."""
    points, tests, _ = run.table_of({"function": "miba_dynamic", "arguments": {"system": "i"}}, data)
    answer = run.answer_to(points, tests)
    assert "pressure_power" in answer["effects"] and answer["verdict"] != "unknown_structure"


def test_without_the_data_nothing_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "page.md"
    monkeypatch.setattr("sys.argv", ["measured", "-o", str(out), "--data", str(tmp_path / "nothing")])
    __main__.main()
    assert "skipped" in capsys.readouterr().out and not out.exists()
