"""Files of the user's that are called like modules: no command runs them, nor do the processes that it starts."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from friction_models import LinearFriction
from friction_models.loads import DataSet
from sct_twin.ingest.raw_campaign import write_tables
from sct_twin.records.record import write_csv
from tests.fmus.foreign import model_bytes, node
from tests.orchestrator.cli.test_command_line import points
from tests.orchestrator.processes import COMMAND, environment, has_workers, interrupted, needs_proc
from tests.orchestrator.tiny_fmus import write_system
from tests.sct_twin.conftest import made_up

NAMES = (
    *("json", "pickle", "numpy", "random", "typing", "struct", "signal", "select", "tempfile", "subprocess"),
    *("threading", "queue", "encodings", "codecs", "multiprocessing", "concurrent", "importlib", "logging"),
    *("pandas", "scipy", "onnxruntime", "fmpy", "forming", "fmus", "sct_twin", "friction_models", "yaml"),
    *(
        "sitecustomize",
        "usercustomize",
        "site",
        "runpy",
        "csv",
        "sct",
        "fmu",
        "distutils",
        "h5py",
        "openpyxl",
    ),
)
TRACE = "import os\nopen(os.environ['TRACES'] + '/' + __name__, 'w').close()\n"


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory, tiny: dict[str, Path]) -> Path:
    folder = tmp_path_factory.mktemp("user")
    for name in NAMES:
        (folder / f"{name}.py").write_text(TRACE)
    frame = points(3, 12)
    roles = pd.DataFrame({"test_id": ["t0", "t1", "t2"], "role": ["train", "train", "test"]})
    DataSet(frame, roles, {"synthetic": True}).save(folder / "data")
    LinearFriction().fit_frame(frame).save(folder / "linear")
    write_system(folder, tiny)
    # No operator Sin is translated to C: such a graph is tried in a process of its own.
    sine = [node("MatMul", "x w", "a"), node("Sin", "a", "b"), node("Abs", "b", "y")]
    (folder / "sine.onnx").write_bytes(
        model_bytes(sine, {"w": np.full((5, 1), 1e-3)}, {"x": ["n", 5]}, {"y": ["n", 1]})
    )
    (folder / "raw").mkdir()
    pd.DataFrame({"t": [0.0, 1.0], "F_n": [1.0, 2.0]}).to_parquet(folder / "raw" / "x.parquet")
    (folder / "plan.csv").write_text("sigma_set,v_set,T_tool\n500,100,20\n1000,100,20\n")
    write_campaign(folder / "twice")
    return folder


def write_campaign(folder: Path) -> None:
    """Write a campaign of two tests with made-up records."""
    (folder / "raw").mkdir(parents=True)
    for name in ("x", "y"):
        write_csv(folder / "raw" / f"{name}.csv", made_up().to_frame())
    tests = pd.DataFrame(
        {"test_id": ["x", "y"], "role": "train", "T_tool": 20.0, "v_set": 50.0, "bore": 20.0}
    )
    write_tables(folder, tests, {"synthetic": True, "moving_mass_kg": 25.0})


def traces_of(place: Path) -> Path:
    """Return an empty folder for the traces."""
    folder = place / "traces"
    folder.mkdir(exist_ok=True)
    for old in folder.iterdir():
        old.unlink()
    return folder


def said(place: Path, *words: str) -> tuple[str, set[str]]:
    """Run a command in the folder of the planted files; return what it says and which of them ran."""
    traces = traces_of(place)
    done = subprocess.run(
        words,
        cwd=place,
        env=environment(place, TRACES=str(traces)),
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    return f"{done.returncode} {done.stdout} {done.stderr}", {p.name for p in traces.iterdir()}


@pytest.mark.parametrize(
    ("command", "code"),
    [
        pytest.param("--help", 0, marks=pytest.mark.nightly),
        ("ingest raw -o ingested", 2),  # no test, but read by the reading process
        pytest.param("train linear --data data -o model", 0, marks=pytest.mark.nightly),
        ("pack sine.onnx --target python -o sine.fmu", 0),
        ("check law.fmu", 1),
        ("simulate system.yaml -o run", 0),
        pytest.param("predict linear --data data -o predicted.csv", 0, marks=pytest.mark.nightly),
    ],
)
def test_no_command_runs_what_lies_in_the_current_folder(place: Path, command: str, code: int) -> None:
    text, ran = said(place, COMMAND, *command.split())
    assert text.startswith(f"{code} "), text
    assert not ran


#: Commands with several processes, which take long: broken off when the processes have started.
LONG = {
    "lab": "lab --plan plan.csv -j 2 -o campaign",
    "twin": "twin twice -j 2 -o twins",
}


@needs_proc
@pytest.mark.parametrize(
    "command",
    # Both start the same pool of processes.
    [pytest.param(c, id=k, marks=pytest.mark.nightly if k == "lab" else ()) for k, c in LONG.items()],
)
def test_no_process_runs_what_lies_in_the_current_folder(place: Path, command: str) -> None:
    traces = traces_of(place)
    code, output, errors = interrupted([COMMAND, *command.split()], place, has_workers, TRACES=str(traces))
    assert not [p.name for p in traces.iterdir()]
    assert code == 130, f"{output} {errors}"
    assert errors.splitlines()[-1].startswith("tribofmu: interrupted; ")
    assert "Traceback" not in errors


@pytest.mark.parametrize(
    "words", [["script.py"], ["-P", "-c", "import sys; sys.path.append('.'); import script"]]
)
def test_a_script_and_its_modules_run_in_processes(tmp_path: Path, words: list[str]) -> None:
    (tmp_path / "own.py").write_text("def twice(x):\n    return 2 * x\n")
    (tmp_path / "script.py").write_text(
        "import pickle, multiprocessing, concurrent.futures\n"
        "import own\n"
        "from friction_models.common.processes.pool import map_unordered\n"
        "print(sorted(r for _, r in map_unordered(own.twice, [(1,), (2,)], 2)))\n"
    )
    if words[0] == "-P":  # the script is not started in its folder, which is in the path behind Python's own
        (tmp_path / "pickle.py").write_text(TRACE)
    text, ran = said(tmp_path, sys.executable, *words)
    assert text.startswith("0 [2, 4]"), text
    assert not ran
