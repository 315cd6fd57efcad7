"""Sensitivities for the forming attribution: the user's system with one thing changed at a time."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fmus import pack_forming
from forming.materials.materials import material_from_dict
from forming.press import PressLevel
from forming.processes.thermal_conditions import ThermalConditions
from friction_models.common import InputError, unknown_name
from friction_models.common.cached_results import is_kept, keep
from friction_models.effects import CATALOGUE, make_effect
from friction_models.effects.base import Effect

from ..cosim.batch import cached_task, run_all
from ..force_curves.forces import ForceCurve
from ..jobs.job import Progress
from ..jobs.keys import ResultKeys
from .causes import FACTOR, FORMING, FRICTION_LEVEL, MACHINE, Cause, all_causes
from .forming_system import FormingSystem
from .friction_with_effects import addable, graph_of, pack_with_effects, strengths

#: Causes for which a forming FMU is packed again that has no parameter for them.
_PACKED = ("flow_stress", "heat_transfer")
#: What carries the strength of the flow stress in each kind of material.
_FLOW = {"HenselSpittel": ("A",), "PowerLaw": ("yield_stress", "K"), "FlowTable": ("stresses",)}
#: Relative size of the elements of the other mesh, which shows what the mesh does to the curves: twice as many.
OTHER_MESH = 0.7


@dataclass
class Sensitivities:
    """Simulated curves of every level: as the system stands, and with each cause moved by its step."""

    causes: list[Cause]
    base: list[ForceCurve]
    moved: dict[str, list[ForceCurve]]  # by `Cause.key`, without causes that need no run
    remeshed: list[ForceCurve]  # with another size of the elements; empty where that cannot be set
    mesh_size: float  # largest element size of the systems [mm], 0 where unknown
    warnings: list[str]


def run_sensitivities(
    systems: Sequence[FormingSystem],
    levels: Sequence[tuple[FormingSystem, PressLevel]],
    wanted: Sequence[str] | None,
    folder: Path,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> Sensitivities:
    """Run all levels with every cause moved; runs of the same content are taken from `folder`.

    `systems` are one for each process; `levels` say which of them stands for which level; `wanted` are names of
    causes, all by default.
    """
    known = all_causes()
    for name in wanted or ():
        if name not in known:
            raise unknown_name("cause", name, known)
    chosen = set(wanted or known)
    warnings: list[str] = []
    hashes = ResultKeys(__name__)
    effects, frictions = _friction_fmus(systems, [n for n in known if n in chosen], folder, hashes, warnings)
    causes = [c for c in FORMING if c.name in chosen and _possible(c, systems, warnings)]
    if FRICTION_LEVEL.name in chosen:
        causes.append(FRICTION_LEVEL)
    causes += strengths(effects)
    formings = {id(system): _forming_fmus(system, causes, folder, hashes) for system in systems}
    sizes = [system.start_of("mesh_size") or 0.0 for system in systems]
    moved: dict[str, Cause | None] = {"": None, **({"mesh": None} if min(sizes) > 0.0 else {})}
    moved |= {cause.key: cause for cause in causes}
    tasks = []
    for key, moving in moved.items():
        for system, level in levels:
            fmu = formings[id(system)].get(key, system.description.path)
            varied = system.at(level, frictions[id(system)], fmu, _changes(key, moving, system, level))
            tasks.append(cached_task(varied, folder, hashes, key))
    runs = iter(run_all(tasks, jobs, progress))
    curves = {key: [next(runs).force_curve() for _ in levels] for key in moved}
    base, remeshed = curves.pop(""), curves.pop("mesh", [])
    causes += [c for c in MACHINE if c.name in chosen]
    return Sensitivities(causes, base, curves, remeshed, max(sizes), warnings)


def _friction_fmus(
    systems: Sequence[FormingSystem],
    names: Sequence[str],
    folder: Path,
    hashes: ResultKeys,
    warnings: list[str],
) -> tuple[list[Effect], dict[int, Path]]:
    """Return the effects that can be judged, and by system its friction FMU with all of them added at strength 0."""
    effects = [make_effect(n) for n in names if n in CATALOGUE]
    try:
        graphs = {id(s): graph_of(s.system.fmu_path(s.friction)) for s in systems}
    except InputError as error:
        raise InputError(f"{error}; without it friction cannot be told from other causes") from None
    for system in systems:
        kept = addable(graphs[id(system)], effects, str(system.system.fmu_path(system.friction)))
        warnings += [
            f"{e.name} was not judged: the model remembers the same quantity"
            for e in effects
            if e not in kept
        ]
        effects = kept
    frictions: dict[int, Path] = {}
    for system in systems:
        graph = hashlib.sha256(graphs[id(system)]).hexdigest()
        key = hashes.of([graph, [e.name for e in effects], system.nodes, system.fmi])[:20]
        target = folder / f"probe-{key}.fmu"
        if not is_kept(target, key):
            fmu = system.system.fmu_path(system.friction)
            pack_with_effects(fmu, effects, target, system.nodes, system.fmi)
            keep(target, key)
        frictions[id(system)] = target
    return effects, frictions


def _changes(
    key: str, cause: Cause | None, system: FormingSystem, level: PressLevel
) -> dict[str, dict[str, float]]:
    """Return the start values, by component, that a run changes; none where a cause is packed into the forming FMU."""
    if key == "mesh":
        return {system.forming: {"mesh_size": OTHER_MESH * (system.start_of("mesh_size") or 0.0)}}
    if cause is None or not cause.parameter:
        return {}
    if cause.kind == "friction":
        start = 1.0 if cause.parameter == FACTOR else 0.0
        return {system.friction: {cause.parameter: start + cause.step}}
    now = level.T_tool if cause.parameter == "T_tool" else system.start_of(cause.parameter)
    if now is None:
        return {}
    moved = now * (1.0 + cause.step) if cause.unit == "1" else now + cause.step
    return {system.forming: {cause.parameter: moved}}


def _possible(cause: Cause, systems: Sequence[FormingSystem], warnings: list[str]) -> bool:
    """Return whether a cause can be moved in all systems; says so where it cannot."""
    for system in systems:
        if not (system.config and cause.name in _PACKED) and not _is_parameter(cause, system):
            warnings.append(
                f"{cause.name} was not judged: {system.description.path.name} does not say what it was made of, or has "
                "no such parameter (a forming FMU of the target 'python' does)"
            )
            return False
    return True


def _is_parameter(cause: Cause, system: FormingSystem) -> bool:
    return bool(cause.parameter) and system.start_of(cause.parameter) is not None


def _forming_fmus(
    system: FormingSystem, causes: Sequence[Cause], folder: Path, hashes: ResultKeys
) -> dict[str, Path]:
    """Pack the forming FMU again for what is fixed in it: flow stress and heat transfer."""
    found: dict[str, Path] = {}
    for cause in causes:
        if cause.name not in _PACKED or _is_parameter(cause, system):
            continue
        config = json.loads(json.dumps(system.config))
        material, fixed = config["material"], dict(config["fixed"])
        if cause.name == "flow_stress":
            for name in _FLOW[material.get("kind", "HenselSpittel")]:
                material[name] = _times(material[name], 1.0 + cause.step)
        else:
            usual = ThermalConditions.__dataclass_fields__["htc"].default
            fixed["htc"] = float(fixed.get("htc", usual)) * (1.0 + cause.step)
        if isinstance(fixed.get("tool_material"), dict):
            fixed["tool_material"] = material_from_dict(fixed["tool_material"])
        numbers = {
            v.name: float(v.start)
            for v in system.description.raw.modelVariables
            if v.causality == "parameter" and v.start is not None and v.type in {"Real", "Float64"}
        }
        # a number that may be left out is 0 in the FMU when it is
        left_out = [n for n in config.get("optional", []) if numbers.get(n) == 0.0]
        numbers = {n: value for n, value in numbers.items() if n not in left_out}
        key = hashes.of([system.process, material, config["fixed"], numbers, cause.key])[:20]
        target = folder / f"forming-{key}.fmu"
        if not is_kept(target, key):
            pack_forming(
                target, process=system.process, material=material_from_dict(material), **{**fixed, **numbers}
            )
            keep(target, key)
        found[cause.key] = target
    return found


def _times(value: Any, factor: float) -> Any:
    return [_times(v, factor) for v in value] if isinstance(value, list) else float(value) * factor
