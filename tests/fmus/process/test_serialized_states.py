"""Solver states as bytes: exact in another instance, refused when they are damaged or somebody else's."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fmus import pack_forming, pack_twin
from fmus.runtime.running import FmuError, RunningFmu, UnpackedFmu
from fmus.slaves.state_bytes import from_bytes, to_bytes
from friction_models.common import InputError

FORMING = (pack_forming, {"n_points": 12, "mesh_size": 0.8}, {"half_angle": 30.0})
TWIN = (pack_twin, {}, {"bore": 0.0, "T_tool": 50.0})


@pytest.mark.parametrize(
    ("packer", "options", "other", "target"),
    [
        pytest.param(*FORMING, "process", marks=pytest.mark.nightly),
        (*FORMING, "python"),
        (*TWIN, "process"),
        pytest.param(*TWIN, "python", marks=pytest.mark.nightly),
    ],
)
def test_another_instance_goes_on_bit_by_bit(
    packer: Callable[..., Path], options: dict[str, Any], other: dict[str, float], target: str, tmp_path: Path
) -> None:
    unpacked = UnpackedFmu.of(packer(tmp_path / "a.fmu", target=target, **options))
    names = [n for n, v in unpacked.variables.items() if v.type == "Real"]
    with RunningFmu(unpacked) as fmu:
        for k in range(12):
            fmu.step(0.02 * k, 0.02)
        content = fmu.serialize(fmu.save_state())
        fmu.step(0.24, 0.02)
        expected = fmu.get_real(names)
        fmu.restore_state(fmu.deserialize(content))
        fmu.step(0.24, 0.02)
        assert np.array_equal(fmu.get_real(names), expected)
    with RunningFmu(unpacked, start=other) as fmu:
        for broken, words in (
            (content[:-1], "damaged"),
            (content[:200] + bytes([content[200] ^ 1]) + content[201:], "damaged"),
            (b"", "not one of a solver FMU"),
        ):
            with pytest.raises(FmuError, match=words):
                fmu.restore_state(fmu.deserialize(broken))
        assert fmu.get_real(list(other)).tolist() == list(other.values())
        fmu.restore_state(fmu.deserialize(content))
        fmu.step(0.24, 0.02)
        assert np.array_equal(fmu.get_real(names), expected)


@dataclass
class Part:
    grid: Any
    name: str = "plate"


@dataclass
class Stranger:
    grid: Any


def test_numbers_arrays_and_shared_parts_come_back_as_they_were() -> None:
    grid = np.array([[0.1, -0.0, np.inf], [np.nan, 1e-310, 5.0]])
    thing = [
        Part(grid),
        Part(grid),
        (1, 2.5, None, True, float("inf")),
        np.array([], dtype=bool),
        np.float64(0.1),
    ]
    found = from_bytes(to_bytes(thing, "me", [Part]), "me", [Part])
    assert found[0].grid.tobytes() == grid.tobytes()
    assert found[0].grid is found[1].grid
    assert found[0] is not found[1]
    assert found[2] == thing[2]
    assert [type(t) for t in found[2]] == [int, float, type(None), bool, float]
    assert (found[3].dtype, found[3].shape) == (np.dtype(bool), (0,))
    assert type(found[4]) is np.float64


def test_fmus_of_other_content_refuse_each_other() -> None:
    from fmus.slaves.twin_solver import TwinSolver

    config = {
        "names": [],
        "first_input": 0,
        "first_parameter": 0,
        "further": 0,
        "start": [],
        "flags": 0,
        "T_specimen": None,
    }
    assert TwinSolver(config).identity() == TwinSolver(dict(config)).identity()
    assert TwinSolver(config).identity() != TwinSolver(config | {"T_specimen": 40.0}).identity()


def test_only_expected_classes_are_written_and_made() -> None:
    with pytest.raises(TypeError, match="Stranger in a solver state"):
        to_bytes(Stranger(1.0), "me", [Part])
    with pytest.raises(TypeError, match="array of object"):
        to_bytes(np.array([{}]), "me", [])
    content = to_bytes(Stranger(1.0), "me", [Stranger])
    assert from_bytes(content, "me", [Stranger]) == Stranger(1.0)
    for identity, classes, words in (
        ("you", [Stranger], "belongs to another FMU"),
        ("me", [Part], "cannot be read"),
    ):
        with pytest.raises(InputError, match=words):
            from_bytes(content, identity, classes)
