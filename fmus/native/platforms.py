"""The platforms that native FMUs are built for: names, folders, compiler targets, universal Mach-O files."""

from __future__ import annotations

import platform
import struct
import sys
from collections.abc import Sequence
from dataclasses import dataclass

from friction_models.common import InputError, unknown_name


@dataclass(frozen=True)
class Platform:
    """A machine and operating system.

    Examples
    --------
    >>> Platform("x86_64-linux", "x86_64-linux-gnu.2.17", ".so").folder("2.0")
    'linux64'
    """

    name: str  #: The platform tuple of FMI 3.0, which also names the folder in ``binaries/``.
    target: str  #: Target of the Zig compiler. The old glibc makes Linux binaries run on old systems.
    suffix: str  #: Ending of a shared library.

    def folder(self, fmi: str = "2.0") -> str:
        """Return the folder below ``binaries/``.

        FMI 2.0 has names of its own for x86; since 2.0.4 it refers to the tuples of FMI 3.0 for all
        others. Both Macs share ``darwin64``, as one universal file.
        """
        if fmi.startswith("3"):
            return self.name
        return _FMI2_FOLDERS.get(self.name, self.name)


_FMI2_FOLDERS = {
    "x86_64-linux": "linux64",
    "x86_64-windows": "win64",
    "x86_64-darwin": "darwin64",
    "aarch64-darwin": "darwin64",
}

PLATFORMS: dict[str, Platform] = {
    p.name: p
    for p in (
        Platform("x86_64-linux", "x86_64-linux-gnu.2.17", ".so"),
        Platform("aarch64-linux", "aarch64-linux-gnu.2.17", ".so"),
        Platform("x86_64-windows", "x86_64-windows-gnu", ".dll"),
        Platform("x86_64-darwin", "x86_64-macos.11.0", ".dylib"),
        Platform("aarch64-darwin", "aarch64-macos.11.0", ".dylib"),
    )
}

#: Names that people use -> platform tuples.
ALIASES: dict[str, tuple[str, ...]] = {
    "all": tuple(PLATFORMS),
    "linux": ("x86_64-linux", "aarch64-linux"),
    "linux64": ("x86_64-linux",),
    "linux-x86_64": ("x86_64-linux",),
    "linux-aarch64": ("aarch64-linux",),
    "linux-arm64": ("aarch64-linux",),
    "windows": ("x86_64-windows",),
    "win64": ("x86_64-windows",),
    "macos": ("x86_64-darwin", "aarch64-darwin"),
    "darwin64": ("x86_64-darwin", "aarch64-darwin"),
    "macos-x86_64": ("x86_64-darwin",),
    "macos-arm64": ("aarch64-darwin",),
}

_MACHINES = {"amd64": "x86_64", "x64": "x86_64", "arm64": "aarch64"}


def host_platform() -> Platform:
    """Return the platform of this machine, which may be one that is not in `PLATFORMS`."""
    machine = platform.machine().lower()
    machine = _MACHINES.get(machine, machine)
    if sys.platform.startswith("win"):
        name = f"{machine}-windows"
        return PLATFORMS.get(name, Platform(name, f"{machine}-windows-gnu", ".dll"))
    if sys.platform == "darwin":
        return PLATFORMS[f"{machine}-darwin"]
    name = f"{machine}-linux"
    return PLATFORMS.get(name, Platform(name, f"{machine}-linux-gnu", ".so"))


def resolve(names: Sequence[str] | None) -> list[Platform]:
    """Return the platforms that `names` stand for, each once; this machine's for None or none at all.

    A name is a platform tuple, a key of `ALIASES`, or ``host``.
    Raises InputError: an unknown name; with the nearest one.

    Examples
    --------
    >>> [(p.name, p.folder("2.0"), p.folder("3.0")) for p in resolve(["win64"])]
    [('x86_64-windows', 'win64', 'x86_64-windows')]
    >>> [p.name for p in resolve(["linux"])]
    ['x86_64-linux', 'aarch64-linux']
    """
    host = host_platform()
    known = {**PLATFORMS, host.name: host}
    found: dict[str, Platform] = {}
    if isinstance(names, str):
        names = [names]
    for given in names or ("host",):
        name = str(given).strip().lower()
        tuples = (host.name,) if name == "host" else ALIASES.get(name, (name,))
        for each in tuples:
            if each not in known:
                raise unknown_name("platform", given, {*known, *ALIASES, "host"})
            found[each] = known[each]
    # One order whatever was typed first: equal choices give equal files.
    order = list(known)
    return sorted(found.values(), key=lambda p: order.index(p.name))


#: Alignment of the parts of a universal file: the memory page of Apple's ARM processors.
_ALIGNMENT = 14
_THIN_MAGIC, _FAT_MAGIC = 0xFEEDFACF, 0xCAFEBABE


def universal(parts: Sequence[bytes]) -> bytes:
    """Join 64-bit Mach-O files of different machines to one universal file.

    The parts stay as they are, so that the code signature of each stays valid. Layout: Apple's
    ``mach-o/fat.h``, all numbers big endian.
    Raises InputError: a part that is not a 64-bit little-endian Mach-O file, or two for one machine.
    """
    header = struct.pack(">2I", _FAT_MAGIC, len(parts))
    body = b""
    seen = set()
    start = len(header) + 20 * len(parts)
    for part in parts:
        if len(part) < 32 or struct.unpack_from("<I", part)[0] != _THIN_MAGIC:
            raise InputError("universal file: a part is not a 64-bit Mach-O file")
        machine = struct.unpack_from("<2I", part, 4)
        if machine in seen:
            raise InputError(f"universal file: two parts are for one machine (CPU type {machine[0]:#x})")
        seen.add(machine)
        body += bytes(-(start + len(body)) % (1 << _ALIGNMENT))
        header += struct.pack(">5I", *machine, start + len(body), len(part), _ALIGNMENT)
        body += part
    return header + body
