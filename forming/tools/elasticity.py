"""Elastic tools: expansion of a die under its bore pressure, and punch and press as a spring."""

from __future__ import annotations

import math
from dataclasses import dataclass

from friction_models.common.ranges import check_range

#: Poisson's ratio of tool steel.
POISSON = 0.3
#: Units of the numbers.
UNITS = {"die_outer_diameter": "mm", "punch_length": "mm", "press_stiffness": "kN/mm", "tool_modulus": "GPa"}


def bore_flexibility(bore_radius: float, outer_radius: float, modulus: float) -> float:
    """Return the widening of a bore for a pressure in it [mm/MPa].

    Thick-walled cylinder with free ends (Lame): ``u = p a / E ((b^2 + a^2) / (b^2 - a^2) + nu)``. It is loaded
    along its whole length; see `ElasticTools.spread` for a short contact.

    - `bore_radius`, `outer_radius`: a and b [mm].
    - `modulus`: E [MPa].

    A bore of 10 mm radius in a steel body of infinite size widens by (1 + nu) a / E:

    >>> round(1000 * bore_flexibility(10.0, 1e9, 200_000.0), 6)
    0.065
    """
    a2, b2 = bore_radius**2, outer_radius**2
    return bore_radius / modulus * ((b2 + a2) / (b2 - a2) + POISSON)


@dataclass(frozen=True)
class ElasticTools:
    """Die, punch and press that give way under the forming force; None is rigid.

    Under 100 kN a press of 500 kN/mm gives way by 0.2 mm:

    >>> from forming.tools.elasticity import ElasticTools
    >>> tools = ElasticTools("fre", diameter=20.0, punch_diameter=20.0, press_stiffness=500.0)
    >>> round(100e3 * tools.compliance, 9)
    0.2
    >>> tools.flexibility
    0.0
    """

    process: str
    #: Bore of the die and diameter of the punch [mm].
    diameter: float
    punch_diameter: float
    #: Outer diameter of the die, a shrink ring included [mm].
    die_outer_diameter: float | None = None
    #: Length of the punch column [mm].
    punch_length: float | None = None
    #: Stiffness of press and tool holder [kN/mm].
    press_stiffness: float | None = None
    #: Young's modulus of the tools [GPa].
    tool_modulus: float = 210.0

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """What is allowed for the numbers, by name."""
        return {
            "die_outer_diameter": (1.2 * self.diameter, 100.0 * self.diameter),
            "punch_length": (1.0, 2000.0),
            "press_stiffness": (10.0, 1e6),
            "tool_modulus": (50.0, 800.0),
        }

    def __post_init__(self) -> None:
        for name, (low, high) in self.ranges.items():
            if (value := getattr(self, name)) is not None:
                check_range(self.process, name, value, low, high, UNITS[name])

    @property
    def flexibility(self) -> float:
        """Widening of the die for its mean contact pressure [mm/MPa]; 0: rigid."""
        if self.die_outer_diameter is None:
            return 0.0
        return bore_flexibility(0.5 * self.diameter, 0.5 * self.die_outer_diameter, 1e3 * self.tool_modulus)

    @property
    def spread(self) -> float:
        """Least area per radian that carries the contact force [mm2]: the bore over one thickness of the wall.

        The load of a shorter contact reaches that far into the wall around it (Saint-Venant).
        """
        if self.die_outer_diameter is None:
            return 0.0
        return 0.25 * self.diameter * (self.die_outer_diameter - self.diameter)

    @property
    def compliance(self) -> float:
        """Shortening of punch and press for the punch force [mm/N]; 0: rigid."""
        press = 0.0 if self.press_stiffness is None else 1e-3 / self.press_stiffness
        if self.punch_length is None:
            return press
        section = 0.25 * math.pi * self.punch_diameter**2
        return press + self.punch_length / (1e3 * self.tool_modulus * section)
