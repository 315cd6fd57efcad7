"""What the demo does: plan, models, levels of the press, and where everything lies."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Level:
    """One level of the press: tool temperature [degC] and punch speed [mm/s]."""

    T_tool: float
    speed: float

    @property
    def name(self) -> str:
        """Name in files, ``fre_5mms_20C``."""
        return f"fre_{self.speed:g}mms_{self.T_tool:g}C"

    @property
    def heading(self) -> str:
        """Name for readers."""
        return f"{self.speed:g} mm/s, tools {self.T_tool:g} °C"


@dataclass(frozen=True)
class Scenario:
    """Settings of a demo.

    Attributes
    ----------
    hidden : str or None
        Effect hidden in the laboratory.
    seed : int
        Seed of the campaign.
    plan : str
        Test plan.
    base, other : str
        Families of the model that is diagnosed and of the one beside it.
    other_parameters : dict
        Parameters of the other family.
    constant : float
        Constant friction, the literature's usual assumption.
    levels : tuple of Level
        Press levels.
    stroke : float
        Punch travel [mm].
    repeats : int
        Strokes of the press a level.
    """

    hidden: str | None = "stribeck"
    seed: int = 7
    plan: str = "reduced-27+10"
    base: str = "linear"
    other: str = "ffnn"
    other_parameters: dict[str, object] = field(default_factory=dict)
    constant: float = 0.08
    levels: tuple[Level, ...] = (Level(20.0, 5.0), Level(20.0, 100.0), Level(100.0, 5.0))
    stroke: float = 20.0
    repeats: int = 5
