"""Trial of `check`: what the libraries of an FMU are and need, read without loading them."""

from __future__ import annotations

from pathlib import Path

from friction_models.common import InputError

from ..archive.binaries import Binary, read_binaries
from ..native.platforms import PLATFORMS, host_platform
from ..runtime.fmu_files import UnpackedFmu
from .report import Notes

_OLD = {"linux32": "x86-linux", "win32": "x86-windows", "darwin32": "x86-darwin"}
#: The folder of the one kind of library that FMI 2.0 calls by the system alone.
_OF_SYSTEM = {p.folder("2.0"): p.name for p in PLATFORMS.values() if p.folder("2.0") != p.name}
_SUFFIXES = (".so", ".dll", ".dylib")
#: Functions without their prefix, by version: of every FMU, of one for co-simulation, of one for model exchange.
_REQUIRED = {
    "2.0": (
        "GetVersion Instantiate FreeInstance SetupExperiment EnterInitializationMode ExitInitializationMode Terminate Reset "
        "GetReal SetReal GetBoolean SetBoolean",
        "DoStep",
        "SetTime GetDerivatives GetContinuousStates SetContinuousStates",
    ),
    "3.0": (
        "GetVersion FreeInstance EnterInitializationMode ExitInitializationMode Terminate Reset "
        "GetFloat64 SetFloat64 GetBoolean SetBoolean",
        "InstantiateCoSimulation DoStep",
        "InstantiateModelExchange SetTime GetContinuousStateDerivatives",
    ),
}


def binaries(fmu: UnpackedFmu, notes: Notes) -> bool:
    """Report each library; return whether there is one for this machine."""
    host = host_platform()
    here = host.folder(fmu.version)
    root = fmu.folder / "binaries"
    interfaces = (fmu.raw.coSimulation, fmu.raw.modelExchange)
    names = {i.modelIdentifier for i in interfaces if i is not None}
    folders = sorted(p for p in root.iterdir() if p.is_dir()) if root.is_dir() else []
    found = {}
    for folder in folders:
        files = [p for p in sorted(folder.iterdir()) if p.suffix in _SUFFIXES and p.stem in names]
        if not files:
            notes.note("noted", f"binaries/{folder.name}: no library with the name of the model")
            continue
        found[folder.name] = files
        for file in files:
            _one(fmu, file, notes)
    sources = (fmu.folder / "sources").is_dir()
    runs = here in found or (fmu.version == "2.0" and fmu.library.is_file())
    notes.add(
        runs,
        f"platforms: {', '.join(found) or 'none'}{', source code' if sources else ''} (this machine: {here})",
    )
    return runs


def _one(fmu: UnpackedFmu, file: Path, notes: Notes) -> None:
    where = f"{file.parent.name}/{file.name}"
    try:
        parts = read_binaries(file.read_bytes(), where)
    except InputError as error:
        notes.add(False, str(error))
        return
    wanted = _platforms_of(file.parent.name)
    for part in parts:
        functions = {n for n in part.exports if n.startswith("fmi")}
        missing = sorted(_required(fmu) - functions)
        fits = not wanted or part.platform in wanted
        text = f"{where}: {_kind(part)}, {part.size / 1000:.0f} kB, {_needs(part)}"
        if not fits:
            notes.add(False, f"{text}; the folder is for {' or '.join(wanted)}")
        elif missing:
            notes.add(False, f"{text}; {len(missing)} functions of FMI are missing: {', '.join(missing[:5])}")
        else:
            notes.add(True, text)
        if part.unresolved:
            some = ", ".join(part.unresolved[:5])
            notes.note(
                "noted",
                f"{where}: {len(part.unresolved)} symbols must come from the program that loads it ({some}"
                f"{', ...' if len(part.unresolved) > 5 else ''})",
            )
    if file.parent.name == "darwin64" and {p.machine for p in parts} == {"x86_64"}:
        notes.note("noted", f"{where}: for Intel Macs alone; ARM Macs run it in Intel programs only")


def _platforms_of(folder: str) -> tuple[str, ...]:
    """Return the platforms that libraries in a folder may be for; empty for a folder of unknown meaning."""
    if folder == "darwin64":
        return ("x86_64-darwin", "aarch64-darwin")
    # Before FMI 2.0.4 named other processors, their libraries went into the folder of the system.
    if folder == "linux64":
        return ("x86_64-linux", "aarch64-linux")
    name = _OLD.get(folder) or _OF_SYSTEM.get(folder) or folder
    known = name.partition("-")[2] in {"linux", "windows", "darwin"}
    return (name,) if known else ()


def _kind(part: Binary) -> str:
    form = {"linux": "ELF", "windows": "PE", "darwin": "Mach-O"}[part.system]
    signed = ", signed" if part.signed else ""
    return f"{form} for {part.machine}{signed}"


def _needs(part: Binary) -> str:
    foreign = part.foreign_libraries
    own = "the C library"
    if part.glibc:
        own = f"glibc {'.'.join(map(str, part.glibc))} or later"
    elif part.system == "windows":
        own = "Windows"
    if not part.libraries:
        return "needs no library"
    return f"needs {own}" + (f" and {', '.join(foreign)}" if foreign else " and nothing else")


def _required(fmu: UnpackedFmu) -> set[str]:
    """Return functions that every library of the FMU must have: those that a simple importer calls."""
    names, stepped, exchanged = (text.split() for text in _REQUIRED[fmu.version])
    if fmu.raw.coSimulation is not None:
        names += stepped
    if fmu.raw.modelExchange is not None:
        names += exchanged
    return {f"fmi{fmu.version[0]}{name}" for name in names}
