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
    """Settings of a demo."""

    hidden: str | None = "stribeck"  # effect hidden in the laboratory
    seed: int = 7  # of the campaign
    plan: str = "reduced-27+10"  # of the tests
    base: str = "linear"  # family of the model that is diagnosed
    other: str = "ffnn"  # family of the one beside it
    other_parameters: dict[str, object] = field(default_factory=dict)
    constant: float = 0.08  # friction, the literature's usual assumption
    levels: tuple[Level, ...] = (Level(20.0, 5.0), Level(20.0, 100.0), Level(100.0, 5.0))  # of the press
    stroke: float = 20.0  # punch travel [mm]
    repeats: int = 5  # strokes of the press a level
