"""Force-stroke curves: simulated against measured, on the stroke that both cover."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict

import numpy as np

from friction_models.common import InputError
from friction_models.loads import FloatArray

from .metrics import LevelSummary, Measured, ScalarError, percent

#: Both curves are averaged over this stroke before the maximum is read: nodes that enter contact make the
#: simulated force ripple, and a force cell is noisy; the same window for both keeps the comparison fair.
WINDOW = 0.5
#: Points of the common stroke.
SAMPLES = 401


@dataclass(frozen=True)
class ForceCurve:
    """Punch force [kN] over stroke [mm]; the stroke never runs backwards.

    Examples
    --------
    >>> curve = ForceCurve([0.0, 1.0, 2.0], [0.0, 100.0, 100.0])
    >>> curve.work(0.0, 2.0)
    150.0
    """

    stroke: FloatArray
    force: FloatArray

    def __post_init__(self) -> None:
        stroke, force = np.asarray(self.stroke, dtype=float), np.asarray(self.force, dtype=float)
        if stroke.shape != force.shape or stroke.ndim != 1 or len(stroke) < 2:
            raise InputError(
                f"force curve: shapes {stroke.shape} and {force.shape}, allowed: two equal vectors of at least 2"
            )
        if not (finite := np.isfinite(stroke) & np.isfinite(force)).all():
            row = int(np.argmin(finite))
            raise InputError(
                f"force curve: row {row}: {stroke[row]:g} mm, {force[row]:g} kN; allowed: finite numbers"
            )
        if np.any(np.diff(stroke) < 0.0):
            row = int(np.argmax(np.diff(stroke) < 0.0)) + 1
            raise InputError(
                f"force curve: row {row}: stroke {stroke[row]:g} mm comes after {stroke[row - 1]:g} mm; it must not run backwards"
            )
        object.__setattr__(self, "stroke", stroke)
        object.__setattr__(self, "force", force)

    def on(self, grid: FloatArray) -> FloatArray:
        """Return the force on `grid` [mm], averaged over `WINDOW` (narrower at the ends)."""
        fine = np.union1d(self.stroke, grid)
        force = np.interp(fine, self.stroke, self.force)
        area = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(fine))])
        half = np.minimum(WINDOW / 2, np.minimum(grid - grid[0], grid[-1] - grid))
        wide = half > 1e-9
        mean = np.interp(grid, fine, force)
        low, high = grid[wide] - half[wide], grid[wide] + half[wide]
        mean[wide] = (_primitive(high, fine, force, area) - _primitive(low, fine, force, area)) / (high - low)
        return mean

    def work(self, start: float, end: float) -> float:
        """Return the integral of the force between two strokes [kN mm = J], exact for the polygon."""
        knots = np.union1d(self.stroke[(self.stroke > start) & (self.stroke < end)], [start, end])
        return float(np.trapezoid(np.interp(knots, self.stroke, self.force), knots))


def _primitive(x: FloatArray, knots: FloatArray, force: FloatArray, area: FloatArray) -> FloatArray:
    """Integral of the piecewise linear force from the first knot to `x`."""
    k = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, len(knots) - 2)
    step = x - knots[k]
    slope = (force[k + 1] - force[k]) / np.maximum(knots[k + 1] - knots[k], 1e-30)
    return np.asarray(area[k] + force[k] * step + 0.5 * slope * step**2)


def read_press_curve(path: str | os.PathLike[str]) -> tuple[ForceCurve, ...]:
    """Read the repeats of a level: a CSV with the columns ``stroke [mm], force [kN], repeat`` (which may be missing).

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     file = Path(place) / "level.csv"
    ...     _ = file.write_text(chr(10).join(["stroke [mm],force [kN]", "0,0", "1,50", "2,50"]))
    ...     (curve,) = read_press_curve(file)
    >>> curve.work(0.0, 2.0)
    75.0
    """
    from forming.press import read_curves

    file = Path(path)
    if file.is_dir():
        raise InputError(f"{file}: is a folder, allowed: the CSV of one level (see its levels.csv)")
    return tuple(
        ForceCurve(part["stroke"].to_numpy(), part["force"].to_numpy())
        for _, part in read_curves(file).groupby("repeat", sort=True)
    )


class ForceNumbers(TypedDict):
    """Errors of one level as plain numbers; `stroke_mm` are the ends of the common stroke."""

    label: str
    stroke_mm: list[float]
    max_force_kN: dict[str, float]
    work_J: dict[str, float]
    rms_kN: float


class LevelsNumbers(TypedDict):
    """Errors of one friction model, in summary and level by level."""

    label: str
    max_force: dict[str, float]
    work: dict[str, float]
    levels: list[ForceNumbers]


@dataclass(frozen=True)
class ForceComparison:
    """One simulated curve against the repeats of one level.

    `stroke` is the common one [mm], shape (n,) as the forces [kN]: of the simulation, mean and standard deviation of
    the repeats. `max_force` and `work`: errors of the maximum force [kN] and of the forming work [J].

    Examples
    --------
    >>> stroke = np.linspace(0.0, 10.0, 50)
    >>> found = compare_force(ForceCurve(stroke, 110.0 + 0 * stroke), ForceCurve(stroke, 100.0 + 0 * stroke), "mu = 0.1")
    >>> found.label, round(found.rms, 6), round(found.max_force.signed, 6)
    ('mu = 0.1', 10.0, 0.1)
    """

    label: str
    stroke: FloatArray
    simulated: FloatArray
    measured: FloatArray
    measured_std: FloatArray
    max_force: ScalarError
    work: ScalarError

    @property
    def rms(self) -> float:
        """Root mean square of the force difference over the common stroke [kN]."""
        return float(np.sqrt(np.mean((self.simulated - self.measured) ** 2)))

    def to_dict(self) -> ForceNumbers:
        """Return plain numbers: errors of maximum force and work, rms, the common stroke."""
        return {
            "label": self.label,
            "stroke_mm": [float(self.stroke[0]), float(self.stroke[-1])],
            "max_force_kN": self.max_force.to_dict(),
            "work_J": self.work.to_dict(),
            "rms_kN": self.rms,
        }

    def table(self) -> str:
        """Return the comparison as text."""
        rows = [
            f"{self.label}: common stroke {self.stroke[0]:.2f} to {self.stroke[-1]:.2f} mm, "
            f"{self.max_force.measured.repeats} repeats, moving mean {WINDOW:g} mm",
            f"{'':14}{'simulated':>11}{'measured':>19}{'AE':>17}{'ARE':>19}",
        ]
        for name, unit, e in (("max force", "kN", self.max_force), ("work", "J", self.work)):
            measured = f"{e.measured.mean:.1f} +- {e.measured.std:.1f}"
            ae = f"{e.ae:.1f} +- {e.ae_std:.1f}"
            head = f"{name} [{unit}]"
            rows.append(f"{head:14}{e.simulated:11.1f}{measured:>19}{ae:>17}{percent(e.are, e.are_std):>19}")
        return "\n".join(rows)


def compare_force(
    simulated: ForceCurve, measured: ForceCurve | Sequence[ForceCurve], label: str = "simulation"
) -> ForceComparison:
    """Compare a simulated curve with measured repeats on the stroke that all of them cover.

    Forming work is the integral of the force over that stroke (kN mm = J). The uncertainty is the
    scatter of the repeats, carried through by Gaussian error propagation.

    Raises
    ------
    InputError
        The curves have no stroke in common.

    Examples
    --------
    >>> stroke = np.linspace(0.0, 10.0, 50)
    >>> found = compare_force(ForceCurve(stroke, 110.0 + 0 * stroke), ForceCurve(stroke, 100.0 + 0 * stroke))
    >>> round(found.max_force.are, 3), round(found.work.ae, 1)
    (0.1, 100.0)
    """
    repeats = (measured,) if isinstance(measured, ForceCurve) else measured
    curves = (simulated, *repeats)
    start = max(c.stroke[0] for c in curves)
    end = min(c.stroke[-1] for c in curves)
    if not end > start:
        raise InputError(
            f"{label}: no common stroke: simulated {simulated.stroke[0]:g} to {simulated.stroke[-1]:g} mm, "
            f"measured {max(c.stroke[0] for c in repeats):g} to {min(c.stroke[-1] for c in repeats):g} mm"
        )
    grid = np.linspace(start, end, SAMPLES)
    force = simulated.on(grid)
    all_repeats = np.array([c.on(grid) for c in repeats])
    std = all_repeats.std(axis=0, ddof=1) if len(repeats) > 1 else np.zeros(SAMPLES)
    works = [c.work(start, end) for c in repeats]
    return ForceComparison(
        label,
        grid,
        force,
        all_repeats.mean(axis=0),
        std,
        ScalarError(float(force.max()), Measured.of(all_repeats.max(axis=1))),
        ScalarError(simulated.work(start, end), Measured.of(works)),
    )


@dataclass(frozen=True)
class LevelsComparison:
    """One friction model on all levels of a press campaign."""

    label: str
    levels: tuple[ForceComparison, ...]

    @property
    def max_force(self) -> LevelSummary:
        """MARE of the maximum force and its spread over the levels."""
        return LevelSummary.of([c.max_force for c in self.levels])

    @property
    def work(self) -> LevelSummary:
        """MARE of the forming work and its spread over the levels."""
        return LevelSummary.of([c.work for c in self.levels])

    def to_dict(self) -> LevelsNumbers:
        """Return plain numbers, level by level and in summary."""
        return {
            "label": self.label,
            "max_force": self.max_force.to_dict(),
            "work": self.work.to_dict(),
            "levels": [c.to_dict() for c in self.levels],
        }


def levels_table(comparisons: Sequence[LevelsComparison]) -> str:
    """Return MARE and spread of several friction models as text.

    Examples
    --------
    >>> stroke = np.linspace(0.0, 10.0, 50)
    >>> press = ForceCurve(stroke, 100.0 + 0 * stroke)
    >>> levels = tuple(compare_force(ForceCurve(stroke, force + 0 * stroke), press) for force in (110.0, 130.0))
    >>> print(levels_table([LevelsComparison("mu = 0.1", levels)]))
                        MARE max force       std over levels             MARE work
    mu = 0.1             20.0 +- 0.0 %         14.1 +- 0.0 %         20.0 +- 0.0 %
    """
    width = max([12, *(len(c.label) + 2 for c in comparisons)])
    rows = [f"{'':{width}}{'MARE max force':>22}{'std over levels':>22}{'MARE work':>22}"]
    for item in comparisons:
        force, work = item.max_force, item.work
        spread = percent(force.spread, force.spread_std) if force.levels > 1 else "-"
        cells = percent(force.mare, force.mare_std), spread, percent(work.mare, work.mare_std)
        rows.append(f"{item.label:{width}}" + "".join(f"{c:>22}" for c in cells))
    return "\n".join(rows)
