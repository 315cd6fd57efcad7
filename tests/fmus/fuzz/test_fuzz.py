"""The C interface under random calls with sanitizers: no crash, no bad number, errors that name the variable."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from .building import Compiler, build, compiler, run
from .packing import packed

CALLS = 40_000
#: Model, contact points at packing, FMI version: every model and every version by day; the rest by night.
CASES = [
    pytest.param("network", 1, "2.0", marks=pytest.mark.nightly),
    pytest.param("network", 20, "2.0", marks=pytest.mark.nightly),
    pytest.param("memory", 4, "2.0", marks=pytest.mark.nightly),
    ("wild", 4, "2.0"),
    pytest.param("ode", 1, "2.0", marks=pytest.mark.nightly),
    pytest.param("boosting", 4, "2.0", marks=pytest.mark.nightly),
    ("network", 4, "3.0"),
    pytest.param("memory", 2, "3.0", marks=pytest.mark.nightly),
    pytest.param("wild", 2, "3.0", marks=pytest.mark.nightly),
    pytest.param("ode", 1, "3.0", marks=pytest.mark.nightly),
    ("ode", 4, "3.0"),
]
Program = Callable[[str, int, str], Path]


@pytest.fixture(scope="module")
def tool() -> Compiler:
    found = compiler()
    if found is None:
        pytest.skip("neither gcc or clang with sanitizers nor Zig's clang is installed")
    return found


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory, tool: Compiler) -> Program:
    known: dict[tuple[str, int, str], Path] = {}

    def get(kind: str, nodes: int, fmi: str) -> Path:
        if (kind, nodes, fmi) not in known:
            folder = tmp_path_factory.mktemp("fuzz")
            known[kind, nodes, fmi] = build(packed(kind, nodes, fmi, folder), folder, tool)
        return known[kind, nodes, fmi]

    return get


@pytest.mark.parametrize(("kind", "nodes", "fmi"), CASES)
def test_random_calls(kind: str, nodes: int, fmi: str, program: Program, tool: Compiler) -> None:
    for seed in (1, 2):
        done = run(program(kind, nodes, fmi), tool, seed, CALLS)
        assert done.returncode == 0, f"seed {seed}, {tool.what}:\n{done.stderr[-6000:]}"
    counts = {name: (int(good), int(bad)) for name, good, bad in map(str.split, done.stdout.splitlines())}
    # The run was worth something: the functions that matter both did their work and refused some of it.
    letter, deserialize = ("2", "DeSerialize") if fmi == "2.0" else ("3", "Deserialize")
    state = "FMUstate" if fmi == "2.0" else "FMUState"
    kind_of = "Real" if fmi == "2.0" else "Float64"
    for name in (
        f"Get{kind_of}",
        f"Set{kind_of}",
        "SetBoolean",
        "DoStep",
        "GetDirectionalDerivative",
        f"Set{state}",
        f"{deserialize}{state}",
        "ExitInitializationMode",
        *([] if fmi == "2.0" else ["GetAdjointDerivative", "EnterConfigurationMode"]),
        *([] if fmi == "2.0" or nodes == 1 else ["SetUInt64"]),
        *([] if kind == "memory" else ["EnterContinuousTimeMode", "SetTime"]),
        *(["SetContinuousStates"] if kind == "ode" else []),
    ):
        assert min(counts[f"fmi{letter}{name}"]) > 30, f"{name}: {counts[f'fmi{letter}{name}']}"


@pytest.mark.parametrize("fmi", [pytest.param("2.0", marks=pytest.mark.nightly), "3.0"])
@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("negative", r"domain_distance(\[\d\])? is negative"),
        ("stale", "copy through bytes|after a reset"),
        ("message", "names no variable"),
    ],
    ids=["negative", "stale", "message"],
)
def test_the_harness_sees_faults(fault: str, words: str, fmi: str, program: Program, tool: Compiler) -> None:
    """A bad value, a value that is out of date and a message without a name, each put in by the harness itself."""
    done = run(program("network", 4, fmi), tool, 1, CALLS, fault)
    assert done.returncode == 3
    assert re.search(f"BROKEN at seed 1, call \\d+: .*({words})", done.stderr), done.stderr[-1000:]
