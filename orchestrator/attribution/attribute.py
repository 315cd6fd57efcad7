"""Forming attribution: which cause the difference between measured and simulated force-stroke curves points to.

Each cause (an effect of friction, flow stress, heat, the press itself) leaves a fingerprint on the curves of all
levels: their change when that cause is moved a little. The measured minus the simulated curves are projected
on these fingerprints under the scatter of the repeats. Force curves alone cannot prove a cause: the answer names
every cause that fits as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from forming.press import PressCurves, PressLevel
from friction_models.common import InputError, grown
from friction_models.common.cached_results import cache_folder
from friction_models.common.folders import SENSITIVITIES

from ..cosim.system import System
from ..jobs.job import Progress
from .curves import on_common_stroke
from .fit import attribution
from .forming_system import FormingSystem
from .result import Attribution
from .sensitivities import run_sensitivities

#: Share of the recorded stroke below which a run counts as short.
SHORT = 0.8


def attribute(
    press: PressCurves | str | Path,
    systems: System | Sequence[System],
    causes: Sequence[str] | None = None,
    runs: Path | None = None,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> Attribution:
    """Say which cause the difference between measured and simulated force-stroke curves points to.

    `press` holds the measured curves, `systems` the user's co-simulation, one for each process of them; `causes` are
    names, all by default. Runs are kept in the folder `runs` (the user's cache folder by default): what was computed
    there is not computed again. An `InputError` says that no level belongs to a system, or which one cannot be varied.
    """
    curves = press if isinstance(press, PressCurves) else PressCurves.read(press)
    varied = [FormingSystem.of(s) for s in ([systems] if isinstance(systems, System) else systems)]
    pairs, warnings = _matched(curves, varied)
    folder = grown(cache_folder() / "attribution" if runs is None else runs, SENSITIVITIES)
    found = run_sensitivities(varied, pairs, causes, folder, jobs, progress)
    levels = [
        on_common_stroke(level, base, found.mesh_size)
        for (_, level), base in zip(pairs, found.base, strict=True)
    ]
    for (_, level), v in zip(pairs, levels, strict=True):
        recorded = float(level.curves.groupby("repeat")["stroke"].max().min())
        if v.stroke[-1] < SHORT * recorded:
            warnings.append(
                f"{level.file}: the system's run ends at {v.stroke[-1]:.1f} mm, the press at {recorded:.1f} mm of stroke; "
                "what comes after was not judged (a longer stop_time, or speed of the forming FMU)"
            )
    synthetic = curves.synthetic or any(s.system.synthetic for s in varied)
    return attribution(levels, found, synthetic, [*warnings, *found.warnings])


def _matched(
    curves: PressCurves, systems: Sequence[FormingSystem]
) -> tuple[list[tuple[FormingSystem, PressLevel]], list[str]]:
    """Return the levels with the system of their process."""
    pairs, left = [], []
    for level in curves.levels:
        system = next((s for s in systems if s.process == level.process), None)
        system = system or next((s for s in systems if not s.process), None)
        if system is None:
            left.append(level.file)
        else:
            pairs.append((system, level))
    if not pairs:
        raise InputError(
            f"press curves of {', '.join(sorted({x.process for x in curves.levels}))}: the systems form "
            f"{', '.join(s.process or 'something else' for s in systems)}; allowed: a system of the same process"
        )
    notes = [f"no system forms {', '.join(left)}: left out"] if left else []
    return pairs, notes
