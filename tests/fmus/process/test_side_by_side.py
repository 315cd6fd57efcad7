"""Several forming FMUs at once, and back over a remeshing: the same bits as one alone and straight on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fmus import pack_forming
from fmus.runtime.running import RunningFmu, UnpackedFmu
from forming import ForwardRodExtrusion
from friction_models.loads import LOAD_NAMES

OPTIONS: dict[str, Any] = {"n_points": 12, "mesh_size": 0.8}


def step(fmu: RunningFmu, unpacked: UnpackedFmu, k: int) -> list[float]:
    fmu.set_real([v.name for v in unpacked.resolve("mu")], np.linspace(0.04, 0.06 + 0.005 * k, 12))
    fmu.step(0.02 * k, 0.02)
    loads = [name for load in LOAD_NAMES for name in [v.name for v in unpacked.resolve(load)]]
    found: list[float] = fmu.get_real([*loads, "force", "work"]).tolist()
    return found


#: By day `test_solver_process` compares the two, step by step.
TARGETS = ["python", pytest.param("process", marks=pytest.mark.nightly)]


@pytest.mark.parametrize("target", TARGETS)
def test_two_processes_in_turn_are_each_as_alone(target: str, tmp_path: Path) -> None:
    fmus, alone = {}, []
    for name in ("fre", "bce"):
        for kind in {"python", target}:
            path = pack_forming(tmp_path / f"{name}-{kind}.fmu", process=name, target=kind, **OPTIONS)
            fmus[name, kind] = UnpackedFmu.of(path)
        unpacked = fmus[name, "python"]
        with RunningFmu(unpacked) as fmu:
            alone.append([step(fmu, unpacked, k) for k in range(8)])
    rod_fmu, cup_fmu = fmus["fre", target], fmus["bce", target]
    with RunningFmu(rod_fmu) as rod, RunningFmu(cup_fmu) as cup, RunningFmu(rod_fmu) as late:
        for k in range(8):
            assert step(cup, cup_fmu, k) == alone[1][k]
            assert step(rod, rod_fmu, k) == alone[0][k]
            if k >= 4:  # another instance of the same FMU, some steps behind
                assert step(late, rod_fmu, k - 4) == alone[0][k - 4]
    assert alone[0] != alone[1]


@pytest.mark.parametrize("target", TARGETS)
def test_back_over_a_remeshing_and_on_with_the_same_bits(target: str, tmp_path: Path) -> None:
    process = ForwardRodExtrusion(**OPTIONS)
    process.start(0.05)
    process.advance(0.6)
    before = process.simulation.state.remeshes
    process.advance(1.2)
    assert process.simulation.state.remeshes > before + 1
    unpacked = UnpackedFmu.of(pack_forming(tmp_path / "fre.fmu", target=target, **OPTIONS))
    with RunningFmu(unpacked) as fmu:
        for k in range(6):
            step(fmu, unpacked, k)
        kept = fmu.save_state()
        ahead = [step(fmu, unpacked, k) for k in range(6, 18)]
        fmu.restore_state(kept)
        assert [step(fmu, unpacked, k) for k in range(6, 18)] == ahead
