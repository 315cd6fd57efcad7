"""A forming process with friction in the clients: one SSP, made for hosts without Python."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fmus import pack_forming
from friction_models.loads import FloatArray
from orchestrator import Master, System
from orchestrator.cosim.ready_made import STEP, extrusion_system

from .children.common import Job
from .ecos_command import run_ecos
from .running import Outcome, run_child, version
from .subjects import Subjects

# Markers are close enough for some to touch the die in the first steps, so that the order of coupling matters.
MARKERS, INCREMENTS, SPEED = 80, 10, 5.0


@dataclass
class Extrusion:
    """Forward rod extrusion and friction with memory at its markers.

    Attributes
    ----------
    ssp, fmus : Path, dict of str to str
        The archive, and its FMUs by component.
    folder : Path
        Where the clients may write.
    """

    ssp: Path
    fmus: dict[str, str]
    folder: Path

    @property
    def step(self) -> float:
        return STEP / SPEED

    @classmethod
    def made(cls, subjects: Subjects, folder: Path) -> Extrusion:
        """Pack the FMUs and write the SSP. The solver is a process of its own, started by a native library."""
        folder.mkdir(parents=True, exist_ok=True)
        forming = pack_forming(
            folder / "forming.fmu", n_points=MARKERS, mesh_size=0.8, target="process", python=sys.executable
        )
        friction = subjects.friction("memory", points=MARKERS)
        system = extrusion_system(friction, forming, speed=SPEED, stroke=STEP * INCREMENTS)
        system.record = ["forming.force"]
        fmus = {"forming": str(forming), "friction": str(friction)}
        return cls(system.export(folder / "extrusion.ssp"), fmus, folder)

    def ours(self, mode: str = "jacobi") -> FloatArray:
        """Return the force after each increment by our master, which reads the same SSP [kN]."""
        run = Master(System.load(self.ssp), mode).run(self.folder / mode)
        return run["forming.force"][1:]

    def theirs(self, client: str) -> FloatArray:
        """Return the same by `libcosim`, `ecos_python` or `ecos`, the command line (six decimals)."""
        if client == "ecos":
            place = self.folder / "ecos"
            place.mkdir()
            outcome = run_ecos(self.ssp, ["forming::force"], place, self.step, INCREMENTS)
        else:
            work: Job = {
                "ssp": str(self.ssp),
                "fmus": self.fmus,
                "outputs": ["forming.force"],
                "step": self.step,
                "steps": INCREMENTS,
            }
            outcome = run_child(client, work, self.folder / client)
        return _column(outcome)


def _column(outcome: Outcome) -> FloatArray:
    assert outcome.result is not None, outcome.seen
    return np.array(outcome.result["values"])[:INCREMENTS, 0]


def compare_forming(subjects: Subjects, folder: Path) -> list[tuple[str, str]]:
    """Return rows: what was compared, and the largest difference relative to the largest force."""
    extrusion = Extrusion.made(subjects, folder)
    mine = extrusion.ours()
    rows = []
    for client, wanted, label in (
        ("libcosim", ("libcosimpy",), "libcosim"),
        ("ecos_python", ("ecospy", "tbb"), "ecos"),
        ("ecos", ("ecospy", "tbb"), "the ecos command line (force printed with six decimals)"),
    ):
        if all(version(name) for name in wanted):
            found = extrusion.theirs(client)
            worst = float(np.max(np.abs(found - mine)) / mine.max())
            rows.append((f"force of a forward rod extrusion: `jacobi` and {label}", f"{worst:.1e}"))
    one = extrusion.ours("gauss_seidel")
    rows.append(
        (
            "force of a forward rod extrusion: `jacobi` and `gauss_seidel`",
            f"{float(np.max(np.abs(one - mine)) / mine.max()):.1e}",
        )
    )
    return rows
