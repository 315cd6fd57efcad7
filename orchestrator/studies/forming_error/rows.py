"""Rows of the forming-error study: a run, a summary over levels, a change against constant friction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypedDict

from friction_models.common.wording import counted

from ...force_curves.forces import ForceComparison
from ...force_curves.metrics import LevelSummary


@dataclass(frozen=True)
class RunError:
    """One friction law on one level."""

    lubricant: str
    process: str
    T_tool: float  # [degC]
    speed: float  # of the punch [mm/s]
    level: str
    friction: str  # label of the friction law
    force: ForceComparison
    tau_over_k: float  # highest friction stress over shear yield stress
    outside: float | None  # share of the markers in contact outside the trained domain
    distance: float | None  # their median distance from it, in trained ranges
    timing: Mapping[str, float] = field(repr=False)  # seconds in friction, forming, master

    @property
    def friction_share(self) -> float:
        """Time in the friction FMU over that of all the rest of the stepping, which any friction law needs."""
        return self.timing["friction"] / max(self.timing["forming"] + self.timing["master"], 1e-12)

    def to_dict(self) -> dict[str, str | float | None]:
        """Return one row of numbers."""
        row: dict[str, str | float | None] = {
            "lubricant": self.lubricant,
            "process": self.process,
            "T_tool_degC": self.T_tool,
            "speed_mm_s": self.speed,
            "friction": self.friction,
        }
        for name, unit, error in (("max_force", "kN", self.force.max_force), ("work", "J", self.force.work)):
            row |= {
                f"{name}_{unit}": error.simulated,
                f"{name}_measured_{unit}": error.measured.mean,
                f"{name}_measured_std_{unit}": error.measured.std,
                f"{name}_ae_{unit}": error.ae,
                f"{name}_are": error.are,
                f"{name}_are_std": error.are_std,
                f"{name}_signed": error.signed,
            }
        return row | {
            "rms_kN": self.force.rms,
            "max_tau_over_k": self.tau_over_k,
            "outside_domain": self.outside,
            "median_distance": self.distance,
            "friction_time_share": self.friction_share,
        }


class ModelRow(TypedDict):
    """A trained model."""

    lubricant: str
    family: str
    mae_test: float | None  # error on held-out tests, None without any
    points: int
    tests: int


@dataclass(frozen=True)
class Summary:
    """One friction law over the levels of a group, those that every friction law has."""

    lubricant: str | None
    process: str | None
    friction: str
    planned: int  # levels of the group, with results or without
    max_force: LevelSummary
    work: LevelSummary
    tau_over_k: float
    friction_share: float
    friction_share_max: float

    @property
    def levels(self) -> str:
        """Number of levels in words: ``"9 levels"``, or ``"8 of 9 levels"`` where runs are missing."""
        count = self.max_force.levels
        few = "" if count == self.planned else f"{count} of "
        return f"{few}{counted(self.planned, 'level')}"

    def to_dict(self) -> dict[str, str | float | None]:
        """Return one row of numbers."""
        return {
            "lubricant": self.lubricant or "all",
            "process": self.process or "all",
            "friction": self.friction,
            "levels_planned": self.planned,
            **{f"max_force_{k}": v for k, v in self.max_force.to_dict().items()},
            **{f"work_{k}": v for k, v in self.work.to_dict().items() if k != "levels"},
            "max_tau_over_k": self.tau_over_k,
            "friction_time_share": self.friction_share,
            "friction_time_share_max": self.friction_share_max,
        }


@dataclass(frozen=True)
class Change:
    """Relative change of a friction law's error of the maximum force against constant friction, with uncertainty."""

    friction: str
    constant: str  # empty for the mean over all constants
    mare: float  # change of MARE, -0.5 is half the error
    mare_std: float
    spread: float | None  # change of the standard deviation over the levels; a single level has none
    spread_std: float | None

    def to_dict(self) -> dict[str, str | float | None]:
        """Return one row of numbers."""
        return {
            "friction": self.friction,
            "against": self.constant or "mean of constants",
            "mare_change": self.mare,
            "mare_change_std": self.mare_std,
            "std_change": self.spread,
            "std_change_std": self.spread_std,
        }
