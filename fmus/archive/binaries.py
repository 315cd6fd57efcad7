"""Reads shared libraries without loading them: ELF (Linux), PE (Windows) and Mach-O (macOS), by LIEF."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from friction_models.common import InputError

#: Largest file that is looked at.
MAX_BYTES = 512 * 1024**2

#: Libraries that belong to the C library of Linux.
_LIBC = re.compile(r"lib(c|m|pthread|dl|rt|util)\.so\.\d+|ld-linux[\w-]*\.so\.\d+|libSystem\.B\.dylib")
#: Libraries that every 64-bit Windows 10 carries and C programs use.
_WINDOWS = re.compile(r"(kernel32|kernelbase|ntdll|ucrtbase|msvcrt|api-ms-win-[\w-]+)\.dll", re.IGNORECASE)


@dataclass(frozen=True)
class Binary:
    """What one shared library is and needs.

    Examples
    --------
    >>> needs = {"exp": "GLIBC_2.29", "solve_": ""}
    >>> library = Binary("linux", "x86_64", 9000, ("libm.so.6", "libgfortran.so.5"), needs, ("fmi2DoStep",))
    >>> library.platform, library.foreign_libraries, library.unresolved
    ('x86_64-linux', ('libgfortran.so.5',), ('solve_',))
    """

    system: str  #: ``linux``, ``windows`` or ``darwin``.
    machine: str  #: ``x86_64``, ``aarch64``, ``x86`` or the name that the format has for it.
    size: int  #: Bytes.
    libraries: tuple[str, ...]  #: Names of the libraries that it asks for.
    #: Symbol that it does not define -> version (ELF), library (PE) or nothing. Weak symbols, which may be missing, are left out.
    imports: dict[str, str]
    exports: tuple[str, ...]  #: Symbols that it offers.
    glibc: tuple[int, ...] = ()  #: Oldest glibc that has all symbols; empty without one.
    timestamp: int = 0  #: Date in the header of a PE file, otherwise 0.
    signed: bool = False  #: Whether a Mach-O file carries a code signature.

    @property
    def platform(self) -> str:
        """The platform tuple of FMI 3.0."""
        return f"{self.machine}-{self.system}"

    @property
    def foreign_libraries(self) -> tuple[str, ...]:
        """Libraries beyond the C library of the system."""
        known = _WINDOWS if self.system == "windows" else _LIBC
        return tuple(n for n in self.libraries if not known.fullmatch(n.rpartition("/")[2]))

    @property
    def unresolved(self) -> tuple[str, ...]:
        """Symbols that no named library answers for: ELF symbols without a version.

        glibc gives a version to everything it offers, so that these come from another library, or
        from the program that loads this one.
        """
        if self.system != "linux":
            return ()
        return tuple(sorted(n for n, version in self.imports.items() if not version))


def read_binaries(content: bytes, where: str) -> list[Binary]:
    """Read a shared library, `where` in messages; a universal Mach-O file holds several.

    Raises InputError: not one of the three formats, damaged, or too large.

    Examples
    --------
    >>> read_binaries(b"#!/bin/sh", "binaries/linux64/law.so")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: binaries/linux64/law.so: not a shared library (it starts with '23212f62'), allowed: ELF, PE or Mach-O
    """
    if len(content) > MAX_BYTES:
        raise InputError(f"{where}: {len(content)} bytes, allowed: at most {MAX_BYTES}")
    magic = content[:4]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about numbers that LIEF has no name for
            found = _read(content, magic, where)
    except InputError:
        raise
    except Exception as error:  # LIEF has no family of errors of its own
        raise InputError(f"{where}: cannot be read as a shared library ({error})") from None
    if not found:
        raise InputError(f"{where}: damaged, it holds no shared library")
    return found


def _read(content: bytes, magic: bytes, where: str) -> list[Binary]:
    import lief

    lief.logging.disable()
    if magic == b"\x7fELF":
        return [_elf(_readable(lief.ELF.parse(content), where), len(content))]
    if magic[:2] == b"MZ":
        return [_pe(_readable(lief.PE.parse(content), where), len(content))]
    if magic in _MACHO:
        # The parts live as long as the whole.
        whole = _readable(lief.MachO.parse(content), where)
        return [_macho(part) for part in whole]
    raise InputError(
        f"{where}: not a shared library (it starts with {magic.hex()!r}), allowed: ELF, PE or Mach-O"
    )


_MACHO = {bytes.fromhex(m) for m in ("cffaedfe", "cefaedfe", "cafebabe")}
_MACHINES = {"AMD64": "x86_64", "ARM64": "aarch64", "I386": "x86", "X86": "x86"}


def _readable(parsed: Any, where: str) -> Any:
    if parsed is None:
        raise InputError(f"{where}: damaged, it cannot be read as a shared library")
    return parsed


def _machine(value: Any) -> str:
    name = str(value).rpartition(".")[2]
    return _MACHINES.get(name, name.lower())


def _elf(binary: Any, size: int) -> Binary:
    import lief

    imports = {}
    for symbol in binary.dynamic_symbols:
        # Undefined in any section; weak ones may stay so.
        if symbol.shndx == 0 and symbol.name and symbol.binding == lief.ELF.Symbol.BINDING.GLOBAL:
            version: Any = symbol.symbol_version if symbol.has_version else None
            known = version is not None and version.has_auxiliary_version
            imports[str(symbol.name)] = str(version.symbol_version_auxiliary.name) if known else ""
    versions = [
        tuple(int(n) for n in text.partition("_")[2].split("."))
        for text in imports.values()
        if re.fullmatch(r"GLIBC_\d+(\.\d+)*", text)
    ]
    return Binary(
        system="linux",
        machine=_machine(binary.header.machine_type),
        size=size,
        libraries=tuple(str(n) for n in binary.libraries),
        imports=imports,
        exports=_names(s.name for s in binary.dynamic_symbols if s.exported),
        glibc=max(versions, default=()),
    )


def _pe(binary: Any, size: int) -> Binary:
    imports = {}
    libraries = []
    for library in [*binary.imports, *binary.delay_imports]:
        libraries.append(str(library.name))
        for entry in library.entries:
            imports[f"#{entry.ordinal}" if entry.is_ordinal else str(entry.name)] = str(library.name)
    return Binary(
        system="windows",
        machine=_machine(binary.header.machine),
        size=size,
        libraries=tuple(libraries),
        imports=imports,
        exports=_names(f.name for f in binary.exported_functions),
        timestamp=int(binary.header.time_date_stamps),
    )


def _macho(binary: Any) -> Binary:
    import lief

    own = binary.get(lief.MachO.LoadCommand.TYPE.ID_DYLIB)
    libraries = [str(c.name) for c in binary.libraries if own is None or c.command != own.command]
    return Binary(
        system="darwin",
        machine=_machine(binary.header.cpu_type),
        size=int(binary.original_size),
        libraries=tuple(libraries),
        # C names have one underscore more in this format.
        imports={str(s.name).removeprefix("_"): "" for s in binary.imported_symbols},
        exports=_names(str(s.name).removeprefix("_") for s in binary.exported_symbols),
        signed=bool(binary.has_code_signature),
    )


def _names(found: Iterable[Any]) -> tuple[str, ...]:
    return tuple(sorted({str(n) for n in found if n}))
