"""Force-stroke comparison: numbers that can be written down, and propagation against Monte Carlo."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_models.common import InputError
from orchestrator.cosim.run_folders import Run
from orchestrator.force_curves.forces import (
    ForceCurve,
    LevelsComparison,
    compare_force,
    levels_table,
    read_press_curve,
)
from orchestrator.force_curves.metrics import LevelSummary, Measured, ScalarError


def ramp(top: float, length: float = 10.0, n: int = 101) -> ForceCurve:
    """Linear rise over 2 mm, then flat at `top`."""
    stroke = np.linspace(0.0, length, n)
    return ForceCurve(stroke, top * np.minimum(stroke / 2.0, 1.0))


def test_flat_curves_give_exact_errors() -> None:
    press = (ramp(100.0), ramp(104.0), ramp(96.0))
    result = compare_force(ramp(110.0), press)
    assert result.max_force.simulated == pytest.approx(110.0)
    assert result.max_force.ae == pytest.approx(10.0)
    assert result.max_force.are == pytest.approx(0.10)
    assert result.max_force.signed == pytest.approx(0.10)
    assert result.max_force.measured.std == pytest.approx(4.0)
    assert result.max_force.are_std == pytest.approx(110.0 * 4.0 / 100.0**2)
    assert result.work.simulated == pytest.approx(110.0 * 9.0)  # (1 + 8) mm times the plateau
    assert result.work.are == pytest.approx(0.10, rel=1e-6)
    text = result.table()
    assert "10.0 +- 4.4 %" in text and "3 repeats" in text


def test_only_the_common_stroke_counts() -> None:
    rising = ForceCurve(np.linspace(0.0, 20.0, 201), np.linspace(0.0, 200.0, 201))
    press = (ForceCurve(np.linspace(1.0, 11.0, 50), np.linspace(10.0, 110.0, 50)),)
    result = compare_force(rising, press)
    assert (result.stroke[0], result.stroke[-1]) == (1.0, 11.0)
    assert result.max_force.are == pytest.approx(0.0, abs=1e-12)
    assert result.work.simulated == pytest.approx(600.0)
    with pytest.raises(InputError, match="no common stroke"):
        compare_force(rising, (ForceCurve(np.array([30.0, 31.0]), np.array([1.0, 1.0])),))


def test_the_moving_mean_removes_ripple_but_not_a_plateau() -> None:
    stroke = np.linspace(0.0, 20.0, 2001)
    smooth = 300.0 * np.minimum(stroke / 3.0, 1.0)
    rippled = smooth + 3.0 * np.sin(2 * np.pi * stroke / 0.5)
    result = compare_force(ForceCurve(stroke, rippled), (ForceCurve(stroke, smooth),))
    assert result.max_force.ae < 0.2


@given(
    top=st.floats(50.0, 500.0),
    scatter=st.lists(st.floats(-0.05, 0.05), min_size=2, max_size=6),
    scale=st.floats(0.5, 2.0),
)
def test_relative_errors_do_not_depend_on_the_unit_of_force(
    top: float, scatter: list[float], scale: float
) -> None:
    press = [ramp(top * (1 + s), n=21) for s in scatter]
    a = compare_force(ramp(1.1 * top, n=21), press)
    scaled = tuple(ForceCurve(c.stroke, scale * c.force) for c in press)
    b = compare_force(ramp(1.1 * top * scale, n=21), scaled)
    for x, y in ((a.max_force, b.max_force), (a.work, b.work)):
        assert x.are == pytest.approx(y.are, rel=1e-9, abs=1e-12)
        assert x.are_std == pytest.approx(y.are_std, rel=1e-9, abs=1e-12)


def test_propagation_agrees_with_monte_carlo() -> None:
    rng = np.random.default_rng(4)
    simulated = np.array([110.0, 215.0, 330.0, 290.0])
    mean = np.array([100.0, 200.0, 300.0, 310.0])
    std = 0.01 * mean
    summary = LevelSummary.of([ScalarError(s, Measured(m, d, 5)) for s, m, d in zip(simulated, mean, std)])
    are = np.abs(simulated / (mean + std * rng.standard_normal((200_000, 4))) - 1.0)
    assert summary.mare == pytest.approx(are.mean(axis=1).mean(), rel=0.01)
    assert summary.mare_std == pytest.approx(are.mean(axis=1).std(), rel=0.02)
    assert summary.spread_std == pytest.approx(are.std(axis=1, ddof=1).std(), rel=0.1)


def test_levels_are_summarised() -> None:
    press = (ramp(100.0), ramp(102.0))
    levels = LevelsComparison("constant", tuple(compare_force(ramp(t), press) for t in (110.0, 120.0)))
    assert levels.max_force.mare == pytest.approx((9.0 + 19.0) / 2 / 101.0)
    assert "constant" in levels_table([levels])
    assert levels.to_dict()["max_force"]["levels"] == 2


def test_press_files(tmp_path: Path) -> None:
    path = tmp_path / "level.csv"
    rows = [(r, s) for r in (1, 2) for s in (0.0, 1.0, 2.0)]
    path.write_text("stroke [mm],force [kN],repeat\n" + "".join(f"{s},{50 * s + r},{r}\n" for r, s in rows))
    press = read_press_curve(path)
    assert len(press) == 2
    np.testing.assert_allclose(press[1].force, [2.0, 52.0, 102.0])


@pytest.mark.parametrize(
    ("text", "pattern"),
    [
        ("stroke [mm],forse [kN]\n0,1\n", "'force' is missing.*is it 'forse'"),
        ("stroke [mm],force [lbf]\n0,1\n1,2\n", "unit of column 'force' 'lbf'; allowed: MN, N, kN"),
        ("stroke [mm],force [kN]\n0,1\n1,x\n", "'force', row 1: value 'x'"),
        ("stroke [mm],force [kN]\n0,1\n1,nan\n", "'force', row 1"),
        ("stroke [mm],force [kN]\n1,1\n0,2\n", "must not run backwards"),
        ("", "empty"),
    ],
)
def test_bad_press_files(tmp_path: Path, text: str, pattern: str) -> None:
    path = tmp_path / "level.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=pattern):
        read_press_curve(path)


def test_a_gap_in_the_force_of_a_run_names_run_and_row() -> None:
    stroke, force = np.arange(4.0), np.array([0.0, 50.0, np.nan, 60.0])
    run = Run(Path("runs/one"), {}, stroke, {"f.stroke": stroke, "f.force": force}, {})
    with pytest.raises(InputError, match=r"^runs/one: force curve: row 2: 2 mm, nan kN; allowed: finite"):
        run.force_curve()
