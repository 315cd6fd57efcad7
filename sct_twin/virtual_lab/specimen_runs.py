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
from friction_models.common.processes.pool import map_unordered

from .contact.specimen_run import SpecimenCase, SpecimenRun, upset_specimen
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
            mu = TABLE_MU + change.get("mu", 0.0)
            case = SpecimenCase(punch, force, rig.mesh_size, rig.material, mu, T, T, rig.ram_speed)
            items.append((case, cache))
    known = {index: kept_run(*item) for index, item in enumerate(items)}
    runs = {index: run for index, run in known.items() if run is not None}
    missing = [index for index in known if index not in runs]
    tick(len(runs), len(items))
    for number, run in map_unordered(compute_run, [items[index] for index in missing], jobs):
        runs[missing[number]] = run
        tick(len(runs), len(items))
    tables = {}
    for number, shape in enumerate(shapes):
        low, high, *others = (runs[len(cases) * number + k] for k in range(len(cases)))
        tables[shape] = SpecimenTable((low, high), rig.material.m1, dict(zip(changed, others)))
    return tables


def kept_run(case: SpecimenCase, cache: str | None) -> SpecimenRun | None:
    """Return an upsetting run from the cache; None: it is not known."""
    with contextlib.suppress(OSError):
        file, key = _place(case, cache)
        if is_kept(file, key):
            with np.load(file, allow_pickle=False) as stored:
                return SpecimenRun(**{f.name: stored[f.name] for f in fields(SpecimenRun)})
    return None


def compute_run(case: SpecimenCase, cache: str | None) -> SpecimenRun:
    """Return what `kept_run` does, computed and kept where it is not known."""
    known = kept_run(case, cache)
    if known is not None:
        return known
    run = upset_specimen(case)
    with contextlib.suppress(OSError, InputError):  # no folder to keep runs in costs time, nothing else
        file, key = _place(case, cache)
        with atomic_path(file) as temporary, temporary.open("wb") as stream:
            np.savez(stream, **{f.name: getattr(run, f.name) for f in fields(SpecimenRun)})
        keep(file, key)
    return run


def _place(case: SpecimenCase, cache: str | None) -> tuple[Path, str]:
    """Return the file that keeps a run, and the hash of all that decides it."""
    key = fingerprint(case, solver_fingerprint())
    return (Path(cache) if cache else cache_folder()) / f"upsetting-{key[:24]}.npz", key


@cache
def solver_fingerprint() -> str:
    """Return a hash of the solver's sources: results of other sources are computed again."""
    return code_digest(SOLVER)
