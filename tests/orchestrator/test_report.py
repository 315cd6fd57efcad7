"""Reports: complete, self-contained, escaped; statistics that count whole tests."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from friction_models.loads import InputError
from orchestrator import Master, System
from orchestrator.report import write_report
from orchestrator.report.markup import Change, escape, p_value, table
from orchestrator.report.residuals import binned_residual
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


def test_a_folder_that_is_neither_run_nor_demo(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="neither a run folder"):
        write_report(tmp_path)
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
    assert (p_value(0.0001), p_value(0.0123), p_value(None)) == ("< 0.001", "0.012", "-")
