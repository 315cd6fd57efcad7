from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fmpy.fmi2 import fmi2CallbackFunctions

from fmus import pack
from fmus.checks import checking, trial
from friction_models import ConstantFriction
from tests.fmus.graphs import BOX, graph_bytes, node, save


@pytest.fixture(scope="session")
def linear_onnx(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """mu = 0.15 - 1e-4 T + 1e-5 sigma_n, without a clip at 0, trained on BOX."""
    import numpy as np

    content = graph_bytes(
        [node("Gemm", "loads w b", "mu")],
        {"w": np.array([[0.0], [-1e-4], [1e-5], [0.0], [0.0]]), "b": np.array([0.15])},
        metadata={
            "domain": BOX,
            "model": {"family": "linear", "name": "by hand", "formula": "line"},
            "card": {"errors": {"MAE": 0.01}},
        },
    )
    return save(content, tmp_path_factory.mktemp("linear") / "model.onnx")


@pytest.fixture(scope="session")
def memory_onnx(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """mu = 0.05 + 0.01 work + 0.1 Ra; work += v_rel dt / 100, start 1: state and system variable."""
    import numpy as np

    nodes = [
        node("Gather", "loads i0", "v", axis=1),
        node("Mul", "v dt", "travel"),
        node("Mul", "travel c", "gain"),
        node("Add", "state gain", "state_next"),
        node("Mul", "state a", "m1"),
        node("Mul", "system r", "m2"),
        node("Add", "m1 m2", "m3"),
        node("Add", "m3 b", "mu"),
    ]
    constants = {
        "i0": np.array([0]),
        "c": np.array(0.01),
        "a": np.array(0.01),
        "r": np.array(0.1),
        "b": np.array(0.05),
    }
    content = graph_bytes(
        nodes,
        constants,
        {"state": ["n", 1], "dt": [1], "system": [1, 1]},
        {"state_next": ["n", 1]},
        {
            "domain": BOX,
            "model": {"family": "composed", "name": "memory", "formula": "work"},
            "state": [{"name": "work", "unit": "mm", "start": 1.0, "ode": False}],
            "system": [{"name": "Ra", "unit": "um", "start": 0.2, "min": 0.0, "max": 2.0}],
        },
    )
    return save(content, tmp_path_factory.mktemp("memory") / "model.onnx")


@pytest.fixture(scope="session")
def packed(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """Pack each wanted FMU once a session."""
    folder = tmp_path_factory.mktemp("fmus")
    made: dict[str, Path] = {}

    def get(model: object, target: str = "native", nodes: int = 1) -> Path:
        key = f"{model}-{target}-{nodes}"
        if key not in made:
            source = ConstantFriction(model) if isinstance(model, float) else model
            made[key] = pack(source, folder / f"{len(made)}.fmu", target=target, nodes=nodes)
        return made[key]

    return get


#: fmpy goes on calling the last logger that a simulation was given, also for later FMUs: it must not be freed.
_CALLBACKS: list[Any] = []


@pytest.fixture
def trials_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the trials of `check` run in this process, for FMUs that may be wrong but neither crash nor hang.

    The second process costs ten times what the trials do; `test_check_limits.py` has the tests of it.
    """

    def outliving() -> Any:
        _CALLBACKS.append(fmi2CallbackFunctions())
        return _CALLBACKS[-1]

    def here(file: Path, result: Path, folder: str, limit: float, memory: int) -> tuple[int, str]:
        with monkeypatch.context() as patch:
            patch.setattr("fmpy.simulation.fmi2CallbackFunctions", outliving)
            trial.record(file, result)
        return 0, ""

    monkeypatch.setattr(checking, "_second_process", here)
