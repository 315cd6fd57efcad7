"""Native FMUs for every platform: folders, sizes, what the libraries need and offer, equal bytes on a rebuild."""

from __future__ import annotations

import hashlib
import itertools
import os
import re
import struct
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from fmus import check, pack
from fmus.archive.binaries import Binary, read_binaries
from fmus.native import compile as compiling
from fmus.native.platforms import ALIASES, PLATFORMS, host_platform, resolve, universal
from friction_models.common import InputError
from tests.fmus.graphs import BOX, graph_bytes, node, save

Binaries = dict[str, bytes]
FOLDERS = {
    "2.0": {
        "linux64": {"x86_64-linux"},
        "aarch64-linux": {"aarch64-linux"},
        "win64": {"x86_64-windows"},
        "darwin64": {"x86_64-darwin", "aarch64-darwin"},
    },
    "3.0": {name: {name} for name in PLATFORMS},
}
#: A network of 32 and 32 neurons; the universal file of FMI 2.0 holds two libraries.
LARGEST = 150_000


def network(folder: Path) -> Path:
    """Save a 32x32 tanh network."""
    rng = np.random.default_rng(1)
    sizes = [5, 32, 32, 1]
    nodes, constants, last = [], {}, "scaled"
    nodes.append(node("Mul", "loads scale", "scaled"))
    constants["scale"] = np.array([1 / 500.0, 1 / 400.0, 1 / 2750.0, 1 / 60.0, 1 / 20.0])
    for k, (a, b) in enumerate(itertools.pairwise(sizes)):
        constants |= {f"w{k}": rng.normal(size=(a, b)) / np.sqrt(a), f"b{k}": rng.normal(size=b) * 0.1}
        nodes.append(node("Gemm", f"{last} w{k} b{k}", f"h{k}"))
        last = f"t{k}"
        nodes.append(node("Tanh", f"h{k}", last) if k < 2 else node("Abs", f"h{k}", "mu"))
    metadata = {"domain": BOX, "model": {"family": "ffnn", "name": "32x32", "formula": ""}}
    return save(graph_bytes(nodes, constants, metadata=metadata), folder / "network.onnx")


@pytest.fixture(scope="module", params=["2.0", pytest.param("3.0", marks=pytest.mark.nightly)])
def everywhere(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    """One FMU a version with the libraries of all platforms."""
    if compiling.zig_command() is None:
        pytest.skip("the Zig compiler (extra [cross]) is not installed: other platforms cannot be built")
    folder = tmp_path_factory.mktemp("everywhere")
    return request.param, pack(network(folder), folder / "all.fmu", fmi=request.param, platforms=["all"])


def libraries(fmu: Path) -> Binaries:
    with zipfile.ZipFile(fmu) as archive:
        return {n: archive.read(n) for n in archive.namelist() if n.startswith("binaries/")}


def parts_of(fmu: Path) -> dict[str, Binary]:
    """Return the libraries by platform tuple."""
    return {p.platform: p for n, c in libraries(fmu).items() for p in read_binaries(c, n)}


def test_every_platform_is_in_its_folder(everywhere: tuple[str, Path]) -> None:
    fmi, fmu = everywhere
    found = {n.split("/")[1]: {p.platform for p in read_binaries(c, n)} for n, c in libraries(fmu).items()}
    assert found == FOLDERS[fmi]


def test_libraries_are_small_and_need_the_c_library_alone(everywhere: tuple[str, Path]) -> None:
    for name, part in parts_of(everywhere[1]).items():
        assert part.size <= LARGEST, name
        assert part.libraries, name
        assert part.foreign_libraries == (), name
        assert part.unresolved == (), name
        assert part.timestamp == 0
        if name == "x86_64-linux":
            assert part.glibc <= (2, 14)
        if name == "aarch64-linux":
            assert part.glibc <= (2, 17)  # the first glibc for this machine
        if part.system == "windows":
            assert set(part.imports.values()) <= {"ucrtbase.dll", "KERNEL32.dll"}


def test_libraries_offer_the_functions_of_fmi_alone(everywhere: tuple[str, Path]) -> None:
    fmi, fmu = everywhere
    offered = set()
    for name, part in parts_of(fmu).items():
        # Apple's linkers add two names of their own.
        own = {n for n in part.exports if n not in {"__dso_handle", "_mh_dylib_header"}}
        assert all(n.startswith(f"fmi{fmi[0]}") for n in own), name
        offered.add(frozenset(own))
    assert len(offered) == 1
    functions = offered.pop()
    assert {f"fmi{fmi[0]}DoStep", f"fmi{fmi[0]}GetDirectionalDerivative"} <= functions


def test_nothing_of_this_machine_is_in_the_libraries(everywhere: tuple[str, Path]) -> None:
    for name, content in libraries(everywhere[1]).items():
        for text in re.findall(rb"[\x20-\x7e]{6,}", content):
            assert not re.search(rb"tribofmu-build|/tmp|/home|/root|\.cache|\.c$|zig", text), (name, text)


@pytest.mark.usefixtures("built_anew")
def test_a_rebuild_gives_the_same_bytes(everywhere: tuple[str, Path], tmp_path: Path) -> None:
    fmi, fmu = everywhere
    again = pack(network(tmp_path), tmp_path / "again.fmu", fmi=fmi, platforms=[*reversed(PLATFORMS)])
    assert again.read_bytes() == fmu.read_bytes()


def test_check_tells_what_every_library_is(everywhere: tuple[str, Path]) -> None:
    report = check(everywhere[1])
    if host_platform().name not in PLATFORMS:
        pytest.skip(f"no library for this machine ({host_platform().name})")
    assert report.ok, str(report)
    lines = [f.text for f in report.findings if f.group == "platforms"]
    assert len(lines) == 6  # five libraries and the summary
    assert all("and nothing else" in line for line in lines[:5])


def test_a_universal_file_keeps_its_parts_and_their_signature(everywhere: tuple[str, Path]) -> None:
    fmi, fmu = everywhere
    if fmi != "2.0":
        pytest.skip("FMI 3.0 has a folder for each kind of Mac")
    content = next(c for n, c in libraries(fmu).items() if "/darwin64/" in n)
    magic, count = struct.unpack_from(">2I", content)
    assert (magic, count) == (0xCAFEBABE, 2)
    for k in range(count):
        machine, _, start, size, alignment = struct.unpack_from(">5I", content, 8 + 20 * k)
        assert start % (1 << alignment) == 0
        part = content[start : start + size]
        assert struct.unpack_from("<2I", part) == (0xFEEDFACF, machine)
        if machine == 0x0100000C:
            assert signature_fits(part)
    assert start + size == len(content)


def signature_fits(part: bytes) -> bool:
    """Whether the pages of a Mach-O file have the hashes of its ad-hoc signature (Apple's cs_blobs.h)."""
    count = struct.unpack_from("<I", part, 16)[0]
    at = 32
    for _ in range(count):
        command, size = struct.unpack_from("<2I", part, at)
        if command == 0x1D:  # LC_CODE_SIGNATURE
            start = struct.unpack_from("<I", part, at + 8)[0]
            break
        at += size
    else:
        return False
    magic, _, blobs = struct.unpack_from(">3I", part, start)
    offsets = [struct.unpack_from(">2I", part, start + 12 + 8 * k) for k in range(blobs)]
    directory = start + next(o for kind, o in offsets if kind == 0)
    flags, hashes = struct.unpack_from(">2I", part, directory + 12)
    slots, limit = struct.unpack_from(">2I", part, directory + 28)
    length, kind, _, page = struct.unpack_from("4B", part, directory + 36)
    pages = range(0, limit, 1 << page)
    found = [hashlib.sha256(part[a : min(a + (1 << page), limit)]).digest() for a in pages]
    first = directory + hashes
    told = [part[first + k * length : first + (k + 1) * length] for k in range(slots)]
    return magic == 0xFADE0CC0 and bool(flags & 2) and kind == 2 and length == 32 and found == told


def test_names_of_platforms() -> None:
    assert {p.folder("3.0"): {name} for name, p in PLATFORMS.items()} == FOLDERS["3.0"]
    assert [p.name for p in resolve(["all"])] == list(PLATFORMS)
    assert [p.name for p in resolve(["win64", "linux64"])] == ["x86_64-linux", "x86_64-windows"]
    assert resolve(["macos"]) == resolve(["aarch64-darwin", "x86_64-darwin", "darwin64"])
    assert resolve(None) == resolve([]) == resolve("host") == [host_platform()]
    for name, tuples in ALIASES.items():
        assert [p.name for p in resolve([name.upper()])] == [n for n in PLATFORMS if n in tuples]
    with pytest.raises(InputError, match=r"unknown platform 'win46'.*did you mean 'win64'"):
        resolve(["win46"])


@pytest.mark.parametrize(
    ("system", "machine", "name"),
    [
        ("linux", "x86_64", "x86_64-linux"),
        ("linux", "aarch64", "aarch64-linux"),
        ("linux", "riscv64", "riscv64-linux"),
        ("win32", "AMD64", "x86_64-windows"),
        ("darwin", "arm64", "aarch64-darwin"),
    ],
)
def test_this_machine_by_its_name(
    system: str, machine: str, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.platform", system)
    monkeypatch.setattr("platform.machine", lambda: machine)
    assert host_platform().name == name
    assert host_platform().folder("3.0") == name


def test_parts_that_make_no_universal_file() -> None:
    thin = struct.pack("<3I", 0xFEEDFACF, 0x01000007, 3) + bytes(30)
    with pytest.raises(InputError, match="not a 64-bit Mach-O"):
        universal([thin, b"\x7fELF" + bytes(60)])
    with pytest.raises(InputError, match="two parts are for one machine"):
        universal([thin, thin])


def test_a_compiler_that_fails_says_so(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="the C compiler failed"):
        compiling.build({"m.c": "int f(void) { return missing; }"}, "m.c", "m")


def test_the_cache_of_the_compiler_without_a_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the folder for temporary files, and only where nobody else can write to it."""
    compiling._temporary_cache.cache_clear()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr("getpass.getuser", lambda: "somebody")
    usual = tmp_path / "tribofmu-zig-cache-somebody"
    assert compiling._temporary_cache() == str(usual)
    assert usual.stat().st_mode & 0o022 == 0
    compiling._temporary_cache.cache_clear()
    if os.name == "posix":
        usual.chmod(0o777)
        assert compiling._temporary_cache() != str(usual)
    compiling._temporary_cache.cache_clear()


@pytest.mark.parametrize("home", [None, "", "nowhere"])
def test_the_compiler_is_given_a_cache_where_the_environment_names_no_home(
    home: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("XDG_CACHE_HOME", "HOME", "LOCALAPPDATA", "ZIG_GLOBAL_CACHE_DIR"):
        monkeypatch.delenv(name, raising=False)
        if home is not None and name in {"HOME", "LOCALAPPDATA"}:
            monkeypatch.setenv(name, home)
    monkeypatch.setattr(compiling, "_temporary_cache", lambda: str(tmp_path))
    told = tmp_path / "told"
    code = f"import os; open({str(told)!r}, 'w').write(os.environ['ZIG_GLOBAL_CACHE_DIR'])"
    compiling._run([sys.executable, "-c", code], tmp_path)
    assert told.read_text() == str(tmp_path)
