"""What the tests of the exports share: models with their FMUs, compilers, a C export as a library."""

from __future__ import annotations

import ctypes
import functools
import re
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pytest

from fmus import pack
from fmus.native import compile as compiling
from fmus.runtime.running import RunningFmu, UnpackedFmu
from fmus.source.reading import read_source
from friction_models.families.registry import make_model
from friction_models.loads import LOAD_NAMES
from tests.fmus.graphs import Array, campaign

NAMES = [
    "constant",
    "polynomial",
    "ffnn",
    "gradient_boosting",
    "linear + work_exhaustion",
    "linear + tool_roughness",
]
QUICK = {"ffnn": {"hidden": (8, 8), "members": 1, "epochs": 4}}
STRICT = ["-std=c99", "-O1", "-ffp-contract=off", "-Wall", "-Wextra", "-Wshadow", "-pedantic", "-Werror"]
#: Every argument list is the host's; a subroutine need not use all of it.
FORTRAN = ["-O1", "-Wall", "-Werror", "-Wno-unused-dummy-argument"]
PROGRAM_LINE = re.compile(r"ok: .*largest deviation.* ([0-9.]+E?e?[-+]?\d*)")


class Made:
    """A saved model and its FMU."""

    def __init__(self, name: str, folder: Path) -> None:
        base, _, effect = name.partition(" + ")
        model = make_model(base, **QUICK.get(base, {}))
        model = model + effect if effect else model
        points, tests = campaign()
        model.fit_frame(points, tests)
        model.save(folder / "model")
        self.source = read_source(folder / "model")
        self.fmu = UnpackedFmu.of(pack(folder / "model", folder / "m.fmu"))
        self.lower, self.upper = (np.array(x) for x in (model.domain.lower, model.domain.upper))


_FOLDER = tempfile.TemporaryDirectory(prefix="tribofmu-tests-", ignore_cleanup_errors=True)


@functools.cache
def made(name: str) -> Made:
    """Make each wanted model once a process."""
    return Made(name, Path(tempfile.mkdtemp(dir=_FOLDER.name)))


def c_compiler() -> list[str]:
    command = compiling.system_command() or compiling.zig_command()
    if command is None:
        pytest.skip("no C compiler: neither Zig nor cc, gcc or clang")
    return command


def run(command: list[str], folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def deviation(output: str) -> float:
    found = PROGRAM_LINE.search(output)
    assert found, output
    return float(found[1])


def fmu_at(fmu: RunningFmu, loads: Array, what: str = "mu") -> Array:
    values = np.empty(len(loads))
    for i, row in enumerate(loads):
        fmu.set_real(LOAD_NAMES, row)
        values[i] = fmu.get_real([what])[0]
    return values


class Compiled:
    """A C export as a shared library."""

    def __init__(self, folder: Path) -> None:
        source = next(folder.glob("*friction.c"))
        self.prefix = source.stem
        run([*c_compiler(), *STRICT, "-shared", "-fPIC", source.name, "-o", "export.so", "-lm"], folder)
        self.library = ctypes.CDLL(str(folder / "export.so"))
        self("domain_distance").restype = ctypes.c_double
        self("mu_many").restype = ctypes.c_size_t

    def __call__(self, name: str):  # type: ignore[no-untyped-def]
        return getattr(self.library, f"{self.prefix}_{name}")

    def mu(
        self, row: Array, state: Array | None = None, system: Array | None = None, clamp: int = 1
    ) -> tuple[int, float]:
        out = ctypes.c_double(-1.0)
        return self("mu")(as_c(row), as_c(state), as_c(system), clamp, ctypes.byref(out)), out.value


def as_c(values: Array | None):  # type: ignore[no-untyped-def]
    return (
        None
        if values is None
        else np.ascontiguousarray(values).ctypes.data_as(ctypes.POINTER(ctypes.c_double))
    )


def selftest(folder: Path) -> str:
    source = next(folder.glob("*friction.c")).name
    run([*c_compiler(), *STRICT, "selftest.c", source, "-o", "selftest", "-lm"], folder)
    return run(["./selftest"], folder)
