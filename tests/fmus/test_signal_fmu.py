"""The source of signals: means over the steps, whatever the step."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fmus import check
from fmus.runtime.running import RunningFmu, UnpackedFmu
from fmus.targets.signals import pack_signals
from friction_models.common import InputError

EDGES = [0.0, 0.1, 0.5, 0.6]
SPEED = [10.0, 100.0, 0.0]


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    signals = {
        "v_slide": ("mm/s", "speed", SPEED),
        "F_n": ("N", "force", [1e5, 2e5, 3e5]),
    }
    return pack_signals(tmp_path_factory.mktemp("signals") / "inputs.fmu", EDGES, signals)


@pytest.mark.parametrize("step", [0.02, 0.07, 0.3])
def test_distance_is_kept_whatever_the_step(source: Path, step: float) -> None:
    count = round(0.6 / step + 0.49)
    with RunningFmu(UnpackedFmu.of(source)) as fmu:
        assert fmu.get_real(["v_slide"])[0] == SPEED[0]
        speeds = []
        for k in range(count):
            fmu.step(k * step, step)
            speeds.append(fmu.get_real(["v_slide"])[0])
    assert step * sum(speeds) == pytest.approx(np.dot(SPEED, np.diff(EDGES)), rel=1e-12)


def test_a_step_inside_an_interval_gives_its_value_and_the_last_one_holds(source: Path) -> None:
    with RunningFmu(UnpackedFmu.of(source)) as fmu:
        fmu.step(0.0, 0.05)
        assert fmu.get_real(["v_slide", "F_n"]).tolist() == pytest.approx([10.0, 1e5])
        fmu.step(0.05, 0.1)
        assert fmu.get_real(["v_slide", "F_n"]).tolist() == pytest.approx([55.0, 1.5e5])
        fmu.step(0.15, 0.45)
        fmu.step(0.6, 1.0)
        assert fmu.get_real(["v_slide", "F_n"]).tolist() == pytest.approx([0.0, 3e5])


def test_state_is_saved_and_the_fmu_passes_the_check(source: Path) -> None:
    with RunningFmu(UnpackedFmu.of(source)) as fmu:
        fmu.step(0.0, 0.2)
        state, before = fmu.save_state(), fmu.get_real(["v_slide"])[0]
        fmu.step(0.2, 0.4)
        fmu.restore_state(state)
        assert fmu.get_real(["v_slide"])[0] == before
    report = check(source)
    assert report.ok, str(report)


@pytest.mark.parametrize(
    ("edges", "values", "words"),
    [
        ([0.0, 1.0], [], r"'v' has shape \(0,\), allowed: \(1,\)"),
        ([0.0, 1.0, 1.0], [1.0, 2.0], "increase"),
        ([0.5, 1.0], [1.0], "begin at 0 s"),
        ([0.0], [], "1 times, allowed: 2 to"),
        ([0.0, 1.0], [float("nan")], "one finite number an interval"),
    ],
)
def test_tables_that_cannot_be(edges: list[float], values: list[float], words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=words):
        pack_signals(tmp_path / "x.fmu", edges, {"v": ("mm/s", "speed", values)})
    assert list(tmp_path.iterdir()) == []
