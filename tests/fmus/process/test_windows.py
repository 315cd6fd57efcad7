"""The front on Windows, under Wine: a stand-in in C answers, as there is no Python for Windows here."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from importlib.util import find_spec
from pathlib import Path

import pytest

from fmus import pack_twin
from fmus.archive.content import read_description
from fmus.native.compile import fmi_headers

HERE = Path(__file__).parent
WINE = shutil.which("wine64") or shutil.which("wine") or shutil.which("/usr/lib/wine/wine64")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if WINE is None:
        pytest.skip("Wine is not installed: libraries for Windows are compiled here, but not run")
    if find_spec("ziglang") is None:
        pytest.skip("the Zig compiler (extra [cross]) is missing")
    place = tmp_path_factory.mktemp("windows")
    fmu = pack_twin(place / "twin.fmu", target="process", platforms=["win64"])
    with zipfile.ZipFile(fmu) as archive:
        (place / "twin.dll").write_bytes(archive.read("binaries/win64/twin_sct.dll"))
    for name, text in fmi_headers().items():
        (place / name).write_text(text, encoding="utf-8")
    zig = [
        sys.executable,
        "-m",
        "ziglang",
        "cc",
        "-target",
        "x86_64-windows-gnu",
        "-std=c99",
        "-I",
        str(place),
    ]
    for source, program in (("stand_in_windows.c", "python.exe"), ("simulator_windows.c", "simulator.exe")):
        command = [*zig, "-Wall", "-Wextra", "-Werror", str(HERE / source), "-o", str(place / program)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
    return place


@pytest.mark.parametrize(
    ("mode", "python", "expected"),
    [
        ("good", "python.exe", ["step 0 2", "step 0 3", "step 0 4", "freed"]),
        ("good", None, ["step 0 2", "step 0 3", "step 0 4", "freed"]),
        ("flood", "python.exe", ["step 0 2", "step 0 3", "step 0 4", "freed"]),
        ("dies", "python.exe", ["has ended with exit code 9; its last lines: Traceback |boom", "step 3 1"]),
        ("hang", "python.exe", ["has not answered within 2 s and was ended", "step 3 1"]),
        ("good", "nothing.exe", ["nothing.exe cannot be started (no such file); set TRIBOFMU_PYTHON"]),
    ],
)
def test_front_on_windows(folder: Path, mode: str, python: str | None, expected: list[str]) -> None:
    environment = {
        **os.environ,
        "WINEPREFIX": str(folder / "wine"),
        "WINEDEBUG": "-all",
        "WINEPATH": "Z:" + str(folder).replace("/", "\\"),
        "STAND_IN": mode,
        "PYTHONHOME": "C:\\nowhere",
        "TRIBOFMU_TIMEOUT": "2" if mode == "hang" else "120",
    }
    environment.pop("TRIBOFMU_PYTHON", None)
    if python:
        environment["TRIBOFMU_PYTHON"] = f"Z:{folder}\\{python}".replace("/", "\\")
    guid = read_description(folder / "twin.fmu").get("guid", "")
    command = [str(WINE), "simulator.exe", "twin.dll", guid]
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300, check=False
    )
    lines = iter(done.stdout.splitlines())
    for words in expected:  # in this order
        assert any(words in line for line in lines), done.stdout + done.stderr
