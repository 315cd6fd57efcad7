"""Simulators that no package index has: looked for on this machine, in the version that the cases were written for."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from functools import cached_property


@dataclass(frozen=True)
class Program:
    """A simulator that is a program.

    Attributes
    ----------
    name : str
        Of the executable.
    variable : str
        Environment variable that holds its path where it is not on PATH.
    wanted : str
        The version; a longer one that begins so is the same (builds after a release).
    source : str
        Where people get it.
    """

    name: str
    variable: str
    wanted: str
    source: str

    @cached_property
    def path(self) -> str | None:
        """Where it is, None when it is not here."""
        return shutil.which(os.environ.get(self.variable) or self.name)

    @cached_property
    def found(self) -> str | None:
        """The version that it says it has."""
        if self.path is None:
            return None
        try:
            said = subprocess.run([self.path, "--version"], capture_output=True, text=True, timeout=60).stdout
        except OSError:
            return None
        numbers = re.search(r"\d+\.\d+\.\d+(\.post\d+)?", said)
        return numbers and numbers[0]

    @property
    def version(self) -> str | None:
        """The version where it is the wanted one."""
        same = self.found is not None and re.match(re.escape(self.wanted) + r"(?!\d)", self.found)
        return self.found if same else None

    @property
    def missing(self) -> str:
        """Why it cannot be run."""
        if self.found:
            return f"{self.name} {self.found} (the cases are written for {self.wanted})"
        return f"{self.name} {self.wanted} (not on PATH, nor named by {self.variable})"


PROGRAMS = {
    program.name: program
    for program in (
        Program(
            "fmusim",
            "FMUSIM",
            "0.0.39",
            "among the releases of the Reference FMUs of the Modelica Association",
        ),
        Program("OMSimulator", "OMSIMULATOR", "3.0.0", "from OpenModelica"),
    )
}
