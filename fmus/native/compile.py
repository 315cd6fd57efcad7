"""C99 -> shared libraries: the Zig compiler of the extra `[cross]`, or the system compiler for this machine."""

from __future__ import annotations

import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from friction_models.loads import InputError, unknown_name

#: FMI 2.0 platform folder -> (Zig target, suffix). The old glibc makes Linux binaries run on old systems.
PLATFORMS: dict[str, tuple[str, str]] = {
    "linux64": ("x86_64-linux-gnu.2.17", ".so"),
    "win64": ("x86_64-windows-gnu", ".dll"),
}
_FLAGS = (
    "-shared",
    "-fPIC",
    "-O3",
    "-std=c99",
    "-ffp-contract=off",  # a*b+c is not fused: results do not depend on the machine
    "-fvisibility=hidden",
    "-g0",
    "-s",
)


def host_platform() -> tuple[str, str, str]:
    """Return the FMI 2.0 platform folder, the Zig target and the library suffix of this machine."""
    machine = {"amd64": "x86_64", "x86_64": "x86_64", "arm64": "aarch64", "aarch64": "aarch64"}.get(
        platform.machine().lower(), platform.machine().lower()
    )
    if sys.platform.startswith("win"):
        return "win64", f"{machine}-windows-gnu", ".dll"
    if sys.platform == "darwin":
        return "darwin64", f"{machine}-macos.11.0", ".dylib"
    return "linux64", f"{machine}-linux-gnu.2.17", ".so"


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


def fmi_headers() -> dict[str, str]:
    """Return the FMI 2.0 header files, which the installed fmpy carries."""
    found = importlib.util.find_spec("fmpy")
    if found is None or not found.submodule_search_locations:
        raise InputError(
            "fmpy is not installed, which carries the FMI headers; install tribofmu with its dependencies"
        )
    folder = Path(next(iter(found.submodule_search_locations))) / "c-code"
    names = ("fmi2FunctionTypes.h", "fmi2Functions.h", "fmi2TypesPlatform.h")
    return {name: (folder / name).read_text(encoding="utf-8") for name in names}


def build(
    sources: Mapping[str, str], main: str, identifier: str, platforms: Sequence[str] | None = None
) -> dict[str, bytes]:
    """Compile the sources into one shared library a platform.

    Parameters
    ----------
    sources : mapping of str to str
        File name to text: the C files and all headers.
    main : str
        The file to compile.
    identifier : str
        Name of the libraries.
    platforms : sequence of str, optional
        Keys of `PLATFORMS`; this machine alone by default.

    Returns
    -------
    dict of str to bytes
        Path inside `binaries/` to content; equal input gives equal bytes.

    Raises
    ------
    InputError
        Unknown platform, no compiler, or another platform than this machine's without Zig.
    """
    host, host_target, host_suffix = host_platform()
    wanted = list(dict.fromkeys(platforms)) if platforms else [host]
    zig, system = zig_command(), system_command()
    for name in wanted:
        if name != host and name not in PLATFORMS:
            raise unknown_name("platform", name, {host, *PLATFORMS})
        if zig is None and name != host:
            raise InputError(
                f"platform {name!r} needs the Zig compiler, which is not installed; allowed without it: {host!r} "
                "(install the extra: pip install 'tribofmu[cross]')"
            )
    if zig is None and system is None:
        raise InputError(
            "no C compiler: neither Zig (pip install 'tribofmu[cross]') nor cc, gcc or clang is installed; "
            "allowed without one: --target python"
        )
    binaries = {}
    with tempfile.TemporaryDirectory(prefix="tribofmu-build-") as folder:
        for name, text in sources.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        for name in wanted:
            target, suffix = (host_target, host_suffix) if name == host else PLATFORMS[name]
            library = f"{identifier}{suffix}"
            command = [*zig, "-target", target] if zig is not None else list(system or ())
            _compile([*command, *_flags(target), main, "-o", library, "-lm"], folder)
            binaries[f"{name}/{library}"] = (Path(folder) / library).read_bytes()
    return binaries


def _flags(target: str) -> list[str]:
    flags = list(_FLAGS)
    if "linux" in target:
        flags.append("-Wl,--build-id=none")
    if "windows" in target:
        flags.remove("-fPIC")
    if "macos" in target:
        flags.remove("-s")
    return flags


def _compile(command: list[str], folder: str) -> None:
    environment = dict(os.environ)
    if not _writable_home():
        environment.setdefault(
            "ZIG_GLOBAL_CACHE_DIR", str(Path(tempfile.gettempdir()) / "tribofmu-zig-cache")
        )
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"the C compiler failed ({' '.join(command[:4])} ...):\n{done.stderr[-2000:]}")


def _writable_home() -> bool:
    home = Path(os.environ.get("XDG_CACHE_HOME", Path.home()))
    return os.access(home, os.W_OK)
