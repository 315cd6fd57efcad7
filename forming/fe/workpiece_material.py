"""Properties of the workpiece material that the solver needs."""

from __future__ import annotations

from typing import Protocol

from .heat.properties import Property
from .mesh.shape import FloatArray


class WorkpieceMaterial(Protocol):
    """Properties that the solver reads; `forming.materials.materials.Material` has them."""

    @property
    def shear_modulus(self) -> float:
        """Shear modulus [MPa]."""

    @property
    def bulk_modulus(self) -> float:
        """Bulk modulus [MPa]."""

    @property
    def heat_capacity(self) -> Property:
        """Heat capacity of a volume [N/(mm2 K)]."""

    @property
    def conductivity(self) -> Property:
        """Heat conductivity [W/(m K)]."""

    @property
    def taylor_quinney(self) -> float:
        """Share of plastic work that becomes heat."""

    @property
    def emissivity(self) -> float:
        """Emissivity of the surface, for radiation."""

    def vector(self) -> FloatArray:
        """Return the flow curve as numbers; see `forming.fe.flow`."""
