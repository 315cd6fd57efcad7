"""Every client on every form of the friction FMUs that it offers; what is known not to work is tried, too."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .chain import chain, delayed
from .children.common import Job
from .comparing import CONSTANT, INTEGRATED, Case, Result, compared
from .ecos_command import run_ecos
from .program_cases import PROGRAM_CASES
from .running import run_child
from .subjects import KINDS, MAP, POINTS, STEP, STEPS, Subjects, inputs, names, series


def _job(case: Case, subjects: Subjects) -> Job:
    outputs = names("mu", case.points)
    loads = inputs(case.points)
    if case.fmi == "3.0":  # one variable an array
        outputs, loads = ["mu"], inputs(1)
    return {
        "fmu": str(subjects.friction(case.model, case.fmi, case.points)),
        "inputs": loads,
        "outputs": outputs,
        "series": series(case.points).tolist(),
        "step": STEP,
        "n": case.points,
    }


def fmpy_cs(case: Case, subjects: Subjects, folder: Path) -> Result:
    """Set, step, get."""
    outcome = run_child("fmpy_cs", _job(case, subjects), folder)
    return compared(outcome, subjects.expected(case.model, series(case.points)))


def fmpy_me(case: Case, subjects: Subjects, folder: Path) -> Result:
    """Integrate with an input table; memory against a fine integration by the model itself."""
    work = _job(case, subjects)
    expected = subjects.expected(case.model, series(case.points))
    if case.model == "memory":
        # Constant loads: what lies between the rows of the table is then no question.
        rows = np.repeat(series(case.points)[:1], STEPS, axis=0)
        work["series"] = rows.tolist()
        expected = subjects.integrated(case.model, rows[0], STEPS)
        result = compared(run_child("fmpy_me", work, folder), expected, INTEGRATED)
        result.seen = result.seen or CONSTANT
        return result
    child = "fmpy_me" if case.points == 1 else "fmpy_me_arrays"
    return compared(run_child(child, work, folder), expected)


def _single(case: Case, subjects: Subjects) -> Job:
    """One FMU called friction, with full names."""
    fmu = subjects.friction(case.model, case.fmi, case.points)
    array = case.fmi == "3.0"
    points = 1 if array else case.points
    return {
        "fmus": {"friction": str(fmu)},
        "inputs": [f"friction.{n}" for n in inputs(points)],
        "outputs": [f"friction.{n}" for n in names("mu", points)],
        "series": series(points).tolist(),
        "step": STEP,
        "steps": STEPS,
    }


def libcosim(case: Case, subjects: Subjects, folder: Path) -> Result:
    """Inputs by an override manipulator."""
    outcome = run_child("libcosim", _single(case, subjects), folder)
    return compared(outcome, subjects.expected(case.model, series(case.points)))


def ecospy(case: Case, subjects: Subjects, folder: Path) -> Result:
    """Inputs set between the steps."""
    work = _single(case, subjects)
    if case.shape.startswith("array"):  # sized by a parameter set, elements by index
        work["inputs"] = [f"friction.{n}" for n in inputs(case.points)]
        work["outputs"] = [f"friction.{n}" for n in names("mu", case.points)]
        work["series"] = series(case.points).tolist()
    expected = subjects.expected(case.model, series(case.points))
    return compared(run_child("ecos_python", work, folder), expected)


def casadi(case: Case, subjects: Subjects, folder: Path) -> Result:
    """Values and derivatives."""
    outcome = run_child("casadi_me", _job(case, subjects), folder)
    result = compared(outcome, subjects.expected(case.model, series()))
    if result.outcome != "agrees" or outcome.result is None:
        return result
    slopes, wanted = np.array(outcome.result["slopes"]), subjects.slopes(case.model, series())
    size = np.max(np.abs(wanted), axis=0)
    size[size == 0.0] = 1.0  # of a load that the map does not go over
    worst = float(np.max(np.abs(slopes - wanted) / size))
    if worst > 1e-6:
        return Result("differs", worst, "derivatives differ from central differences")
    return Result("agrees", result.deviation, f"derivatives within {worst:.0e} of central differences")


def _ssp(case: Case, subjects: Subjects, folder: Path, boundary: bool = False) -> Job:
    folder.mkdir(parents=True, exist_ok=True)
    path = chain(case, subjects).export(folder / "chain.ssp", boundary)
    return {
        "ssp": str(path),
        "fmus": {"source": str(subjects.source(case.points)), "meter": str(subjects.meter(case.points))},
        "outputs": [f"meter.{n}" for n in names("scaled", case.points)],
        "step": STEP,
        "steps": STEPS,
    }


def ssp_libcosim(case: Case, subjects: Subjects, folder: Path) -> Result:
    """`CosimExecution.from_ssp_file`, with the step of its annotation."""
    outcome = run_child("libcosim", _ssp(case, subjects, folder), folder)
    return delayed(case, outcome, subjects.expected(case.model, series(case.points)))


def ssp_ecospy(case: Case, subjects: Subjects, folder: Path) -> Result:
    """`EcosSimulation(ssp_path=...)`."""
    outcome = run_child("ecos_python", _ssp(case, subjects, folder), folder)
    return delayed(case, outcome, subjects.expected(case.model, series(case.points)))


def ssp_ecos(case: Case, subjects: Subjects, folder: Path) -> Result:
    """The command line: a program without Python in an environment without Python."""
    work = _ssp(case, subjects, folder)
    columns = [n.replace(".", "::", 1) for n in work["outputs"]]
    outcome = run_ecos(Path(work["ssp"]), columns, folder)
    return delayed(case, outcome, subjects.expected(case.model, series(case.points)))


def ssp_fmpy(case: Case, subjects: Subjects, folder: Path) -> Result:
    """fmpy.ssp: validated, then simulated; its connected inputs begin at zero."""
    outcome = run_child("fmpy_ssp", _ssp(case, subjects, folder), folder)
    # The first row of mu is that of zero loads: it says nothing, and leaves the memory as it was.
    if outcome.result is not None:
        outcome.result["values"] = outcome.result["values"][1:]
    return delayed(case, outcome, subjects.expected(case.model, series(case.points)[1:]))


def container(case: Case, subjects: Subjects, folder: Path) -> Result:
    """The friction FMU inside a container FMU, which fmpy runs."""
    folder.mkdir(parents=True, exist_ok=True)
    fmu = subjects.friction(case.model, case.fmi, case.points)
    (folder / "friction.fmu").write_bytes(fmu.read_bytes())
    (folder / "box.csv").write_text("rule;from_fmu;from_port;to_fmu;to_port\nFMU;friction.fmu;;;\n", "utf-8")
    made = run_child("container", {"description": "box.csv", "step": STEP, "fmi": case.fmi[0]}, folder)
    if made.result is None:
        return Result("refused", seen=made.seen)
    work: Job = {**_job(case, subjects), "fmu": str(folder / "box.fmu"), "n": 1}
    return compared(run_child("fmpy_cs", work, folder), subjects.expected(case.model, series(case.points)))


def ssp_container(case: Case, subjects: Subjects, folder: Path) -> Result:
    """The SSP, with outputs of its own, as a container FMU, which fmpy runs."""
    work = _ssp(case, subjects, folder, boundary=True)
    made = run_child("container", {"description": "chain.ssp", "step": STEP}, folder)
    if made.result is None:
        return Result("refused", seen=made.seen)
    outputs = [f"meter_{n}" for n in names("scaled", case.points)]
    run: Job = {
        "fmu": str(folder / "chain.fmu"),
        "inputs": [],
        "outputs": outputs,
        "series": [[]] * STEPS,
        "step": work["step"],
    }
    return delayed(
        case, run_child("fmpy_cs", run, folder), subjects.expected(case.model, series(case.points))
    )


def validated(case: Case, subjects: Subjects, folder: Path) -> Result:
    """What validators say about the files; nothing is run."""
    work: Job = {"fmu": str(subjects.friction(case.model, case.fmi)), "validator": case.client}
    outcome = run_child("validators", work, folder)
    if outcome.result is None:
        return Result("refused", seen=outcome.seen)
    found = outcome.result["values"]
    return Result("differs", seen="; ".join(found)[:200]) if found else Result("agrees", seen="no findings")


def _cases() -> list[Case]:
    two, three = "2.0", "3.0"
    large = "N = 80"  # as many contact points as a forming process has markers
    many, array = f"N = {POINTS}", f"array, n = {POINTS}"
    ecos = ("ecospy", "tbb")
    box = ("fmu-manipulation-toolbox",)
    cosim, exchange = "co-simulation", "model exchange"
    cases = []
    for model in KINDS:
        cases += [
            Case("fmpy", ("fmpy",), two, cosim, "scalar", model, fmpy_cs),
            Case("fmpy", ("fmpy",), two, cosim, many, model, fmpy_cs),
            Case("fmpy", ("fmpy",), three, cosim, "scalar", model, fmpy_cs),
            Case("fmpy", ("fmpy",), three, cosim, array, model, fmpy_cs),
            Case("fmpy", ("fmpy",), two, exchange, "scalar", model, fmpy_me),
            Case("fmpy", ("fmpy",), three, exchange, "scalar", model, fmpy_me),
            Case("libcosimpy", ("libcosimpy",), two, cosim, "scalar", model, libcosim),
            Case("libcosimpy", ("libcosimpy",), two, cosim, many, model, libcosim),
            Case("ecospy", ecos, two, cosim, "scalar", model, ecospy),
            Case("ecospy", ecos, two, cosim, many, model, ecospy),
            Case("ecospy", ecos, three, cosim, "scalar", model, ecospy),
            Case("fmucontainer", box, two, cosim, "scalar", model, container),
            Case("fmucontainer", box, two, cosim, many, model, container),
            Case("fmucontainer", box, three, cosim, "scalar", model, container),
            *(Case("fmpy", ("fmpy",), v, "validation", "scalar", model, validated) for v in (two, three)),
            *(Case("fmutool", box, v, "validation", "scalar", model, validated) for v in (two, three)),
            Case("ecos command line", ecos, two, "SSP", "scalar", model, ssp_ecos),
        ]
    cases += [
        *(Case("CasADi", ("casadi",), v, exchange, "scalar", KINDS[0], casadi) for v in (two, three)),
        Case("fmpy", ("fmpy",), three, exchange, array, KINDS[0], fmpy_me),
        Case("ecos command line", ecos, three, "SSP", "scalar", "memory", ssp_ecos),
        Case("ecos command line", ecos, two, "SSP", large, "memory", ssp_ecos),
        Case("libcosimpy", ("libcosimpy",), two, "SSP", large, "memory", ssp_libcosim),
        Case("fmucontainer", box, two, "SSP", large, "memory", ssp_container),
        Case("fmpy.ssp", ("fmpy",), two, "SSP", large, "memory", ssp_fmpy),
        Case("ecospy", ecos, two, "SSP", "scalar", "memory", ssp_ecospy),
        Case("libcosimpy", ("libcosimpy",), two, "SSP", "scalar", "memory", ssp_libcosim),
        Case("fmpy.ssp", ("fmpy",), two, "SSP", "scalar", "memory", ssp_fmpy),
        Case("fmucontainer", box, two, "SSP", "scalar", "memory", ssp_container),
        Case("fmpy", ("fmpy",), three, cosim, "scalar", MAP, fmpy_cs),
        Case("fmpy", ("fmpy",), three, exchange, "scalar", MAP, fmpy_me),
        Case("fmpy", ("fmpy",), three, "validation", "scalar", MAP, validated),
        Case("fmutool", box, three, "validation", "scalar", MAP, validated),
        Case("ecospy", ecos, three, cosim, "scalar", MAP, ecospy),
        # It records all variables and reads arrays as single values; the map refuses that, as FMI 3.0 says.
        Case("ecos command line", ecos, three, "SSP", "scalar", MAP, ssp_ecos, supported=False),
        Case("ecospy", ecos, three, "SSP", "scalar", MAP, ssp_ecospy),
        Case("fmucontainer", box, three, cosim, "scalar", MAP, container),
        Case("CasADi", ("casadi",), three, exchange, "scalar", MAP, casadi),
        Case("libcosimpy", ("libcosimpy",), three, cosim, "scalar", KINDS[0], libcosim, supported=False),
        Case("ecospy", ecos, three, cosim, array, KINDS[0], ecospy, supported=False),
        Case("fmucontainer", box, three, cosim, array, KINDS[0], container, supported=False),
    ]
    return cases


CASES = sorted(_cases() + PROGRAM_CASES, key=lambda case: (case.client.lower(), case.fmi, case.form))
