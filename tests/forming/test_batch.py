"""A batch of forming runs: the bits of single runs, and failures with their reasons."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from forming import PROCESSES, FormingTask, run_batch
from forming.results.files import load_result
from friction_models.common import InputError

COARSE = {"mesh_size": 0.8, "n_points": 20}
TASKS = [
    FormingTask("fre", COARSE, 0.05, 0.4, name="rod"),
    FormingTask("bce", COARSE | {"nose_angle": 8.0}, 0.1, 0.4, {"eject": "stripper"}),
    FormingTask("ring", {"n_points": 20}, 0.1, 0.1),
    FormingTask("fre", {"half_angle": 500.0}, 0.05, 1.0),
]


def test_pool_gives_the_bits_of_single_runs_and_keeps_failures(tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    runs = run_batch(
        TASKS, jobs=2, progress=lambda done, total, name: told.append((done, total)), out=tmp_path
    )
    assert told == [(k, 4) for k in (1, 2, 3, 4)]
    assert [run.ok for run in runs] == [True, True, True, False]
    assert runs[3].task is TASKS[3] and runs[3].result is None
    assert "half_angle = 500.0 degrees; allowed: 10 to 80" in runs[3].error
    for task, run in zip(TASKS[:3], runs):
        kind: Any = PROCESSES[task.process]
        alone = kind(**task.parameters).run(task.friction, task.stroke, **task.options)
        assert run.result is not None
        assert np.array_equal(run.result.force, alone.force)
        assert np.array_equal(run.result.contact.loads, alone.contact.loads)
        if alone.ejection is not None:
            assert run.result.ejection is not None
            assert np.array_equal(run.result.ejection.force, alone.ejection.force)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["0002", "0003", "rod"]
    again, name = load_result(tmp_path / "rod")
    assert name == "rod"
    # What it was made with is kept beside the numbers.
    assert again.inputs == runs[0].result.inputs
    made = {
        "process": "forward rod extrusion",
        "material": "16MnCr5",
        "mu": 0.05,
        "mesh_size": 0.8,
        "n_points": 20,
    }
    assert made.items() <= again.inputs.items()


def failing(loads: np.ndarray, t: float) -> np.ndarray:
    if t > 0.03:
        raise ArithmeticError("no friction here")
    return np.full(len(loads), 0.05)


def test_in_this_process_a_failing_law_leaves_what_there_was() -> None:
    tasks = [
        FormingTask("fre", COARSE, failing, 1.0),
        FormingTask("fer"),
        FormingTask("fre", {"halfangle": 3}),
    ]
    runs = run_batch(tasks, jobs=1)
    assert [run.ok for run in runs] == [False] * 3
    assert runs[0].result is not None and runs[0].result.stroke[-1] == pytest.approx(0.2)
    assert runs[0].error == "ArithmeticError: no friction here"
    assert "did you mean 'fre'" in runs[1].error and "halfangle" in runs[2].error
    assert run_batch([]) == []


def test_what_cannot_be_a_batch_is_refused() -> None:
    with pytest.raises(InputError, match=r"name = 'a'; allowed: one folder name"):
        run_batch([FormingTask(name="a"), FormingTask(name="a")])
    with pytest.raises(InputError, match=r"name = '\.\./x'"):
        run_batch([FormingTask(name="../x")])
    with pytest.raises(InputError, match=r"task 0001 cannot be sent to another process .*jobs = 1"):
        run_batch([FormingTask(friction=lambda loads, t: 0.1), FormingTask()], jobs=2)
    with pytest.raises(InputError, match="jobs = 0; allowed"):
        run_batch(TASKS, jobs=0)
