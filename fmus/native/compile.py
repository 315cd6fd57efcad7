"""C99 -> shared libraries: the Zig compiler of the extra `[cross]`, or the system compiler for this machine."""

from __future__ import annotations

import functools
import getpass
import importlib.util
import os
import shutil
import struct
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from friction_models.common import InputError, unknown_name

from .platforms import Platform, host_platform, resolve, universal

_FLAGS = (
    "-O3",
    "-std=c99",
    "-ffp-contract=off",  # a*b+c is not fused: results do not depend on the machine
    "-fno-math-errno",  # nobody reads errno; sqrt becomes one instruction
    "-fno-trapping-math",  # nobody reads the flags of exceptions; comparisons become vector code
    "-fvisibility=hidden",
    "-fno-ident",
    "-g0",
)
#: Longest time of one run of a compiler [s].
_TIME_LIMIT = 1800.0
#: Start of a Windows library; see the file.
_WINDOWS = "windows.c"
_HEADERS = {
    "2.0": ("fmi2FunctionTypes.h", "fmi2Functions.h", "fmi2TypesPlatform.h"),
    "3.0": ("fmi3FunctionTypes.h", "fmi3Functions.h", "fmi3PlatformTypes.h"),
}


def zig_command() -> list[str] | None:
    """Return how to call Zig's C compiler, None when the extra `[cross]` is not installed."""
    if importlib.util.find_spec("ziglang") is None:
        return None
    return [sys.executable, "-m", "ziglang", "cc"]


def system_command() -> list[str] | None:
    """Return the C compiler of this machine (`cc`, `gcc` or `clang`), None when there is none."""
    for name in ("cc", "gcc", "clang"):
        found = shutil.which(name)
        if found:
            return [found]
    return None


def fmi_headers(fmi: str = "2.0") -> dict[str, str]:
    """Return the header files of a version of FMI, which the installed fmpy carries.

    Raises InputError: another version than 2.0 and 3.0, or no fmpy.

    Examples
    --------
    >>> sorted(fmi_headers("2.0"))
    ['fmi2FunctionTypes.h', 'fmi2Functions.h', 'fmi2TypesPlatform.h']
    """
    if fmi not in _HEADERS:
        raise unknown_name("FMI version", fmi, _HEADERS)
    found = importlib.util.find_spec("fmpy")
    if found is None or not found.submodule_search_locations:
        raise InputError(
            "fmpy is not installed, which carries the FMI headers; install tribofmu with its dependencies"
        )
    folder = Path(next(iter(found.submodule_search_locations))) / "c-code"
    return {name: (folder / name).read_text(encoding="utf-8") for name in _HEADERS[fmi]}


def build(
    sources: Mapping[str, str],
    main: str,
    identifier: str,
    platforms: Sequence[str] | None = None,
    fmi: str = "2.0",
) -> dict[str, bytes]:
    """Compile `main`, with the other texts beside it, into one shared library `identifier` a platform.

    Return them by their path inside `binaries/`; equal input gives equal bytes. `platforms` are platform tuples
    (``x86_64-linux``), other names of them (``win64``, ``macos``) or ``all``; this machine alone by default. The version of the
    standard decides on the names of the folders.
    Raises InputError: unknown platform, no compiler, or another platform than this machine's without Zig; RuntimeError: the
    compiler fails.
    """
    wanted = resolve(platforms)
    host = host_platform()
    zig, system = zig_command(), system_command()
    if zig is None:
        for target in wanted:
            if target != host:
                raise InputError(
                    f"platform {target.folder(fmi)!r} needs the Zig compiler, which is not installed; allowed "
                    f"without it: {host.folder(fmi)!r} (install the extra: pip install 'tribofmu[cross]')"
                )
        if system is None:
            raise InputError(
                "no C compiler: neither Zig (pip install 'tribofmu[cross]') nor cc, gcc or clang is installed; "
                "allowed without one: --target python"
            )
    elif fmi.startswith("2") and any(p.suffix == ".dylib" for p in wanted):
        # The one folder of FMI 2.0 serves both kinds of Mac.
        names = {p.name for p in wanted if p.suffix != ".dylib"}
        wanted = resolve([*names, "macos"])

    with tempfile.TemporaryDirectory(prefix="tribofmu-build-") as folder:
        here = Path(folder)
        for name, text in sources.items():
            (here / name).write_text(text, encoding="utf-8")
        if any(p.suffix == ".dll" for p in wanted):
            (here / _WINDOWS).write_text((Path(__file__).parent / _WINDOWS).read_text("utf-8"), "utf-8")

        def one(target: Platform) -> bytes:
            if zig is not None:
                return _zig(zig, target, main, identifier, here)
            return _system(list(system or ()), target, main, identifier, here)

        with ThreadPoolExecutor(min(len(wanted), os.cpu_count() or 1)) as pool:
            built: list[bytes] = list(pool.map(one, wanted))
    found: dict[str, list[bytes]] = {}
    for target, content in zip(wanted, built, strict=True):
        found.setdefault(f"{target.folder(fmi)}/{identifier}{target.suffix}", []).append(content)
    return {name: parts[0] if len(parts) == 1 else universal(parts) for name, parts in found.items()}


def _zig(zig: list[str], target: Platform, main: str, identifier: str, here: Path) -> bytes:
    """Compile for one platform with Zig; outputs of different platforms have folders of their own."""
    library = f"{identifier}{target.suffix}"
    place = here / target.name
    place.mkdir()
    command = [*zig, "-target", target.target]
    source = f"../{main}"
    # The name of the source never reaches the library: it is stripped, and __FILE__ is the name alone.
    if target.suffix == ".dll":
        # Headers are found when compiling; the C library of the compiler is left out when linking.
        _run([*command, *_FLAGS, "-c", source, "-o", "library.obj"], place)
        # What stands in for functions of C must not be turned into calls of them.
        alone = ["-fno-builtin", "-ffunction-sections", "-c", f"../{_WINDOWS}", "-o", "windows.obj"]
        _run([*command, *_FLAGS, *alone], place)
        link = ["-shared", "-nostdlib", "-s", "-Wl,--entry,DllMainCRTStartup", "-lucrtbase", "-lkernel32"]
        _run([*command, "library.obj", "windows.obj", *link, "-o", library], place)
        return _undated((place / library).read_bytes())
    link = ["-shared", "-fPIC", "-s", source, "-o", library]
    if target.suffix == ".so":
        link += ["-Wl,--build-id=none", "-Wl,--as-needed", "-lm"]
    _run([*command, *_FLAGS, *link], place)
    return (place / library).read_bytes()


def _system(compiler: list[str], target: Platform, main: str, identifier: str, here: Path) -> bytes:
    """Compile for this machine with its own compiler."""
    library = f"{identifier}{target.suffix}"
    flags = [*_FLAGS, "-shared", main, "-o", library]
    if target.suffix != ".dll":
        flags.append("-fPIC")
    if target.suffix == ".so":
        flags += ["-s", "-Wl,--build-id=none", "-Wl,--as-needed"]
    _run([*compiler, *flags, "-lm"], here)
    content = (here / library).read_bytes()
    return _undated(content) if target.suffix == ".dll" else content


def _undated(library: bytes) -> bytes:
    """Return a Windows library with the time of the link set to 0."""
    (start,) = struct.unpack_from("<I", library, 0x3C)
    return library[: start + 8] + bytes(4) + library[start + 12 :]


def _run(command: list[str], folder: Path) -> None:
    environment = dict(os.environ)
    # where Zig looks for a place; unlike Python it does not ask the system for the home of the user
    home = "LOCALAPPDATA" if os.name == "nt" else "HOME"
    if not os.access(os.environ.get("XDG_CACHE_HOME") or os.environ.get(home, ""), os.W_OK):
        environment.setdefault("ZIG_GLOBAL_CACHE_DIR", _temporary_cache())
    try:
        done = subprocess.run(
            command,
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=_TIME_LIMIT,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise RuntimeError(f"the C compiler was not ready after {_TIME_LIMIT:g} s") from None
    if done.returncode:
        raise RuntimeError(f"the C compiler failed ({' '.join(command[:4])} ...):\n{done.stderr[-2000:]}")


@functools.cache
def _temporary_cache() -> str:
    """Return a folder for the compiler's cache that no other user can write to, kept until the next start."""
    try:
        folder = Path(tempfile.gettempdir()) / f"tribofmu-zig-cache-{getpass.getuser()}"
        folder.mkdir(mode=0o700, exist_ok=True)
        there = folder.lstat()
        mine = not hasattr(os, "getuid") or (there.st_uid == os.getuid() and not there.st_mode & 0o022)
        if mine and not folder.is_symlink():
            return str(folder)
    except (OSError, KeyError, ImportError):  # the last two: a user without a name
        pass
    return tempfile.mkdtemp(prefix="tribofmu-zig-cache-")
