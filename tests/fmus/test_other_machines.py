"""Libraries for other machines, run by emulators where these are installed: mu is that of this machine."""

from __future__ import annotations

import os
import shutil
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest

from fmus import pack
from fmus.native import compile as compiling
from fmus.unpacked import UnpackedFmu
from tests.fmus.graphs import inside, random_loads, runtime
from tests.fmus.test_platforms import network

HOST = Path(__file__).parent / "other_machine.c"
WINDOWS = Path(compiling.__file__).parent / "windows.c"


def wine() -> list[str]:
    for name in ("wine64", "wine", "/usr/lib/wine/wine64"):
        if shutil.which(name):
            return [name]
    pytest.skip("wine is not installed: the Windows library cannot be run here")


def qemu() -> list[str]:
    if not shutil.which("qemu-aarch64") or not Path("/usr/aarch64-linux-gnu/lib").is_dir():
        pytest.skip("qemu-aarch64 with an ARM C library is not installed: the ARM library cannot be run here")
    return ["qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"]


@pytest.mark.parametrize("platform", ["aarch64-linux", "x86_64-windows"])
def test_other_machines_compute_the_same(platform: str, tmp_path: Path) -> None:
    zig = compiling.zig_command()
    if zig is None:
        pytest.skip("the Zig compiler (extra [cross]) is not installed: other platforms cannot be built")
    emulator = wine() if platform == "x86_64-windows" else qemu()
    model = network(tmp_path)
    fmu = pack(model, tmp_path / "other.fmu", platforms=[platform])
    with zipfile.ZipFile(fmu) as archive:
        name = next(n for n in archive.namelist() if n.startswith("binaries/"))
        (tmp_path / Path(name).name).write_bytes(archive.read(name))
    for header, text in compiling.fmi_headers("2.0").items():
        (tmp_path / header).write_text(text)
    loads = random_loads(40, seed=3)
    rows = ",".join("{" + ",".join(repr(float(x)) for x in row) + "}" for row in loads)
    guid = UnpackedFmu(fmu).description.guid
    (tmp_path / "host.c").write_text(
        f'#define LIBRARY "./{Path(name).name}"\n#define GUID "{guid}"\n#define POINTS {rows}\n'
        + HOST.read_text()
    )
    if platform == "aarch64-linux":
        flags = [["host.c", "-O1", "-o", "host", "-ldl"]]
        target = "aarch64-linux-gnu.2.17"
    else:
        shutil.copy(WINDOWS, tmp_path)
        target = "x86_64-windows-gnu"
        flags = [
            ["-c", "-O1", "host.c", "-o", "host.obj"],
            ["-c", "-O1", "-fno-builtin", "windows.c", "-o", "windows.obj"],
            [
                "-nostdlib",
                "host.obj",
                "windows.obj",
                "-Wl,--entry,start",
                "-lucrtbase",
                "-lkernel32",
                "-o",
                "host",
            ],
        ]
    for each in flags:
        subprocess.run([*zig, "-target", target, *each], cwd=tmp_path, check=True, capture_output=True)
    done = subprocess.run(
        [*emulator, "./host"],
        cwd=tmp_path,
        env={**os.environ, "WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all"},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    mu = np.array([float(line) for line in done.stdout.split()])
    np.testing.assert_allclose(mu, runtime(model.read_bytes(), inside(loads)), rtol=1e-12, atol=1e-14)
