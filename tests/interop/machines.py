"""Libraries of FMUs for other machines, run by an emulator or by wine through a small C host."""

from __future__ import annotations

import os
import shutil
import subprocess
import zipfile
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from fmus.native import compile as compiling
from fmus.native import platforms
from friction_models.loads import FloatArray

from .subjects import KINDS, Subjects, series

HOST = Path(__file__).parent / "other_machine.c"
WINDOWS = Path(compiling.__file__).parent / "windows.c"
#: The host's communication step [s].
HOST_STEP = 0.1


class CannotRun(RuntimeError):
    """Something that is needed is not installed here; the message says what."""


@dataclass(frozen=True)
class Machine:
    """A kind of machine and how programs for it run here.

    Attributes
    ----------
    label, name : str
        For people, for files.
    platform : str
        Of `pack`.
    target : str
        Of the Zig compiler.
    """

    label: str
    name: str
    platform: str
    target: str

    def runner(self) -> list[str]:
        """Return the command in front of the program.

        Raises
        ------
        CannotRun
            It is not installed.
        """
        if self.platform == "x86_64-windows":
            for name in ("wine64", "wine", "/usr/lib/wine/wine64"):
                if shutil.which(name):
                    return [name]
            raise CannotRun("wine is not installed")
        if self.platform == platforms.host_platform().name:
            return []
        root = Path("/usr/aarch64-linux-gnu")
        if shutil.which("qemu-aarch64") and (root / "lib").is_dir():
            return ["qemu-aarch64", "-L", str(root)]
        raise CannotRun("qemu-aarch64 with an ARM C library is not installed")

    def row(self, subjects: Subjects, folder: Path) -> tuple[str, ...]:
        """Return a row of the table: machine, runner, model, result, largest deviation."""
        model = KINDS[1]
        try:
            runner = self.runner()
            values = self.play(subjects, model, folder)
        except CannotRun as reason:
            return self.label, "", model, f"not run: {reason}", ""
        deviation = self.deviation(subjects, model, values)
        by = Path(runner[0]).name if runner else "this machine"
        return self.label, by, model, "agrees" if deviation <= 1e-12 else "other values", f"{deviation:.1e}"

    def deviation(self, subjects: Subjects, model: str, values: FloatArray) -> float:
        """Return the largest deviation of mu from the model's own, relative to mu."""
        expected = subjects.expected(model, series(), HOST_STEP)[:, 0]
        return float(np.max(np.abs(values - expected) / expected))

    def play(self, subjects: Subjects, model: str, folder: Path) -> FloatArray:
        """Build FMU and host for the machine, run them, return mu after each step, shape (steps,)."""
        runner, zig = self.runner(), compiling.zig_command()
        if zig is None:
            raise CannotRun("the Zig compiler (extra [cross]) is not installed")
        folder.mkdir(parents=True, exist_ok=True)
        fmu = subjects.friction(model, platforms=[self.platform])
        with zipfile.ZipFile(fmu) as archive:
            library = next(n for n in archive.namelist() if n.startswith("binaries/"))
            (folder / Path(library).name).write_bytes(archive.read(library))
            guid = ElementTree.fromstring(archive.read("modelDescription.xml")).get("guid")
        for header, text in compiling.fmi_headers("2.0").items():
            (folder / header).write_text(text, encoding="utf-8")
        rows = ",".join("{" + ",".join(repr(float(x)) for x in row) + "}" for row in series())
        text = f'#define LIBRARY "./{Path(library).name}"\n#define GUID "{guid}"\n#define POINTS {rows}\n'
        (folder / "host.c").write_text(text + HOST.read_text(encoding="utf-8"), encoding="utf-8")
        for arguments in self._builds(folder):
            command = [*zig, "-target", self.target, *arguments]
            subprocess.run(command, cwd=folder, check=True, capture_output=True, timeout=300)
        # Nothing of Python reaches the host.
        environment = {
            "PATH": "/usr/bin:/bin",
            "HOME": str(folder),
            "WINEPREFIX": str(folder / "wine"),
            "WINEDEBUG": "-all",
        }
        environment |= {k: os.environ[k] for k in ("TMPDIR",) if k in os.environ}
        done = subprocess.run(
            [*runner, "./host"], cwd=folder, env=environment, capture_output=True, timeout=300
        )
        if done.returncode:
            raise RuntimeError(
                f"the host ended with {done.returncode}: {done.stderr.decode('utf-8', 'replace')}"
            )
        return np.array([float(line) for line in done.stdout.split()])

    def _builds(self, folder: Path) -> list[list[str]]:
        if self.platform != "x86_64-windows":
            return [["host.c", "-O1", "-o", "host", "-ldl"]]
        shutil.copy(WINDOWS, folder)
        return [
            ["-c", "-O1", "host.c", "-o", "host.obj"],
            ["-c", "-O1", "-fno-builtin", "windows.c", "-o", "windows.obj"],
            ["-nostdlib", "host.obj", "windows.obj", "-Wl,--entry,start", "-lucrtbase", "-lkernel32", "-o", "host"],
        ]  # fmt: skip


MACHINES = (
    Machine("Linux x86-64", "linux", "x86_64-linux", "x86_64-linux-gnu.2.17"),
    Machine("Linux ARM (aarch64)", "arm", "aarch64-linux", "aarch64-linux-gnu.2.17"),
    Machine("Windows x86-64", "windows", "x86_64-windows", "x86_64-windows-gnu"),
)
