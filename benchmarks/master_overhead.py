"""What the master adds to the C calls of a scalar friction FMU: set five loads, step, get mu."""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable
from ctypes import POINTER, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path

from fmus import pack
from fmus.runtime.fmu_files import describe, unpack
from fmus.runtime.instance import Instance
from fmus.runtime.ports import Port
from friction_models import ConstantFriction
from friction_models.loads import LOADS
from tests.interop.masters import seconds_a_step
from tests.interop.running import version
from tests.interop.subjects import Subjects

from .common import Table

STEPS, REPEATS = 20_000, 9


def overhead(folder: Path) -> Table:
    """Compare `Instance.step` with loops of bare ctypes calls on the same buffers, in one process.

    Bare calls come in two forms: with ready-made ctypes objects as arguments and no declared types, the
    fastest that ctypes offers, and with declared types, as it is usually written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    path = pack(ConstantFriction(0.08), folder / "overhead.fmu")
    description = describe(path)
    with (
        tempfile.TemporaryDirectory() as place,
        Instance("friction", unpack(description, Path(place))) as instance,
    ):
        instance.initialize([], stop_time=1e6)
        inputs = Port([v for q in LOADS for v in description.resolve(q.name)])
        outputs = Port(description.resolve("mu"))
        loops = {
            "master (Instance.step)": _through_master(instance, inputs, outputs),
            "bare calls, ready-made arguments": _bare(instance, inputs, outputs),
            "bare calls, declared types": _bare(instance, inputs, outputs, declared=True),
        }
        # In turns, so that a busy moment of the machine meets all of them.
        taken: dict[str, list[float]] = {name: [] for name in loops}
        for _ in range(REPEATS):
            for name, loop in loops.items():
                taken[name].append(loop())
    cost = {name: statistics.median(times) for name, times in taken.items()}
    master = cost["master (Instance.step)"]
    table = Table(["scalar FMI 2.0 set-step-get", "us", "master / this"])
    table.rows += [(name, f"{1e6 * value:.2f}", f"{master / value:.2f}") for name, value in cost.items()]
    return table


def coupled_step(folder: Path) -> Table:
    """Time one step of two small native FMUs that feed each other, by each master that is installed."""
    masters: dict[str, tuple[str, tuple[str, ...]]] = {
        "this master, gauss_seidel, results recorded": ("gauss_seidel", ()),
        "this master, jacobi, results recorded": ("jacobi", ()),
        "ecos": ("ecos_python", ("ecospy", "tbb")),
        "libcosim": ("libcosim", ("libcosimpy",)),
    }
    table = Table(["coupled step of two scalar FMUs, six connections", "us"])
    with tempfile.TemporaryDirectory() as place:
        subjects = Subjects(Path(place))
        for label, (client, wanted) in masters.items():
            if all(version(name) for name in wanted):
                cost = seconds_a_step(subjects, client, Path(place) / client, STEPS)
                table.rows.append((label, f"{1e6 * cost:.1f}"))
    return table


def _through_master(instance: Instance, inputs: Port, outputs: Port) -> Callable[[], float]:
    low, high = inputs.values * 0.9, inputs.values * 1.1
    values, step = inputs.values, instance.step

    def loop() -> float:
        began = time.perf_counter()
        for k in range(STEPS):
            values[:] = low if k & 1 else high
            step(inputs, outputs, k * 1e-3, 1e-3)
        return (time.perf_counter() - began) / STEPS

    return loop


def _bare(instance: Instance, inputs: Port, outputs: Port, declared: bool = False) -> Callable[[], float]:
    slave = instance.slave
    component = slave._component
    low, high = inputs.values * 0.9, inputs.values * 1.1
    values = inputs.values
    written, found = (
        values.ctypes.data_as(POINTER(c_double)),
        outputs.values.ctypes.data_as(POINTER(c_double)),
    )
    to = (c_uint * len(values))(*[v.reference for v in inputs.variables])
    of = (c_uint * 1)(outputs.variables[0].reference)
    # By item: function objects of this loop alone.
    put, advance, get = (slave._library[f"fmi2{name}"] for name in ("SetReal", "DoStep", "GetReal"))
    five, one, yes = c_size_t(len(values)), c_size_t(1), c_int(1)
    now, size = c_double(0.0), c_double(1e-3)

    def ready() -> float:
        began = time.perf_counter()
        for k in range(STEPS):
            values[:] = low if k & 1 else high
            now.value = k * 1e-3
            put(component, to, five, written)
            advance(component, now, size, yes)
            get(component, of, one, found)
        return (time.perf_counter() - began) / STEPS

    def usual() -> float:
        began = time.perf_counter()
        for k in range(STEPS):
            values[:] = low if k & 1 else high
            put(component, to, 5, written)
            advance(component, k * 1e-3, 1e-3, 1)
            get(component, of, 1, found)
        return (time.perf_counter() - began) / STEPS

    if not declared:
        return ready
    put.argtypes = get.argtypes = [c_void_p, POINTER(c_uint), c_size_t, POINTER(c_double)]
    advance.argtypes = [c_void_p, c_double, c_double, c_int]
    return usual
