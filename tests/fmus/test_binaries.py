"""Shared libraries read without loading them, also damaged ones."""

from __future__ import annotations

import importlib.util
import random
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from fmus.archive.binaries import read_binaries
from fmus.native import compile as compiling
from fmus.native.platforms import PLATFORMS
from friction_models.common import InputError

SOURCE = """
#include <math.h>
#include <stdlib.h>
#include <string.h>
#if defined _WIN32
__declspec(dllexport)
#else
__attribute__((visibility("default")))
#endif
double shown(double x, char *text);
double hidden(double x, double *room);
double hidden(double x, double *room) { return pow(x, room[0]); }
double shown(double x, char *text)
{
    double *room = calloc(strlen(text), sizeof *room), y = 0.0;
    if (room) y = hidden(x, memset(room, text[0], 1)) + x;
    free(room);
    return y;
}
"""


#: One of each format of files by day.
NIGHTLY = ("aarch64-linux", "x86_64-darwin")
CASES = [pytest.param(p, marks=pytest.mark.nightly if p in NIGHTLY else ()) for p in PLATFORMS]


@pytest.fixture(scope="module")
def built() -> Callable[[str], bytes]:
    if compiling.zig_command() is None:
        pytest.skip("the Zig compiler (extra [cross]) is not installed: other platforms cannot be built")

    @cache
    def library(platform: str) -> bytes:
        (content,) = compiling.build({"m.c": SOURCE}, "m.c", "m", [platform], "3.0").values()
        return content

    return library


@pytest.mark.parametrize("platform", CASES)
def test_what_a_library_is_needs_and_offers(platform: str, built: Callable[[str], bytes]) -> None:
    (part,) = read_binaries(built(platform), "m")
    assert part.platform == platform
    assert part.size == len(built(platform))
    assert "shown" in part.exports
    assert "hidden" not in part.exports
    assert {"calloc", "free", "strlen", "pow"} <= set(part.imports)
    assert part.foreign_libraries == part.unresolved == ()
    if part.system == "linux":
        assert set(part.libraries) == {"libc.so.6", "libm.so.6"}
        assert part.imports["calloc"].startswith("GLIBC_2.")
        assert (2, 2) <= part.glibc <= (2, 17)
    else:
        assert part.glibc == ()
    assert part.signed == (platform == "aarch64-darwin")


def test_what_is_missing_is_named() -> None:
    """A Python FMU's library: symbols that only Python has, and libraries beyond the C library."""
    place = importlib.util.find_spec("pythonfmu")
    assert place is not None
    assert place.submodule_search_locations
    folder = Path(next(iter(place.submodule_search_locations))) / "resources" / "binaries"
    (linux,) = read_binaries(next((folder / "linux64").glob("*.so")).read_bytes(), "linux")
    assert "PyObject_Call" in linux.unresolved
    assert "libstdc++.so.6" in linux.foreign_libraries
    (windows,) = read_binaries(next((folder / "win64").glob("*.dll")).read_bytes(), "windows")
    assert "python3.dll" in windows.foreign_libraries
    assert windows.imports["PyObject_Call"] == "python3.dll"


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "not a shared library"),
        (b"#!/bin/sh\n", "allowed: ELF, PE or Mach-O"),
        (b"MZ" + bytes(500), "damaged"),
        (b"\xca\xfe\xba\xbe" + bytes(100), "holds no shared library"),
    ],
)
def test_other_files_are_refused(content: bytes, words: str) -> None:
    with pytest.raises(InputError, match=rf"^x\.so.*{words}"):
        read_binaries(content, "x.so")


@pytest.mark.parametrize("platform", CASES)
def test_damaged_libraries_end_in_one_sentence(platform: str, built: Callable[[str], bytes]) -> None:
    good = built(platform)
    rng = random.Random(4)
    for _ in range(100):
        bad = bytearray(good[: rng.choice([len(good), rng.randrange(4, len(good))])])
        for _ in range(rng.choice([1, 5, 40])):
            bad[rng.randrange(4, min(len(bad), 3000))] = rng.choice([0, 127, 128, 255])
        try:
            read_binaries(bytes(bad), "bad.so")
        except InputError as error:
            assert "bad.so" in str(error)
            assert "\n" not in str(error)
