"""Many cycles of use without growth, libraries loaded and unloaded, threads with instances of their own."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from .fuzz.building import THREAD, Compiler, build, compiler, run
from .fuzz.packing import packed

#: What a process may grow by between the second and the last tenth of its cycles [bytes]; a leak of one byte a cycle is more.
GROWTH = 4096
CASES = [
    ("memory", "2.0"),
    pytest.param("network", "2.0", marks=pytest.mark.nightly),
    pytest.param("memory", "3.0", marks=pytest.mark.nightly),
    ("ode", "3.0"),
]
Host = Callable[[str, str], tuple[Path, Path]]


def plain() -> Compiler:
    found = compiler(())
    if found is None:
        pytest.skip("no C compiler for a host program: neither gcc, clang nor cc is installed")
    return found


@pytest.fixture(scope="module")
def host(tmp_path_factory: pytest.TempPathFactory) -> Host:
    """A host program and the library of an FMU as it is shipped."""
    known: dict[tuple[str, str], tuple[Path, Path]] = {}

    def get(kind: str, fmi: str) -> tuple[Path, Path]:
        if (kind, fmi) not in known:
            folder = tmp_path_factory.mktemp("host")
            tool = plain()
            fmu = packed(kind, 4, fmi, folder, binaries=True)
            with zipfile.ZipFile(fmu) as archive:
                archive.extractall(folder / "fmu")
            library = next(p for p in (folder / "fmu" / "binaries").glob("*/*") if p.is_file())
            known[kind, fmi] = build(fmu, folder, tool, "host.c", f"-DFMI={fmi[0]}"), library
        return known[kind, fmi]

    return get


@pytest.mark.parametrize(("kind", "fmi"), CASES)
def test_ten_thousand_instances_without_growth(kind: str, fmi: str, host: Host) -> None:
    program, library = host(kind, fmi)
    done = run(program, plain(), "cycles", library, 10_000)
    assert done.returncode == 0, done.stderr
    if not Path("/proc/self/statm").is_file():
        pytest.skip("this system does not say how much memory a process uses; the cycles themselves ran")
    assert int(done.stdout) <= GROWTH


@pytest.mark.parametrize(("kind", "fmi"), CASES)
def test_the_library_is_loaded_and_unloaded(kind: str, fmi: str, host: Host) -> None:
    program, library = host(kind, fmi)
    done = run(program, plain(), "loads", library, 200)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) <= 16 * GROWTH  # the loader itself keeps some tables


@pytest.mark.parametrize(("kind", "fmi"), CASES)
def test_threads_get_the_numbers_that_one_gets_alone(kind: str, fmi: str, host: Host) -> None:
    program, library = host(kind, fmi)
    done = run(program, plain(), "threads", library, 300)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("kind", "fmi"), [("memory", "2.0"), pytest.param("network", "3.0", marks=pytest.mark.nightly)]
)
def test_threads_share_nothing_that_is_written(kind: str, fmi: str, tmp_path: Path) -> None:
    tool = compiler(THREAD)
    if tool is None:
        pytest.skip("no compiler with ThreadSanitizer is installed")
    program = build(packed(kind, 4, fmi, tmp_path), tmp_path, tool, "host.c", "-DLINKED", f"-DFMI={fmi[0]}")
    done = run(program, tool, "threads", "-", 40)
    assert done.returncode == 0, done.stderr[-4000:]
