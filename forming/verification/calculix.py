"""Compression of a cylinder or a ring in CalculiX, an independent program; numbers of an earlier run where it is missing.

Half the height is modelled with quadratic elements (CAX8R; linear CAX4 lock) under an all but rigid platen.
Contact holds at the nodes: over whole faces the corner of a folding bore sank into the platen by up to 0.15 mm,
and the bore came out wrong by up to 3 % of its diameter. The program computes a wedge of 2 degrees, so its
reaction force counts 180 times.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..fe.mesh.shape import FloatArray
from .case import FROZEN_RATE, Row, published_flow_stress

#: A run takes 2 - 20 s; one that takes longer than this is given up [s].
TIME_LIMIT = 180.0
WEDGES = 180.0
#: Gap between billet and platen at the start, height of the platen [mm].
GAP, PLATEN = 1e-4, 3.0
PLATEN_ELEMENTS = 20
#: The earlier run: its numbers are kept for machines without CalculiX.
KEPT_VERSION, KEPT_DAY = "2.20", "2026-11-21"


class CalculixError(Exception):
    """CalculiX did not run to its end."""


@dataclass(frozen=True)
class Compression:
    """Input of a CalculiX run."""

    #: Radii and height of the billet [mm]; inner 0: a cylinder.
    outer: float
    inner: float
    height: float
    mu: float
    #: Elements across the wall and over half the height.
    columns: int
    rows: int
    #: Of the height.
    reduction: float = 0.5
    #: Stiffness of sticking contact [MPa/mm].
    stick: float = 2e4


@dataclass(frozen=True)
class CompressionResult:
    """Force at the end [kN], bore in the middle [mm] (NaN for a cylinder), version.

    `history` has one row an increment: reduction of the height, bore of equal volume [mm]; none for a cylinder.
    """

    force: float
    bore_middle: float
    version: str
    history: FloatArray

    def bore_at(self, reduction: float) -> float:
        """Return the bore of equal volume at a reduction of the height [mm]."""
        return float(np.interp(reduction, *self.history.T))


def executable() -> str | None:
    """Return the path of ``ccx``, or None where it is not installed."""
    return shutil.which("ccx")


def version(program: str) -> str:
    """Return the version of the program, or an empty string."""
    try:
        answer = subprocess.run([program, "-v"], capture_output=True, text=True, timeout=20.0, check=False)
    except subprocess.TimeoutExpired:
        # A machine that is busy: the run has a limit of its own.
        return ""
    found = re.search(r"Version\s+(\S+)", answer.stdout)
    return found.group(1) if found else ""


def compress(setup: Compression) -> CompressionResult:
    """Run CalculiX in a folder of its own.

    Raises CalculixError: not installed, stopped before the end, or slower than the time limit.
    """
    program = executable()
    if program is None:
        raise CalculixError("CalculiX (ccx) is not installed; Debian package calculix-ccx")
    with tempfile.TemporaryDirectory(prefix="ccx-") as folder:
        (Path(folder) / "run.inp").write_text(input_deck(setup), encoding="ascii")
        try:
            subprocess.run(
                [program, "run"],
                cwd=folder,
                env={**os.environ, "OMP_NUM_THREADS": "1"},
                capture_output=True,
                timeout=TIME_LIMIT,
                check=False,
            )
        except subprocess.TimeoutExpired:
            raise CalculixError(f"CalculiX took longer than {TIME_LIMIT:g} s") from None
        results = Path(folder) / "run.dat"
        text = results.read_text(encoding="ascii", errors="replace") if results.exists() else ""
    return _read(setup, text, version(program))


def input_deck(setup: Compression) -> str:
    """Return the input of CalculiX."""
    lines = [*_nodes(setup), *_elements(setup), *_sets(setup)]
    lines += ["*MATERIAL,NAME=STEEL", "*ELASTIC", "210000.,0.3", "*PLASTIC"]
    for strain in [0.0, *np.geomspace(2e-3, 3.0, 40)]:
        stress = float(published_flow_stress(strain, 20.0, FROZEN_RATE))
        lines.append(f"{stress:.3f},{strain:.6g}")
    lines += [
        "*MATERIAL,NAME=RIGID",
        "*ELASTIC",
        "2100000.,0.3",
        "*SOLID SECTION,ELSET=BILLET,MATERIAL=STEEL",
        "*SOLID SECTION,ELSET=PLATEN,MATERIAL=RIGID",
        "*SURFACE INTERACTION,NAME=TOUCH",
        "*SURFACE BEHAVIOR,PRESSURE-OVERCLOSURE=LINEAR",
        "2.E5",
        "*FRICTION",
        f"{setup.mu:g},{setup.stick:g}",
        "*CONTACT PAIR,INTERACTION=TOUCH,TYPE=NODE TO SURFACE",
        "TOP,FACE",
        "*BOUNDARY",
        "MIDDLE,2,2",
        "PLATENNODES,1,1",
    ]
    if setup.inner == 0.0:
        lines.append("AXIS,1,1")
    travel = 0.5 * setup.reduction * setup.height + GAP
    lines += [
        "*STEP,NLGEOM,INC=2000",
        "*STATIC",
        "0.01,1.,1.e-6,0.02",
        "*BOUNDARY",
        f"PLATENNODES,2,2,{-travel:g}",
        "*NODE PRINT,NSET=PLATENNODES,TOTALS=ONLY,FREQUENCY=1",
        "RF",
        "*NODE PRINT,NSET=BORE,FREQUENCY=1",
        "U",
        "*END STEP",
    ]
    return "\n".join(lines) + "\n"


def _number(setup: Compression, i: int, j: int) -> int:
    """Return the number of the billet node in column i, row j of the grid of half elements."""
    return 1 + j * (2 * setup.columns + 1) + i


def _grid(setup: Compression) -> list[tuple[int, float, float]]:
    """Return number, r, z of the billet nodes; the middle of an element has none."""
    nodes = []
    for j in range(2 * setup.rows + 1):
        for i in range(2 * setup.columns + 1):
            if i % 2 == 0 or j % 2 == 0:
                r = setup.inner + (setup.outer - setup.inner) * i / (2 * setup.columns)
                nodes.append((_number(setup, i, j), r, 0.5 * setup.height * j / (2 * setup.rows)))
    return nodes


def _first_platen_node(setup: Compression) -> int:
    return _number(setup, 0, 2 * setup.rows + 1)


def _nodes(setup: Compression) -> list[str]:
    lines = ["*NODE"]
    lines += [f"{n},{r:.8g},{z:.8g},0." for n, r, z in _grid(setup)]
    lines.append("*NODE,NSET=PLATENNODES")
    first, width = _first_platen_node(setup), 3.0 * setup.outer
    for j in range(2):
        for i in range(PLATEN_ELEMENTS + 1):
            n = first + j * (PLATEN_ELEMENTS + 1) + i
            z = 0.5 * setup.height + GAP + j * PLATEN
            lines.append(f"{n},{width * i / PLATEN_ELEMENTS:.8g},{z:.8g},0.")
    return lines


def _elements(setup: Compression) -> list[str]:
    around = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
    lines = ["*ELEMENT,TYPE=CAX8R,ELSET=BILLET"]
    for j in range(setup.rows):
        for i in range(setup.columns):
            corners = ",".join(str(_number(setup, 2 * i + p, 2 * j + q)) for p, q in around)
            lines.append(f"{1 + j * setup.columns + i},{corners}")
    lines.append("*ELEMENT,TYPE=CAX4,ELSET=PLATEN")
    first, count = _first_platen_node(setup), PLATEN_ELEMENTS
    for i in range(count):
        a = first + i
        lines.append(f"{_platen_element(setup, i)},{a},{a + 1},{a + count + 2},{a + count + 1}")
    return lines


def _platen_element(setup: Compression, i: int) -> int:
    return 1 + setup.columns * setup.rows + i


def _sets(setup: Compression) -> list[str]:
    """Return the contact surfaces (top and the upper part of the sides, which may fold) and the node sets."""
    columns, rows = setup.columns, setup.rows
    sides = range(rows - max(2, rows // 2), rows)
    lines = ["*SURFACE,NAME=TOP"]
    lines += [f"{(rows - 1) * columns + i + 1},S3" for i in range(columns)]
    lines += [f"{(j + 1) * columns},S2" for j in sides]
    if setup.inner > 0.0:
        lines += [f"{j * columns + 1},S4" for j in sides]
    lines.append("*SURFACE,NAME=FACE")
    lines += [f"{_platen_element(setup, i)},S1" for i in range(PLATEN_ELEMENTS)]
    lines.append("*NSET,NSET=AXIS")
    lines += [str(_number(setup, 0, j)) for j in range(2 * rows + 1)]
    lines.append("*NSET,NSET=BORE")
    lines += [str(n) for n in _bore_nodes(setup)]
    lines.append("*NSET,NSET=MIDDLE")
    lines += [str(_number(setup, i, 0)) for i in range(2 * columns + 1)]
    return lines


def _bore_nodes(setup: Compression) -> list[int]:
    """Return the nodes of the innermost side, from the middle of the height upward."""
    return [_number(setup, 0, j) for j in range(2 * setup.rows + 1)]


def _read(setup: Compression, text: str, program_version: str) -> CompressionResult:
    """Read the last force and the bore of every increment from the result file.

    Raises CalculixError: the last increment is not at the end of the step.
    """
    lines = text.splitlines()
    forces = [k for k, line in enumerate(lines) if "total force" in line]
    blocks = [k for k, line in enumerate(lines) if "displacements" in line]
    reached = float(lines[forces[-1]].split()[-1]) if forces else 0.0
    if not blocks or reached < 1.0 - 1e-6:
        raise CalculixError(f"CalculiX stopped at {100.0 * reached:.1f} % of the stroke")
    force = -float(lines[forces[-1] + 2].split()[1]) * WEDGES * 1e-3
    if setup.inner == 0.0:
        return CompressionResult(force, np.nan, program_version, np.empty((0, 2)))
    nodes = _bore_nodes(setup)
    start = {n: np.array([r, z]) for n, r, z in _grid(setup)}
    history = [(0.0, setup.inner)]
    for k in blocks:
        rows = [line.split() for line in lines[k + 2 : k + 2 + len(nodes)]]
        moved = {int(row[0]): np.array([float(row[1]), float(row[2])]) for row in rows}
        profile = np.array([start[n] + moved[n] for n in nodes])
        travel = float(lines[k].split()[-1]) * (0.5 * setup.reduction * setup.height + GAP) - GAP
        half = 0.5 * setup.height - max(travel, 0.0)
        levels = half * (np.arange(200) + 0.5) / 200.0
        radius = np.interp(levels, profile[:, 1], profile[:, 0])
        history.append((1.0 - 2.0 * half / setup.height, float(np.sqrt((radius**2).mean()))))
    return CompressionResult(force, float(profile[0, 0]), program_version, np.array(history))


@dataclass(frozen=True)
class CalculixNumbers:
    """Numbers to compare with; `reason` says why CalculiX was not run, or is empty."""

    values: Mapping[str, float]
    source: str
    reason: str = ""

    def row(
        self, quantity: str, unit: str, key: str, ours: float, tolerance: float, absolute: bool = False
    ) -> Row:
        """Return the row that compares `ours` with one of the numbers."""
        row = Row(quantity, unit, self.values[key], self.source, ours, tolerance, absolute)
        return replace(row, standing="skipped", note=self.reason) if self.reason else row


def bore_key(reduction: int) -> str:
    """Return the name of the decrease of the bore [%] at a reduction of the height [%]."""
    return f"bore_decrease_{reduction}"


def calculix_numbers(setup: Compression, kept: Mapping[str, float]) -> CalculixNumbers:
    """Run CalculiX; where it is missing, return the kept numbers and the reason."""
    try:
        result = compress(setup)
    except CalculixError as error:
        source = f"CalculiX {KEPT_VERSION} CAX8R, value kept from {KEPT_DAY}"
        return CalculixNumbers(kept, source, str(error))
    values = {"force": result.force, "bore_middle": result.bore_middle}
    if setup.inner:
        values |= {
            bore_key(r): 100.0 * (1.0 - result.bore_at(0.01 * r) / setup.inner)
            for r in range(10, round(100.0 * setup.reduction) + 1, 10)
        }
    return CalculixNumbers(values, f"CalculiX {result.version} CAX8R, run beside")
