"""Sensitivities for the forming attribution: the user's system with one thing changed at a time."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from friction_models.common import InputError, grown, unknown_name
from friction_models.common.folders import SENSITIVITIES
from friction_models.common.kept import cache_folder, is_kept, keep
from friction_models.effects import CATALOGUE, make_effect

from ..cosim.batch import RunProgress, RunTask, run_all
from ..cosim.forces import ForceCurve
from .causes import FORMING, FRICTION_LEVEL, MACHINE, Cause, all_causes
from .plant import Plant
from .probe import FACTOR, addable, graph_of, pack_probe, strengths

if TYPE_CHECKING:
    from forming.press import PressLevel

#: What carries the strength of the flow stress in each kind of material.
_FLOW = {"HenselSpittel": ("A",), "PowerLaw": ("yield_stress", "K"), "FlowTable": ("stresses",)}
#: Relative size of the elements of the other mesh, which shows what the mesh does to the curves: twice as many.
OTHER_MESH = 0.7


def runs_folder(given: Path | None) -> Path:
    """Return where runs are kept: the folder that the user names, or one in the user's cache folder.

    Raises
    ------
    InputError
        A folder that holds something else.
    """
    return grown(cache_folder() / "attribution" if given is None else given, SENSITIVITIES)


@dataclass
class Sensitivities:
    """Simulated curves of every level: as the system stands, and with each cause moved by its step.

    Attributes
    ----------
    causes : list of Cause
    base : list of ForceCurve
    moved : dict of str to list of ForceCurve
        By `Cause.key`; causes that need no run are not in it.
    remeshed : list of ForceCurve
        With another size of the elements; empty where it cannot be set.
    mesh_size : float
        Largest element size of the systems [mm]; 0 where unknown.
    warnings : list of str
    """

    causes: list[Cause]
    base: list[ForceCurve]
    moved: dict[str, list[ForceCurve]]
    remeshed: list[ForceCurve]
    mesh_size: float
    warnings: list[str]


def run_sensitivities(
    plants: Sequence[Plant],
    levels: Sequence[tuple[Plant, PressLevel]],
    wanted: Sequence[str] | None,
    folder: Path,
    jobs: int | None = None,
    progress: RunProgress | None = None,
) -> Sensitivities:
    """Run all levels with every cause moved; runs of the same content are taken from `folder`.

    Parameters
    ----------
    plants : sequence of Plant
        The systems (one for each process).
    levels : sequence of (Plant, PressLevel)
        Which system stands for which level.
    wanted : sequence of str, optional
        Names of causes; all by default.
    folder : Path
        Where runs and FMUs are kept.

    Raises
    ------
    InputError
        An unknown cause, or what the systems refuse.
    """
    known = all_causes()
    for name in wanted or ():
        if name not in known:
            raise unknown_name("cause", name, known)
    chosen = set(wanted or known)
    warnings: list[str] = []
    effects = [make_effect(n) for n in known if n in chosen and n in CATALOGUE]
    graphs = {id(p): _graph(p) for p in plants}
    for plant in plants:
        kept = addable(graphs[id(plant)], effects, str(plant.system.fmu_path(plant.friction)))
        warnings += [
            f"{e.name} was not judged: the model remembers the same quantity"
            for e in effects
            if e not in kept
        ]
        effects = kept
    frictions: dict[int, Path] = {}
    for plant in plants:
        name = _hashed(graphs[id(plant)], [e.name for e in effects], plant.nodes, plant.fmi)
        target = folder / f"probe-{name}.fmu"
        if not is_kept(target, name):
            pack_probe(plant.system.fmu_path(plant.friction), effects, target, plant.nodes, plant.fmi)
            keep(target, name)
        frictions[id(plant)] = target
    steps = strengths(effects)
    causes = [c for c in FORMING if c.name in chosen and _possible(c, plants, warnings)]
    if FRICTION_LEVEL.name in chosen:
        causes.append(FRICTION_LEVEL)
    for s in steps:
        several = sum(o.effect == s.effect for o in steps) > 1
        column = s.parameter.removeprefix(f"strength_{s.effect}_") if several else ""
        title = CATALOGUE[s.effect].title
        causes.append(Cause(s.effect, title, "friction", s.unit, s.step, s.sign, column))
    by_key = {c.key: s.parameter for c, s in zip(causes[len(causes) - len(steps) :], steps, strict=True)}
    forming = {id(p): _forming_fmus(p, causes, folder) for p in plants}
    tasks = []
    sizes = [p.start_of("mesh_size") or 0.0 for p in plants]
    keys = ["", *(["mesh"] if min(sizes) > 0.0 else []), *(c.key for c in causes)]
    for key in keys:
        for plant, level in levels:
            changes: dict[str, dict[str, float]] = {}
            fmu = forming[id(plant)].get(key, plant.description.path)
            cause = next((c for c in causes if c.key == key), None)
            if key == "mesh":
                changes = {plant.forming: {"mesh_size": OTHER_MESH * (plant.start_of("mesh_size") or 0.0)}}
            elif cause is not None and cause.name == FRICTION_LEVEL.name:
                changes = {plant.friction: {FACTOR: 1.0 + cause.step}}
            elif key in by_key and cause is not None:
                changes = {plant.friction: {by_key[key]: cause.step}}
            elif cause is not None and cause.name == "heat_transfer" and plant.start_of("htc") is not None:
                changes = {plant.forming: {"htc": (plant.start_of("htc") or 0.0) * (1.0 + cause.step)}}
            elif cause is not None and cause.name == "tool_temperature":
                changes = {plant.forming: {"T_tool": level.T_tool + cause.step}}
            elif cause is not None and cause.name == "billet_temperature":
                changes = {plant.forming: {"T_billet": (plant.start_of("T_billet") or 20.0) + cause.step}}
            system = plant.at(level, frictions[id(plant)], fmu, changes)
            name = _hashed(system.to_yaml().encode(), fmu.read_bytes(), key)
            tasks.append(RunTask(system, folder / name, key=name))
    runs = iter(run_all(tasks, jobs, progress))
    curves = {key: [next(runs).force_curve() for _ in levels] for key in keys}
    base, remeshed = curves.pop(""), curves.pop("mesh", [])
    causes += [c for c in MACHINE if c.name in chosen]
    return Sensitivities(causes, base, curves, remeshed, max(sizes), warnings)


def _graph(plant: Plant) -> bytes:
    try:
        return graph_of(plant.system.fmu_path(plant.friction))
    except InputError as error:
        raise InputError(f"{error}; without it friction cannot be told from other causes") from None


def _possible(cause: Cause, plants: Sequence[Plant], warnings: list[str]) -> bool:
    """Return whether a cause can be moved in all systems; says so where it cannot."""
    for plant in plants:
        if cause.name == "heat_transfer":
            fits = bool(plant.config) or plant.start_of("htc") is not None
        elif cause.name == "flow_stress":
            fits = bool(plant.config)
        else:
            fits = plant.start_of("T_tool" if cause.name == "tool_temperature" else "T_billet") is not None
        if not fits:
            warnings.append(
                f"{cause.name} was not judged: {plant.description.path.name} does not say what it was made of, or has "
                "no such parameter (a forming FMU of the target 'python' does)"
            )
            return False
    return True


def _forming_fmus(plant: Plant, causes: Sequence[Cause], folder: Path) -> dict[str, Path]:
    """Pack the forming FMU again for what is fixed in it: flow stress and heat transfer."""
    from fmus import pack_forming
    from forming.materials.materials import material_from_dict

    found: dict[str, Path] = {}
    for cause in causes:
        if cause.name not in {"flow_stress", "heat_transfer"}:
            continue
        if cause.name == "heat_transfer" and plant.start_of("htc") is not None:
            continue  # a parameter: it needs no other FMU
        config = json.loads(json.dumps(plant.config))
        material, fixed = config["material"], dict(config["fixed"])
        if cause.name == "flow_stress":
            for name in _FLOW[material.get("kind", "HenselSpittel")]:
                material[name] = _times(material[name], 1.0 + cause.step)
        else:
            from forming.processes.heat_input import HeatInput

            usual = HeatInput.__dataclass_fields__["htc"].default
            fixed["htc"] = float(fixed.get("htc", usual)) * (1.0 + cause.step)
        if isinstance(fixed.get("tool_material"), dict):
            fixed["tool_material"] = material_from_dict(fixed["tool_material"])
        numbers = {
            v.name: float(v.start)
            for v in plant.description.raw.modelVariables
            if v.causality == "parameter" and v.start is not None and v.type in {"Real", "Float64"}
        }
        # a number that may be left out is 0 in the FMU when it is
        left_out = [n for n in config.get("optional", []) if numbers.get(n) == 0.0]
        numbers = {n: value for n, value in numbers.items() if n not in left_out}
        key = _hashed(
            json.dumps([material, config["fixed"], numbers], sort_keys=True, default=str).encode(), cause.key
        )
        target = folder / f"forming-{key}.fmu"
        if not is_kept(target, key):
            pack_forming(
                target, process=plant.process, material=material_from_dict(material), **{**fixed, **numbers}
            )
            keep(target, key)
        found[cause.key] = target
    return found


def _times(value: Any, factor: float) -> Any:
    return [_times(v, factor) for v in value] if isinstance(value, list) else float(value) * factor


def _hashed(*parts: object) -> str:
    from friction_models.common.kept import fingerprint

    return fingerprint(*parts)[:20]
