"""Curves of the attribution benchmark: true situations at finer meshes, fingerprints of the user's system; kept on disk.

Every solver run is made once and found again as long as the sources it depends on are the same; seeds redraw the
scatter of the repeats only.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from inspect import signature
from pathlib import Path

import numpy as np
import pandas as pd

from fmus import pack, pack_forming
from forming import BackwardCupExtrusion, ForwardRodExtrusion
from forming.materials.materials import steel_16MnCr5
from forming.press import PressLevel
from forming.processes.thermal_conditions import ThermalConditions
from friction_models import ConstantFriction
from friction_models.common import InputError, atomic_path
from friction_models.loads import FloatArray
from orchestrator.attribution.causes import MACHINE
from orchestrator.attribution.forming_system import FormingSystem
from orchestrator.attribution.sensitivities import Sensitivities, run_sensitivities
from orchestrator.cosim.ready_made import extrusion_system
from orchestrator.cosim.system import System
from sct_twin.virtual_lab.hidden_effects import HIDDEN, LawInput

from .data import sources

MU = 0.08
#: Process, tool temperature [degC], punch speed [mm/s].
LEVELS = (("fre", 20.0, 5.0), ("fre", 150.0, 100.0), ("bce", 20.0, 5.0))
STROKE = {"fre": 5.0, "bce": 3.0}
BILLET_LENGTH = {"fre": 20.0, "bce": 12.0}
N_POINTS = 30
#: Element sizes of the user's process [mm]: the first one carries the fingerprints, each one makes its own error.
USER_MESHES = (0.8, 0.7, 0.75, 0.85, 0.9)
#: Element sizes under the true curves [mm]; true causes are computed at the first one.
TRUE_MESHES = (0.45, 0.40, 0.50)
#: Elements of the cup over those of the rod.
CUP = 0.75
_SOLVERS: dict[str, Callable[..., ForwardRodExtrusion | BackwardCupExtrusion]] = {
    "fre": ForwardRodExtrusion,
    "bce": BackwardCupExtrusion,
}


@dataclass(frozen=True)
class Truth:
    """What is really different from the user's model.

    Attributes
    ----------
    cause : str
        Name of the cause as `attribute` calls it; empty: nothing is wrong.
    strength : float
        In the unit of `label`.
    label : str
        Cause and strength in words.
    """

    cause: str
    strength: float = 0.0
    label: str = "nothing is wrong"

    @property
    def of_the_press(self) -> bool:
        """Whether the curve without the cause shows it: no other solver run."""
        return self.cause in {c.name for c in MACHINE}


TRUTHS = (
    Truth(""),
    Truth("friction_level", 0.1, "friction +10 %"),
    Truth("friction_level", 0.2, "friction +20 %"),
    Truth("stribeck", 0.5, "`stribeck`, 0.015"),
    Truth("stribeck", 1.0, "`stribeck`, 0.03"),
    Truth("running_in", 1.0, "`running_in`"),
    Truth("flow_stress", 0.02, "flow stress +2 %"),
    Truth("flow_stress", 0.04, "flow stress +4 %"),
    Truth("billet_temperature", 40.0, "billet 40 K hotter"),
    Truth("heat_transfer", 1.0, "heat transfer doubled"),
    Truth("compliance", 5e-4, "compliance 5e-4 mm/kN"),
    Truth("compliance", 1e-3, "compliance 1e-3 mm/kN"),
    Truth("stroke_zero", 0.1, "zero of the stroke 0.1 mm"),
    Truth("force_gain", 0.02, "gain of the force +2 %"),
    Truth("force_gain", 0.04, "gain of the force +4 %"),
)


@dataclass
class Store:
    """Folder of the kept runs, and what is needed to make those that it lacks.

    Attributes
    ----------
    folder : Path
        Runs of other sources lie beside it.
    """

    folder: Path
    _found: dict[float, Sensitivities] = field(default_factory=dict)

    @classmethod
    def of(cls, kept: Path) -> Store:
        """Return the store of the present sources."""
        store = cls(kept / "attribution" / sources("forming", "fmus", "friction_models/effects"))
        store.folder.mkdir(parents=True, exist_ok=True)
        return store

    def true_curve(self, k: int, mesh: float, truth: Truth) -> tuple[FloatArray, FloatArray]:
        """Return stroke [mm] and force [kN] of level `k` without scatter, made at `mesh`."""
        own = Truth("") if truth.of_the_press else truth
        file = self.folder / f"true-{k}-{mesh:g}-{own.cause}-{own.strength:g}.npz"
        if not file.is_file():
            with atomic_path(file) as temporary, temporary.open("wb") as stream:
                np.savez(stream, curve=np.array(_solved(*LEVELS[k], mesh, own)))
        stroke, force = _read(file)
        if truth.cause == "force_gain":
            force = force * (1.0 + truth.strength)
        if truth.cause == "stroke_zero":
            stroke = stroke + truth.strength
        return stroke, force

    def sensitivities(self, mesh: float) -> Sensitivities:
        """Return what `attribute` computes for the user's system at an element size.

        The changes by the causes are those at the first of `USER_MESHES`; curves and other mesh are of `mesh`.
        """
        if mesh not in self._found:
            plants = [self._plant(kind, mesh) for kind in STROKE]
            pairs = [
                (next(p for p in plants if p.process == level.process), level) for level in long_levels()
            ]
            whole = mesh == USER_MESHES[0]
            wanted = None if whole else [c.name for c in MACHINE]
            found = run_sensitivities(plants, pairs, wanted, self.folder / "runs", jobs=1)
            if not whole:
                first = self.sensitivities(USER_MESHES[0])
                moved = {
                    key: [
                        replace(c, force=c.force - b.force + own.force)
                        for c, b, own in zip(curves, first.base, found.base, strict=True)
                    ]
                    for key, curves in first.moved.items()
                }
                found = replace(found, causes=first.causes, moved=moved)
            self._found[mesh] = found
        return self._found[mesh]

    def _plant(self, kind: str, mesh: float) -> FormingSystem:
        friction, forming = self.folder / "friction.fmu", self.folder / f"{kind}.fmu"
        if not friction.is_file():
            pack(ConstantFriction(MU), friction, nodes=30)
        if not forming.is_file():
            pack_forming(
                forming,
                process=kind,
                stroke=STROKE[kind],
                mesh_size=USER_MESHES[0],
                billet_length=BILLET_LENGTH[kind],
                n_points=N_POINTS,
            )
        system = extrusion_system(friction, forming, 5.0, STROKE[kind], name=kind, synthetic=True)
        content = system.model_dump(mode="json", exclude_none=True)
        content["components"]["forming"]["start"] = {"mesh_size": _size(kind, mesh)}
        return FormingSystem.of(System.from_dict(content, source=kind))


def long_levels() -> list[PressLevel]:
    """Return the levels with records longer than any run: the user's runs end where they end."""
    record = pd.DataFrame({"stroke": [0.0, 100.0], "force": [0.0, 1.0], "repeat": 1})
    return [
        PressLevel(kind, T, v, "made up", f"{kind}_{v:g}_{T:g}.csv", record, True) for kind, T, v in LEVELS
    ]


def _size(kind: str, mesh: float) -> float:
    return round(mesh * (CUP if kind == "bce" else 1.0), 6)


def _solved(kind: str, T: float, speed: float, mesh: float, truth: Truth) -> tuple[FloatArray, FloatArray]:
    """Return the curve of one solver run in a true situation."""
    steel = steel_16MnCr5()
    own: dict[str, float] = {}
    mu = MU
    if truth.cause == "friction_level":
        mu *= 1.0 + truth.strength
    elif truth.cause == "flow_stress":
        steel = replace(steel, A=steel.A * (1.0 + truth.strength))
    elif truth.cause == "billet_temperature":
        own["T_billet"] = 20.0 + truth.strength
    elif truth.cause == "heat_transfer":
        own["htc"] = signature(ThermalConditions).parameters["htc"].default * (1.0 + truth.strength)
    solver = _SOLVERS[kind](
        speed=speed,
        T_tool=T,
        material=steel,
        mesh_size=_size(kind, mesh),
        billet_length=BILLET_LENGTH[kind],
        n_points=N_POINTS,
        **own,
    )
    effect = HIDDEN.get(truth.cause)

    def friction(loads: FloatArray, t: float) -> FloatArray:
        if effect is None:
            return np.full(len(loads), mu)
        v_rel, T, sigma_n, sd, psi = loads[:, :5].T
        given = LawInput(v_rel, T, sigma_n, sd, psi, np.zeros(len(loads)), {})
        parameters = {**effect.parameters, "A": effect.parameters["A"] * truth.strength}
        return np.asarray(mu + effect.contribution(given, parameters))

    result = solver.run(friction, stroke=STROKE[kind])
    if result.status != "ok":
        raise InputError(f"attribution benchmark: {kind}, mesh {mesh:g}, {truth.label}: {result.message}")
    return np.asarray(result.stroke), np.asarray(result.force)


@cache
def _read(file: Path) -> tuple[FloatArray, FloatArray]:
    with np.load(file, allow_pickle=False) as content:
        stroke, force = content["curve"]
    return stroke, force
