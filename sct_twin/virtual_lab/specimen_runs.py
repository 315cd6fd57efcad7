"""Upsetting runs of a campaign's specimens, kept in a cache folder under a hash of everything they depend on."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import cache
from pathlib import Path

import numpy as np

from forming.tools.punch_geometry import PunchGeometry
from friction_models.common import InputError, atomic_path
from friction_models.common.cached_results import cache_folder, code_digest, fingerprint, is_kept, keep
from friction_models.common.pool import map_unordered

from .contact.specimen_run import SpecimenRun, Upsetting, upset_specimen
from .plans import SIGMA_LEVELS
from .rig.specimen import DIAMETER, HEIGHT, STEPS, TABLE_MU, TEMPERATURES, Rig, SpecimenTable

#: Specimens are upset beyond the largest force, for those that are softer.
FORCE_MARGIN = 1.2
#: Packages whose sources decide an upsetting run.
SOLVER = ("forming.fe", "forming.materials", "forming.tools", "sct_twin.virtual_lab.contact")


def specimen_tables(
    shapes: Mapping[float, float],
    rig: Rig,
    cache: str | None,
    jobs: int | None,
    tick: Callable[[int, int], None],
) -> dict[float, SpecimenTable]:
    """Return the table of every specimen shape.

    `shapes` holds the diameter of the first contact [mm], 0 where the whole end face touches, and the bore of the
    punch [mm]; `tick` is called with (done, total).
    """
    changed = [name for name in STEPS if name == "mu" or rig.scattered]
    cases: list[tuple[float, dict[str, float]]] = [(T, {}) for T in TEMPERATURES]
    cases += [(TEMPERATURES[0], {name: STEPS[name]}) for name in changed]
    items = []
    for tip, bore in shapes.items():
        force = FORCE_MARGIN * SIGMA_LEVELS[-1] * np.pi / 4.0 * bore**2
        for T, change in cases:
            size = DIAMETER + change.get("diameter", 0.0), HEIGHT + change.get("height", 0.0)
            punch = PunchGeometry(*size, bore_diameter=bore, tip_diameter=tip or None)
            items.append((punch, T, TABLE_MU + change.get("mu", 0.0), force, rig, cache))
    runs: dict[int, SpecimenRun] = {}
    for index, run in map_unordered(compute_run, items, jobs):
        runs[index] = run
        tick(len(runs), len(items))
    m1 = rig.material.m1
    tables = {}
    for number, shape in enumerate(shapes):
        mine = [runs[len(cases) * number + k] for k in range(len(cases))]
        tables[shape] = SpecimenTable((mine[0], mine[1]), m1, dict(zip(changed, mine[2:])))
    return tables


def compute_run(
    punch: PunchGeometry, T_tool: float, mu: float, force: float, rig: Rig, cache: str | None
) -> SpecimenRun:
    """Return one upsetting run up to `force` [N] with friction `mu`, from the cache where it is known."""
    case = Upsetting(punch, force, rig.mesh_size, rig.material, mu, T_tool, T_tool, rig.ram_speed)
    key = fingerprint(case, solver_fingerprint())
    names = [f.name for f in fields(SpecimenRun)]
    file: Path | None = None
    with contextlib.suppress(OSError):  # no folder to keep runs in costs time, nothing else
        file = (Path(cache) if cache else cache_folder()) / f"upsetting-{key[:24]}.npz"
        if is_kept(file, key):
            with np.load(file, allow_pickle=False) as stored:
                return SpecimenRun(**{name: stored[name] for name in names})
    run = upset_specimen(case)
    if file is not None:
        with contextlib.suppress(OSError, InputError):
            with atomic_path(file) as temporary, temporary.open("wb") as stream:
                np.savez(stream, **{n: getattr(run, n) for n in names})
            keep(file, key)
    return run


@cache
def solver_fingerprint() -> str:
    """Return a hash of the solver's sources: results of other sources are computed again."""
    return code_digest(SOLVER)
