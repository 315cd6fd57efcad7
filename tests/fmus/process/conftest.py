"""Solver FMUs with the native front, what stands in for their solver process, and a look at processes."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from fmus import pack_forming, pack_twin
from fmus.runtime.running import RunningFmu, UnpackedFmu

from .processes import script

#: Markers of the forming FMU.
N = 12
STAND_IN = Path(__file__).parent / "stand_in.py"


@pytest.fixture(autouse=True)
def own_python(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TRIBOFMU_PYTHON", sys.executable)
    monkeypatch.setenv("TRIBOFMU_TIMEOUT", "120")  # what would hang for ever ends as an error


@pytest.fixture(scope="package")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("process")


@pytest.fixture(scope="package")
def twin(folder: Path) -> UnpackedFmu:
    return UnpackedFmu.of(pack_twin(folder / "twin.fmu", target="process"))


@pytest.fixture(scope="package")
def forming(folder: Path) -> UnpackedFmu:
    return UnpackedFmu.of(pack_forming(folder / "fre.fmu", target="process", n_points=N, mesh_size=0.8))


@pytest.fixture(scope="package")
def running_twin(twin: UnpackedFmu) -> Iterator[RunningFmu]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TRIBOFMU_PYTHON", sys.executable)
        fmu = RunningFmu(twin)
    with fmu:
        yield fmu


@pytest.fixture
def stand_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    def use(mode: str) -> None:
        command = f'exec "{sys.executable}" -I -S "{STAND_IN}" "$@"'
        file = script(tmp_path, f'[ -z "$PYTHONHOME" ] || exit 77\n{command}')
        monkeypatch.setenv("TRIBOFMU_PYTHON", str(file))
        monkeypatch.setenv("STAND_IN", mode)

    return use
