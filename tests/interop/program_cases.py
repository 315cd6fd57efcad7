"""fmusim and OMSimulator, programs without Python, on the friction FMUs."""

from __future__ import annotations

import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from friction_models.loads import LOAD_NAMES, FloatArray

from .chain import chain
from .command_lines import run_fmusim, run_omsimulator
from .comparing import CONSTANT, INTEGRATED, PRINTED, Case, Result, compared
from .running import Outcome
from .subjects import KINDS, POINTS, SCALE, STEPS, Subjects, inputs, names, series


def fmusim(case: Case, subjects: Subjects, folder: Path) -> Result:
    """A table of inputs and a table of mu."""
    exchange, memory = case.form == "model exchange", case.model == "memory"
    loads = series(case.points)
    if exchange and memory:  # what lies between the rows of the table is then no question
        loads = np.repeat(loads[:1], STEPS, axis=0)
    outputs, columns = names("mu", case.points), dict(zip(inputs(case.points), loads.T))
    options: list[str] = []
    if case.shape.startswith("array"):
        outputs, columns = ["mu"], dict(zip(LOAD_NAMES, loads.reshape(STEPS, 5, -1).transpose(1, 0, 2)))
        options += ["--start-value", "n", str(case.points)]
    if exchange:
        options += ["--solver", "cvode", "--tolerance", "1e-9"]
    fmu = subjects.friction(case.model, case.fmi, case.points)
    outcome = run_fmusim(fmu, "me" if exchange else "cs", columns, outputs, folder, *options)
    if not exchange:
        return compared(after_start(outcome), subjects.expected(case.model, loads))
    if not memory:
        return compared(outcome, subjects.expected(case.model, loads))
    result = compared(outcome, subjects.integrated(case.model, loads[0], STEPS), INTEGRATED)
    result.seen = result.seen or CONSTANT
    return result


def omsimulator(case: Case, subjects: Subjects, folder: Path) -> Result:
    """One FMU: nothing sets its inputs, so they keep their start values."""
    fmu = subjects.friction(case.model, case.fmi, case.points)
    exchange = case.form == "model exchange"
    outputs = names("mu", case.points)
    options = [f"--mode={'me' if exchange else 'cs'}", "--tolerance=1e-9"]
    outcome = run_omsimulator(fmu, outputs, folder, *options)
    loads = np.repeat(start_values(fmu, inputs(case.points))[None], STEPS, axis=0)
    if exchange and case.model == "memory":
        result = compared(outcome, subjects.integrated(case.model, loads[0], STEPS), INTEGRATED)
    else:  # twelve digits are printed
        outcome = outcome if exchange else after_start(outcome)
        result = compared(outcome, subjects.expected(case.model, loads), PRINTED)
    result.seen = result.seen or "loads at their start values"
    return result


def ssp_omsimulator(case: Case, subjects: Subjects, folder: Path) -> Result:
    """The SSP, with the step of its annotation; mu is passed on with the loads of the same moment."""
    folder.mkdir(parents=True, exist_ok=True)
    ssp = chain(case, subjects).export(folder / "chain.ssp")
    outcome = run_omsimulator(ssp, [f"meter.{n}" for n in names("scaled", case.points)], folder)
    expected = subjects.at_once(case.model, series(case.points))
    return compared(after_start(outcome), expected, PRINTED, SCALE)


def after_start(outcome: Outcome) -> Outcome:
    """Return a result without its first row."""
    if outcome.result is None:
        return outcome
    return Outcome({"values": outcome.result["values"][1:]}, outcome.seen)


def start_values(fmu: Path, wanted: list[str]) -> FloatArray:
    """Return the start values of inputs as the model description says them; our own file."""
    with zipfile.ZipFile(fmu) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    starts = {}
    for variable in root.find("ModelVariables") or ():
        place = variable.find("Real") if variable.tag == "ScalarVariable" else variable
        if place is not None and "start" in place.attrib:
            starts[variable.attrib["name"]] = place.attrib["start"]
    return np.array([float(starts[name]) for name in wanted])


def _cases() -> list[Case]:
    two, three = "2.0", "3.0"
    cosim, exchange, many = "co-simulation", "model exchange", f"N = {POINTS}"
    array = f"array, n = {POINTS}"
    sim, oms = ("fmusim",), ("OMSimulator",)
    found = []
    for model in KINDS:
        for form in (cosim, exchange):
            for fmi, shape in ((two, "scalar"), (two, many), (three, "scalar"), (three, array)):
                found.append(Case("fmusim", sim, fmi, form, shape, model, fmusim))
            found.append(Case("OMSimulator", oms, two, form, "scalar", model, omsimulator))
        found += [
            Case("OMSimulator", oms, two, cosim, many, model, omsimulator),
            Case("OMSimulator", oms, three, cosim, "scalar", model, omsimulator),
            Case("OMSimulator", oms, two, "SSP", "scalar", model, ssp_omsimulator),
        ]
    return [
        *found,
        Case("OMSimulator", oms, two, "SSP", "N = 80", "memory", ssp_omsimulator),
        Case("OMSimulator", oms, three, "SSP", "scalar", "memory", ssp_omsimulator),
        Case("OMSimulator", oms, three, exchange, "scalar", KINDS[0], omsimulator, supported=False),
    ]


PROGRAM_CASES = _cases()
