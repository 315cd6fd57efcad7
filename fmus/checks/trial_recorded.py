"""Trial of `check`: reference results that the FMU carries, in the layout of the layered standard FMI-LS-REF."""

from __future__ import annotations

import csv
import hashlib
import io
from pathlib import Path, PurePosixPath

import numpy as np

from friction_models.common import InputError, unknown_name
from friction_models.loads import FloatArray

from ..archive.content import parse_xml
from ..runtime.fmu_files import UnpackedFmu
from ..runtime.running import RunningFmu
from ..source.reference_results import FOLDER
from .report import Notes

_MAX_BYTES = 64 * 1024**2
#: Agreement: of a friction FMU, and of others, whose solvers differ in steps, relative to the largest value.
_RELATIVE, _ABSOLUTE, _OTHERS = 1e-9, 1e-12, 1e-3


def recorded(fmu: UnpackedFmu, notes: Notes) -> None:
    """Play the recorded experiments and compare the outputs."""
    folder = fmu.folder / FOLDER
    if not (folder / "fmi-ls-manifest.xml").is_file():
        notes.note("skipped", "the FMU carries none (FMI-LS-REF)")
        return
    if fmu.raw.coSimulation is None:
        notes.note("skipped", "the FMU offers no co-simulation")
        return
    manifest = parse_xml(_bytes(folder / "fmi-ls-manifest.xml"), "fmi-ls-manifest.xml")
    experiments = []
    good = True
    for item in manifest.iter("{*}Related"):
        source, checksum = str(item.get("source", "")), item.get("checksum")
        if str(item.get("role", "")).startswith("experiment"):
            experiments.append(source)
        if checksum and hashlib.sha3_256(_bytes(_inside(fmu, folder, source))).hexdigest() != checksum:
            notes.add(False, f"{source!r} is not the file that the manifest describes (checksum)")
            good = False
    if good:
        notes.add(True, "manifest: every file is there, checksums fit")
    for source in experiments:
        root = parse_xml(_bytes(_inside(fmu, folder, source)), source)
        for experiment in root.iter("{*}Experiment"):
            stimuli, references = experiment.find("{*}Stimuli"), experiment.find("{*}References")
            if references is None:
                notes.note("skipped", f"experiment {experiment.get('name')!r} has no references")
                continue
            expected = _table(_inside(fmu, folder, str(references.get("source", ""))))
            given = None
            if stimuli is not None:
                given = _table(_inside(fmu, folder, str(stimuli.get("source", ""))))
            _play(fmu, str(experiment.get("name", "")), given, expected, notes)


class _Table:
    """A CSV file: times and one column a value; the columns of an array repeat its name."""

    def __init__(self, names: list[str], values: FloatArray) -> None:
        self.time = values[:, 0]
        self.columns: dict[str, list[int]] = {}
        for k, name in enumerate(names[1:], start=1):
            self.columns.setdefault(name, []).append(k)
        self.values = values

    def of(self, names: list[str], row: int) -> FloatArray:
        return self.values[row][[k for n in names for k in self.columns[n]]]


def _play(fmu: UnpackedFmu, name: str, given: _Table | None, expected: _Table, notes: Notes) -> None:
    """Set the inputs of a row, compare the outputs, step to the next row with the inputs held."""
    for table in filter(None, (given, expected)):
        for column, places in table.columns.items():
            if column not in fmu.arrays and column not in fmu.variables:
                raise unknown_name("variable", column, fmu.variables, f"experiment {name!r}")
            if len(places) != len(fmu.resolve(column)):
                raise InputError(
                    f"experiment {name!r}: {len(places)} columns of {column!r}, allowed: {len(fmu.resolve(column))}"
                )
    if given is not None and not np.array_equal(given.time, expected.time):
        notes.note("skipped", f"experiment {name!r}: stimuli and references have different times")
        return
    inputs = [] if given is None else [n for n in given.columns if fmu.resolve(n)[0].is_float64]
    outputs = [n for n in expected.columns if fmu.resolve(n)[0].is_float64]
    flags = [n for n in expected.columns if fmu.resolve(n)[0].type == "Boolean"]
    worst, good = 0.0, True
    scale = np.abs(expected.values[:, [k for n in outputs for k in expected.columns[n]]]).max(
        axis=0, initial=0.0
    )
    with RunningFmu(fmu, "recorded") as running:
        for row, time in enumerate(expected.time):
            if given is not None and inputs:
                running.set_real(inputs, given.of(inputs, row))
            wanted = expected.of(outputs, row)
            found = running.get_real(outputs)
            error = np.abs(found - wanted)
            limit = _ABSOLUTE + (_RELATIVE * np.abs(wanted) if fmu.is_friction else _OTHERS * scale)
            good = good and bool((error <= limit).all())
            worst = max(worst, float(error.max(initial=0.0)))
            for flag in flags:
                good = good and running.get_boolean(flag) == bool(expected.of([flag], row)[0])
            if row + 1 < len(expected.time):
                running.step(float(time), float(expected.time[row + 1] - time))
    names = ", ".join((*outputs, *flags)[:6])
    notes.add(
        good, f"experiment {name!r}: {names} at {len(expected.time)} times, largest difference {worst:.1e}"
    )


def _table(path: Path) -> _Table:
    rows = list(csv.reader(io.StringIO(_bytes(path).decode("utf-8", "replace"))))
    names = [n.strip() for n in rows[0]] if rows else []
    try:
        values = np.array([[float(x) for x in row] for row in rows[1:] if row])
    except ValueError as error:
        raise InputError(f"{path.name}: {error}, allowed: numbers") from None
    if len(names) < 2 or values.ndim != 2 or values.shape[1] != len(names) or not np.isfinite(values).all():
        raise InputError(f"{path.name}: allowed: a header, times and one finite number for every column")
    if (np.diff(values[:, 0]) < 0.0).any():
        raise InputError(f"{path.name}: the times of column {names[0]!r} go back, allowed: growing ones")
    return _Table(names, values)


def _inside(fmu: UnpackedFmu, folder: Path, source: str) -> Path:
    """Return the file that the manifest names, which must lie inside the FMU."""
    path = folder.joinpath(*PurePosixPath(source).parts).resolve()
    if not path.is_relative_to(fmu.folder.resolve()) or not path.is_file():
        raise InputError(f"{source!r} in the manifest is no file of the FMU, allowed: a relative path to one")
    return path


def _bytes(path: Path) -> bytes:
    if path.stat().st_size > _MAX_BYTES:
        raise InputError(f"{path.name}: {path.stat().st_size} bytes, allowed: at most {_MAX_BYTES}")
    return path.read_bytes()
