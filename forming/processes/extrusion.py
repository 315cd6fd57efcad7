"""Common parts of forward and backward extrusion: elastic tools and the ejector."""

from __future__ import annotations

from friction_models.common.ranges import check_range

from ..tools.elasticity import UNITS, ElasticTools
from .base import FormingProcess


class Extrusion(FormingProcess):
    """Extrusion of a billet between a die, a punch and an ejector.

    Parameters
    ----------
    die_outer_diameter : float, optional
        Outer diameter of the die [mm]: it widens elastically; rigid by default.
    punch_length, press_stiffness : float, optional
        Length of the punch column [mm] and stiffness of the press [kN/mm]: `stroke` is then that of the ram,
        ahead of the punch; rigid by default.
    tool_modulus : float
        Young's modulus of the tools [GPa].
    """

    elasticity: ElasticTools
    ejector_diameter: float

    def _set_tools(self, elasticity: ElasticTools, ejector_diameter: float | None, opening: float) -> None:
        """Take the elastic tools and the ejector, by default 0.95 of the `opening` [mm] it stands in."""
        self.elasticity = elasticity
        self.units |= UNITS
        if ejector_diameter is not None:
            check_range(self.name, "ejector_diameter", ejector_diameter, 0.2 * opening, 0.98 * opening, "mm")
        self.ejector_diameter = 0.95 * opening if ejector_diameter is None else ejector_diameter
