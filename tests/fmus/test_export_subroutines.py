"""Subroutines for Marc, Simufact and Abaqus, compiled, driven as their hosts do and compared with the FMU."""

from __future__ import annotations

import shutil
import subprocess
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

from fmus.exports import export
from fmus.runtime.running import RunningFmu
from friction_models.loads import LOAD_NAMES
from tests.fmus.exported import (
    FORTRAN,
    NAMES,
    STRICT,
    c_compiler,
    deviation,
    made,
    run,
)

#: By day one model without memory, one with, and one with a system variable.
CASES = [
    pytest.param(n, marks=pytest.mark.nightly if n in ("constant", "ffnn", "gradient_boosting") else ())
    for n in NAMES
]


def build_fortran(folder: Path, parts: list[str], *flags: str) -> None:
    fortran = shutil.which("gfortran")
    if fortran is None:
        pytest.skip("gfortran is not installed: the Fortran of this export is not compiled and not run")
    source = next(folder.glob("*friction.c"))
    run([*c_compiler(), *STRICT, "-c", source.name, "-o", "model.o"], folder)
    run([fortran, *FORTRAN, *flags, *parts, "model.o", "-o", "driver", "-lm"], folder)


@pytest.mark.parametrize("name", CASES)
def test_ufric_follows_the_fmu_through_iterations_and_cutbacks(name: str, tmp_path: Path) -> None:
    model = made(name)
    folder = export(model.source, tmp_path / "ufric", "ufric")
    assert max(map(len, (folder / "ufric.f").read_text().splitlines())) <= 72
    build_fortran(folder, ["ufric.f", "selftest.f90"])
    assert deviation(run(["./driver"], folder)) < 1e-12
    rng = np.random.default_rng(6)
    rows, time = [], 0.0
    nodes = {17: 0.0, 400_001: 0.0, 23: 0.0}  # sliding distance of each
    with RunningFmu(model.fmu) as a, RunningFmu(model.fmu) as b, RunningFmu(model.fmu) as c:
        fmus = dict(zip(nodes, (a, b, c)))
        for inc in range(1, 9):
            dt = float(rng.uniform(0.002, 0.01))
            lengths = [3.0 * dt, dt, dt] if inc == 5 else [dt, dt]
            for attempt, length in enumerate(lengths):
                for number in nodes:
                    if number == 23 and inc in (4, 5):
                        continue  # out of contact
                    v = rng.uniform(-300.0, 300.0, 2)
                    T, sigma = rng.uniform(20.0, 350.0), rng.uniform(200.0, 3000.0)
                    mu = -1.0
                    if attempt == len(lengths) - 1:
                        speed = float(np.hypot(*v))
                        nodes[number] += speed * dt
                        fmus[number].set_real(LOAD_NAMES, np.array([speed, T, sigma, nodes[number], 1.0]))
                        fmus[number].step(time, dt)
                        mu = fmus[number].get_real(["mu"])[0]
                    values = (time + length, 0.0, 0.0, *v, T, sigma, mu)
                    rows.append(f"{number} {inc} " + " ".join(repr(float(x)) for x in values))
            time += dt
    (folder / "fmu.txt").write_text("\n".join(rows) + "\n")
    assert deviation(run(["./driver", "fmu.txt"], folder)) < 1e-12


def test_ufric_keeps_many_points_apart_and_survives_bad_loads(tmp_path: Path) -> None:
    model = made("linear + work_exhaustion")
    folder = export(model.source, tmp_path / "ufric", "ufric")
    build_fortran(folder, ["ufric.f", "selftest.f90"], "-fcheck=all")
    loads = np.array([100.0, 80.0, 1000.0, 0.0, 1.0])
    rows, many = [], range(1, 40_000, 13)
    with RunningFmu(model.fmu) as fmu:
        mu = []
        for inc in (1, 2, 3):
            loads[3] += 0.5  # 100 mm/s for 5 ms
            fmu.set_real(LOAD_NAMES, loads)
            fmu.step(0.005 * (inc - 1), 0.005)
            mu.append(float(fmu.get_real(["mu"])[0]))
    assert len(set(mu)) == 3
    for inc in (1, 2, 3):
        for number in many:
            rows.append(f"{number} {inc} {0.005 * inc!r} 0. 0. 60. 80. 80. 1000. {mu[inc - 1]!r}")
            if number == 14:  # an iteration that went wrong leaves nothing behind
                rows.insert(-1, f"{number} {inc} {0.005 * inc!r} 0. 0. NaN 80. 80. 1000. -1.")
    (folder / "many.txt").write_text("\n".join(rows) + "\n")
    output = run(["./driver", "many.txt"], folder)
    assert deviation(output) < 1e-12
    assert output.count("mu      not computed, a load is not finite (first at point 14, increment 1)") == 1


def test_ufric_carries_sliding_distance_and_memory_through_a_remeshing(tmp_path: Path) -> None:
    """Points on a line slide at speeds of their own; a remeshing turns the numbers round and adds some."""
    model = made("linear + work_exhaustion")
    folder = export(model.source, tmp_path / "ufric", "ufric")
    code = folder / "ufric.f"
    text = code.read_text()
    code.write_text(text.replace("tf_remesh = 0.0d0", "tf_remesh = 1.5d0"))
    build_fortran(folder, ["ufric.f", "selftest.f90"], "-fcheck=all")
    dt, count = 0.01, 20
    rows: list[str] = []
    with ExitStack() as stack:
        fmus = [stack.enter_context(RunningFmu(model.fmu)) for _ in range(count)]
        sd = np.zeros(count)
        for inc in range(1, 7):
            calls = []
            for k in range(count):  # material point k, 1 mm apart, moving on by 0.1 mm an increment
                speed = 50.0 + 20.0 * k
                sd[k] += speed * dt
                fmus[k].set_real(LOAD_NAMES, np.array([speed, 100.0, 900.0, sd[k], 1.0]))
                fmus[k].step(dt * (inc - 1), dt)
                number = k + 1 if inc < 4 else 40 - k  # 21 to 40: half of the numbers are new
                if inc < 4:
                    number += 10
                calls.append((number, k + 0.1 * inc, speed, fmus[k].get_real(["mu"])[0]))
            if inc >= 4:
                calls.append((5, 100.0, 77.0, -1.0))  # contact far away is new contact
            for final in (False, True):
                for number, x, speed, mu in calls if inc != 4 else calls[::-1]:
                    values = (dt * inc, x, 0.0, speed, 0.0, 100.0, 900.0, mu if final else -1.0)
                    rows.append(f"{number} {inc} " + " ".join(repr(float(v)) for v in values))
    (folder / "remesh.txt").write_text("\n".join(rows) + "\n")
    assert deviation(run(["./driver", "remesh.txt"], folder)) < 1e-12
    code.write_text(text)  # without the setting the numbers keep what they have, and that is wrong
    build_fortran(folder, ["ufric.f", "selftest.f90"])
    with pytest.raises(AssertionError, match="expected"):
        run(["./driver", "remesh.txt"], folder)


@pytest.mark.parametrize("name", CASES)
def test_vfric_and_vfriction_follow_the_fmu(name: str, tmp_path: Path) -> None:
    model = made(name)
    folder = export(model.source, tmp_path / "vfric", "vfric")
    assert max(map(len, (folder / "vfric.f").read_text().splitlines())) <= 72
    build_fortran(folder, ["vfric.f", "selftest/selftest.f90"], "-I", "selftest")
    assert deviation(run(["./driver", "selftest/selftest.txt"], folder)) < 1e-12
    system = [0.6 for _ in model.source.system]
    rng = np.random.default_rng(7)
    rows = [" ".join(repr(x) for x in (1.0, 20.0, *system))]
    start = {p.name: x for p, x in zip(model.source.system, system)}
    with RunningFmu(model.fmu, start=start) as a, RunningFmu(model.fmu, start=start) as b:
        sd, first, time = {3: 0.0, 7: 0.0}, {3: 0.0, 7: 0.0}, 0.0
        for inc in range(1, 9):
            dt = float(rng.uniform(1e-4, 1e-3))
            present = [(n, f) for n, f in ((3, a), (7, b)) if not (n == 7 and inc == 4)]
            rows.append(f"{inc} {dt!r} {len(present)}")
            for number, fmu in present:
                slip = rng.normal(size=3) * 0.1
                T, sigma, area = rng.uniform(20, 350), rng.uniform(300, 3000), rng.uniform(1.0, 1.5) * inc
                first[number] = first[number] or area
                speed = float(np.sqrt((slip**2).sum())) / dt
                sd[number] += speed * dt
                fmu.set_real(
                    LOAD_NAMES, np.array([speed, T, sigma * area / area, sd[number], area / first[number]])
                )
                fmu.step(time, dt)
                mu = fmu.get_real(["mu"])[0]
                values = (*slip, sigma * area, area, T - 20.0, T + 20.0, mu)
                rows.append(f"{number} " + " ".join(repr(float(x)) for x in values))
            time += dt
    (folder / "fmu.txt").write_text("\n".join(rows) + "\n")
    assert deviation(run(["./driver", "fmu.txt"], folder)) < 1e-12


def test_vfric_compiles_in_single_precision_and_refuses_too_few_state_variables(tmp_path: Path) -> None:
    folder = export(made("linear + work_exhaustion").source, tmp_path / "vfric", "vfric")
    driver = folder / "selftest" / "selftest.f90"
    text = driver.read_text()
    driver.write_text(text.replace("depvar = 4", "depvar = 3"))
    assert driver.read_text() != text
    build_fortran(folder, ["vfric.f", "selftest/selftest.f90"], "-I", "selftest")
    done = subprocess.run(
        ["./driver", "selftest/selftest.txt"], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert "DEPVAR = 3 in *FRICTION, USER; needed: at least 4" in done.stdout
    (folder / "selftest" / "vaba_param.inc").write_text("      implicit real (a-h, o-z)\n")
    run(["gfortran", *FORTRAN, "-Wno-conversion", "-I", "selftest", "-c", "vfric.f"], folder)
