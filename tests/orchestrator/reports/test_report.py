"""Reports: complete, self-contained, escaped; statistics that count whole tests."""

from __future__ import annotations

import json
import re
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from benchmarks.discovery_campaigns import campaign
from friction_models import LinearFriction
from friction_models.common import InputError, write_text
from friction_models.common.markup import escape, table
from friction_models.discovery import diagnose, refine
from friction_models.discovery.answer.figures_data import load_map
from friction_models.discovery.answer.summaries import load_bins
from friction_models.discovery.answer.wording import p_text
from friction_models.discovery.judged_addition import Addition
from friction_models.discovery.refinement_rounds import history_text
from friction_models.loads import DataSet
from orchestrator import Master, System
from orchestrator.report import write_report
from orchestrator.report.charts.diagnosis import ranking_chart
from orchestrator.report.charts.residuals import binned_residual
from orchestrator.report.pages import diagnosis
from orchestrator.report.pages.diagnosis import confirmed_addition
from orchestrator.report.pages.refinement import refinement_page
from orchestrator.report.parts.cards import Change
from orchestrator.report.parts.theme import AFTER
from orchestrator.report.registry import PAGES, page_of
from orchestrator.report.sections.evidence import ranking_html
from tests.friction_models import made_up
from tests.friction_models.discovery.test_next_tests import THREE, falling_and_running_in
from tests.orchestrator.tiny_fmus import system_content


def outside_references(html: str) -> list[str]:
    """What a browser would fetch: sources, style sheets, imports - outside the embedded library."""
    own = re.sub(r"<script.*?</script>", "", html, flags=re.DOTALL)
    return re.findall(r"(?:src|href)\s*=\s*[\"'](?!#|data:)[^\"']+|@import|url\((?!data:)", own)


def test_a_run_report_is_self_contained(tiny: dict[str, Path], tmp_path: Path) -> None:
    content = system_content(tiny["law"], tiny["process"], synthetic=True, name="<b>tiny</b> & co")
    Master(System.from_dict(content)).run(tmp_path / "run")
    html = write_report(tmp_path / "run").read_text(encoding="utf-8")
    assert outside_references(html) == []
    assert html.count("plotly.js v") == 1  # the library is there, once
    assert "synthetic data" in html
    assert "&lt;b&gt;tiny&lt;/b&gt; &amp; co" in html and "<b>tiny" not in html
    assert re.search(r"<html lang=\"en\">", html) and "aria-label" in html
    assert (tmp_path / "run" / "report.html").is_file()
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text())
    del manifest["versions"]
    (tmp_path / "run" / "manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(InputError, match=r"damaged or of another version \(KeyError: 'versions'\)"):
        write_report(tmp_path / "run")


def test_a_folder_that_is_neither_run_nor_demo(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="neither a folder of a run or a study"):
        write_report(tmp_path)
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "manifest.json").write_text("{}")
    with pytest.raises(InputError, match=f"inside is {tmp_path / 'run'}"):
        write_report(tmp_path)
    for folder, out, words in (
        ("none", None, "none: no such folder"),
        ("run/manifest.json", tmp_path / "x.html", "manifest.json: is a file; allowed: the folder"),
        ("run", tmp_path / "run.doc", "suffix '.doc'; allowed: .html, .htm, .pdf, .xlsx"),
    ):
        with pytest.raises(InputError, match=words):
            write_report(tmp_path / folder, out)
    (tmp_path / "x.html").mkdir()
    with pytest.raises(InputError, match=r"x\.html: is a folder; allowed: a file"):
        write_text(tmp_path / "x.html", "")
    (tmp_path / "demo.json").write_text("{}")
    with pytest.raises(InputError, match="not a complete demo folder"):
        write_report(tmp_path)
    assert not (tmp_path / "report.html").exists()


def test_intervals_count_whole_tests() -> None:
    rng = np.random.default_rng(0)
    offsets = rng.normal(0.0, 0.005, 12)
    test = np.repeat(np.arange(12), 400)
    residual = offsets[test] + rng.normal(0.0, 0.0005, len(test))
    found = binned_residual(np.tile(np.linspace(0.0, 60.0, 400), 12), residual, test.astype(str))
    expected = stats.t.ppf(0.975, 11) * offsets.std(ddof=1) / np.sqrt(12)
    assert len(found.mean) == 9 and (found.tests == 12).all()
    np.testing.assert_allclose(found.half, expected, rtol=0.1)
    np.testing.assert_allclose(found.mean, offsets.mean(), atol=3e-4)


@pytest.mark.parametrize("values", [[1.0] * 10, [5.0, 200.0] * 5, list(range(10))])
def test_loads_that_are_constant_in_a_test_still_get_bins(values: list[float]) -> None:
    test = np.repeat(np.arange(10), 20)
    load = np.repeat(np.array(values, dtype=float), 20)
    found = binned_residual(load, np.full(200, 0.01), test.astype(str))
    assert len(found.mean) >= 1
    assert (found.tests >= 3).all() and found.tests.sum() == 10
    np.testing.assert_allclose(found.mean, 0.01)


def test_cards_say_when_an_error_rises() -> None:
    assert "fell by 50 %" in Change("mu", 0.010, 0.005).card()
    assert "rose by 20 %" in Change("force", 5.0, 6.0, "%", 1).card()
    assert "unchanged" in Change("force", 5.0, 5.0).card()


def test_markup_is_escaped() -> None:
    html = table(["<a>"], [("x & y", "<script>")], numeric=(1,))
    assert "<script>" not in html and "x &amp; y" in html and 'class="n"' in html
    assert escape('"') == "&quot;"
    assert (p_text(0.0001), p_text(0.0123), p_text(None)) == ("< 0.001", "0.012", "-")


#: Campaign, verdict, and a piece that page and text must hold.
CASES = {
    "explained": (partial(campaign, "wear_out", seed=21, strength=1.2, extra=0), "explained", "wear_out"),
    "unknown": (
        partial(campaign, seed=90, strength=1.2, shape=lambda r, g: (r.v - 200) * (r.psi - 1.4)),
        "unknown_structure",
        "Where structure is left",
    ),
    "nothing": (partial(campaign, seed=501, extra=0), "nothing_missing", "nothing is missing"),
    "fault": (
        partial(campaign, "sensor_drift", seed=70, strength=1.2, extra=0),
        "data_problem",
        "sensor_drift",
    ),
}


@pytest.mark.parametrize(
    "case",
    ["explained", "nothing", *(pytest.param(c, marks=pytest.mark.nightly) for c in ("unknown", "fault"))],
)
def test_page_and_text_of_a_diagnosis(case: str, tmp_path: Path) -> None:
    made, verdict, piece = CASES[case]
    points, tests, _ = made(thin=24)
    found = diagnose(points, tests)
    assert found.verdict == verdict
    confirmed = confirmed_addition("linear", DataSet(points, tests, {}), found.effects)
    html = page_of("diagnosis", found, "a <b>", confirmed)
    text = found.report()
    assert "<b>" not in html and outside_references(html) == []
    sections = [
        "verdict",
        "budget",
        "residual",
        "evidence",
        "tests",
        *(["response"] if found.effects else []),
    ]
    assert re.findall(r'<section id="(\w+)"', html) == sections
    assert (
        text.startswith(verdict.upper())
        and "; p: family-wise" in text
        and " needed" not in text.split("Ranked evidence")[1].split("\n")[0]
    )
    assert piece in re.sub(r"<script.*?</script>", "", html, flags=re.DOTALL) and piece in text
    assert ("after " in text) == bool(found.effects) and "[MPa]" in text
    if (
        verdict == "explained"
    ):  # errors of tests that the refit did not see, and the share of mu over the driver
        assert "fell by" in html and "share of mu" in text and "sd [mm]" in text
        before, after = (found.averages[k].pow(2).mean() for k in ("before", "after"))
        assert after < before
        assert json.dumps(found.to_dict())  # the table stays out of the file


def test_errors_of_a_part_of_the_points_say_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """`refine` judges on all points: the same words over other numbers would puzzle."""
    steps = [(k, j) for k in range(6) for j in range(16)]
    data = pd.DataFrame({"test_id": [f"test{k}" for k, _ in steps], "sd": [2.0 * j for _, j in steps]})
    data = data.assign(T=[20.0 + 5 * j for _, j in steps], mu=[0.1 - 0.001 * j + 1e-5 * k for k, j in steps])
    for most, said in ((1000, False), (40, True)):
        monkeypatch.setattr(diagnosis, "MOST_POINTS", most)
        found = confirmed_addition("constant", DataSet(data, None, {}), ["thermal_softening"])
        assert found is not None and ("on one point in 2" in found["judged_by"]) == said


def test_page_of_one_test_and_of_other_loads(tmp_path: Path) -> None:
    points, tests, _ = campaign("wear_out", seed=21, strength=1.0, thin=40)
    one = points[points["test_id"] == "t010"]
    model = LinearFriction().fit_frame(points[points["sigma_n"] < 700.0], tests)
    for name, data, base in (
        ("one", one, "linear"),
        ("loads", points[["test_id", "v_rel", "sd", "mu"]], "constant"),
        ("averaged", points.groupby("test_id", as_index=False).mean(numeric_only=True), "linear"),
        ("outside", points[points["sigma_n"] > 1500.0], model),
    ):
        found = diagnose(data, model=base)
        html = page_of(
            "diagnosis", found, name, confirmed_addition(base, DataSet(data, None, {}), found.effects)
        )
        own = re.sub(r"<script.*?</script>", "", html, flags=re.DOTALL)
        assert "nan" not in own and "Worst tests" in own and found.report()
        if name == "one":
            assert "nothing can be seen to be missing" in own and "no intervals" in own
        if name == "outside":
            assert found.verdict == "out_of_domain"
    assert load_map(diagnose(one[["test_id", "sd", "mu"]], model="constant").averages) is None


def test_bins_keep_levels_of_a_plan_together() -> None:
    rng = np.random.default_rng(2)
    levels = np.repeat([5.0, 200.0, 500.0], 300) * rng.uniform(0.97, 1.03, 900)
    which = load_bins(levels, 6)
    for k in range(3):
        assert len(set(which[300 * k : 300 * (k + 1)])) == 1
    met = np.repeat([75.0, 150.0, 225.0, 300.0], 4) + np.tile([-0.02, -0.01, 0.0, 0.01], 4)
    assert load_bins(met, 6).tolist() == np.repeat(range(4), 4).tolist()
    even = load_bins(np.linspace(0.0, 60.0, 600), 6)
    np.testing.assert_array_equal(np.bincount(even), np.full(6, 100))


@pytest.mark.parametrize(
    ("threshold", "drawn", "told"), [(0.0, False, False), (11.9, True, True), (2042.5, False, True)]
)
def test_the_gain_that_chance_may_give_is_a_sentence_and_a_line_near_the_bars(
    threshold: float, drawn: bool, told: bool
) -> None:
    chart = ranking_chart([("stribeck", 30.0, AFTER)], threshold)
    assert bool(chart.figure.layout.shapes) == drawn
    found: Any = {"verdict": "explained", "effects": ["stribeck"], "confusion_set": []}
    found["ranking"] = [{"effect": "stribeck", "gain": 30.0, "evidence": 30.0, "p_value": 0.01}]
    html = ranking_html(found, threshold)
    assert ("the best of all effects gains more than" in html) == told
    assert "needed: " not in html


def test_history_says_when_an_addition_did_not_help() -> None:
    def entry(before: float, after: float) -> Addition:
        return {"added": ["stribeck"], "judged_by": "5 held-out tests", "corrects_data": [],
                "before": {"rmse": before, "mae": before}, "after": {"rmse": after, "mae": after}}  # fmt: skip

    lines = history_text([entry(0.008, 0.005), entry(0.005, 0.00502)]).splitlines()
    assert lines[1].startswith("  1  + stribeck") and "NO BETTER" not in lines[1] and "NO BETTER" in lines[2]


def test_a_certain_rise_is_said_on_the_page() -> None:
    points = made_up.campaign(8, 15)
    after = refine(points, add="stribeck", force=True)
    entry = after.error_history_[-1]  # type: ignore[attr-defined]
    fall = {"rmse": [-0.00042, -0.00009], "mae": [-0.0003, 0.0001]}
    entry |= {"clear": False, "rose": True, "intervals": entry["intervals"] | {"fall": fall}}
    entry["after"] = {name: 1.04 * value for name, value in entry["before"].items()}
    page = refinement_page(LinearFriction().fit_frame(points), after, DataSet(points), "it")
    said = "higher by 0.00009 to 0.00042: more than chance"
    assert f"rose by 4 %: {said}" in page and f"<td>{said}</td>" in page and "may be chance" not in page


def test_several_names_fit_and_are_missing_in_the_plural() -> None:
    found = falling_and_running_in(0.01, THREE)
    assert found.verdict == "ambiguous" and len(found.effects) == 2
    title = "it: effects are missing, Stribeck effect and Running-in fit best"
    assert f"<title>{title}" in diagnosis.diagnosis_page(found, "it")


def test_only_tests_that_are_held_out_are_called_so() -> None:
    points = made_up.campaign(8, 15)
    table = pd.DataFrame({"test_id": points["test_id"].unique()})
    before = LinearFriction().fit_frame(points, table)
    after = refine(points, table, add="stribeck", force=True)
    pages = {
        held: refinement_page(
            before, after, DataSet(points, table.assign(role=roles) if held else table), "it"
        )
        for held, roles in ((0, ""), (3, ["train"] * 5 + ["test"] * 3))
    }
    assert "Charts show all 8 tests (none is held out)." in pages[0] and "held-out" not in pages[0]
    assert "Charts show 3 held-out tests." in pages[3] and "mu on 3 held-out tests;" in pages[3]


def test_every_page_of_the_registry_has_its_function() -> None:
    for name, kind in PAGES.items():
        module, _, function = kind.function.partition(":")
        assert callable(getattr(import_module(f"orchestrator.report.{module}"), function)), name
    with pytest.raises(InputError, match="did you mean 'coverage'"):
        page_of("coverag")


def test_the_page_says_by_which_tests_an_addition_is_judged() -> None:
    """With held-out tests `refine` judges by these and `diagnose` by the others: two numbers with one name."""
    steps = [(k, j) for k in range(6) for j in range(8)]
    data = pd.DataFrame({"test_id": [f"test{k}" for k, _ in steps], "sd": [2.0 * j for _, j in steps]})
    data = data.assign(T=[20.0 + 10 * j for _, j in steps], mu=[0.1 - 0.002 * j + 1e-5 * k for k, j in steps])
    found = diagnose(data, model="constant", catalogue=["thermal_softening", "stribeck"])
    confirmed = confirmed_addition("constant", DataSet(data, None, {}), found.effects)
    alone, beside = (diagnosis.diagnosis_page(found, "it", confirmed, held_out) for held_out in (0, 3))
    said = (
        "Tests not seen in the fit: by 6-fold cross-validation by whole tests (of the 6 tests of this page)."
    )
    assert said in alone and "judges it by the same tests on all points" in alone
    assert said in beside and "judges it by the 3 tests of the data set that have another role" in beside
