"""Properties of every material: elasticity, heat data, limits of validity, source."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import ClassVar, Self

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError
from friction_models.common.ranges import is_number

from ..fe.flow import flow_stresses
from ..fe.heat.properties import Property, checked_property, scaled
from ..fe.mesh.shape import FloatArray

Range = tuple[float, float] | None


@dataclass(frozen=True, kw_only=True)
class Material:
    """A material without a flow curve; the subclasses add one.

    Parameters
    ----------
    E : float
        Young's modulus [MPa].
    nu : float
        Poisson's ratio.
    rho : float
        Density [kg/m3].
    cp : float or pairs (T, value)
        Specific heat [J/(kg K)].
    conductivity : float or pairs (T, value)
        Heat conductivity [W/(m K)].
    taylor_quinney : float
        Share of plastic work that becomes heat.
    emissivity : float
        Of the surface, for radiation.
    strain_range, rate_range, T_range : (low, high) or None
        Range in which the flow curve holds, in 1, 1/s and degC; None: not known.
    name : str
        For reports.
    source : str
        Where the numbers come from.

    Raises
    ------
    InputError
        A value outside its physical limits.

    Examples
    --------
    >>> from forming import Material
    >>> tool = Material(E=210_000.0, nu=0.25, rho=8000.0, cp=500.0)
    >>> tool.shear_modulus, tool.bulk_modulus
    (84000.0, 140000.0)
    >>> round(tool.heat_capacity, 9)
    4.0
    >>> Material(nu=0.5)
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: material 'steel': nu = 0.5; allowed: 0 <= nu < 0.5
    """

    E: float = 210_000.0
    nu: float = 0.3
    rho: float = 7850.0
    cp: Property = 470.0
    conductivity: Property = 42.0
    taylor_quinney: float = 0.9
    emissivity: float = 0.5
    strain_range: Range = None
    rate_range: Range = None
    T_range: Range = None
    name: str = "steel"
    source: str = field(default="", compare=False)

    _positive: ClassVar[tuple[str, ...]] = ("E", "rho")

    def __post_init__(self) -> None:
        where = f"material {self.name!r}"
        for name in self._positive:
            value = getattr(self, name)
            if not (is_number(value) and value > 0):
                raise InputError(f"{where}: {name} = {value!r}; allowed: a finite number > 0")
        for name in ("cp", "conductivity"):
            object.__setattr__(self, name, checked_property(getattr(self, name), f"{where}: {name}"))
        if not (is_number(self.nu) and 0.0 <= self.nu < 0.5):
            raise InputError(f"{where}: nu = {self.nu!r}; allowed: 0 <= nu < 0.5")
        for name in ("taylor_quinney", "emissivity"):
            value = getattr(self, name)
            if not (is_number(value) and 0.0 <= value <= 1.0):
                raise InputError(f"{where}: {name} = {value!r}; allowed: 0 to 1")
        for name in ("strain_range", "rate_range", "T_range"):
            value = getattr(self, name)
            if value is not None:
                if len(value) != 2 or not all(map(is_number, value)) or not value[0] < value[1]:
                    raise InputError(f"{where}: {name} = {value!r}; allowed: a low and a higher number")
                object.__setattr__(self, name, (float(value[0]), float(value[1])))

    @property
    def shear_modulus(self) -> float:
        """Shear modulus [MPa]."""
        return self.E / (2.0 * (1.0 + self.nu))

    @property
    def bulk_modulus(self) -> float:
        """Bulk modulus [MPa]."""
        return self.E / (3.0 * (1.0 - 2.0 * self.nu))

    @property
    def heat_capacity(self) -> Property:
        """Heat capacity of a volume [N/(mm2 K)], which is the number in MJ/(m3 K)."""
        return scaled(self.cp, self.rho * 1e-6) if isinstance(self.cp, tuple) else self.rho * self.cp * 1e-6

    def flow_stress(
        self, strain: npt.ArrayLike, T: npt.ArrayLike = 20.0, rate: npt.ArrayLike = 1.0
    ) -> FloatArray:
        """Return the flow stress [MPa] for plastic strain, temperature [degC] and strain rate [1/s].

        Examples
        --------
        >>> from forming import PowerLaw
        >>> PowerLaw(yield_stress=300.0, K=400.0, n=0.5).flow_stress([0.25, 1.0]).round(3).tolist()
        [500.0, 700.0]
        """
        e, t, r = np.broadcast_arrays(*(np.asarray(a, dtype=np.float64) for a in (strain, T, rate)))
        return flow_stresses(e.ravel(), r.ravel(), t.ravel(), self.vector()).reshape(e.shape)

    def vector(self) -> FloatArray:
        """Return the numbers that the kernels read; see `forming.fe.flow`.

        Raises
        ------
        InputError
            The material has no flow curve.
        """
        raise InputError(f"material {self.name!r} has no flow curve; allowed as a tool, not as a workpiece")

    def hardened(self, factor: float) -> Self:
        """Return the material with `factor` times the flow stress, at every strain, rate and temperature.

        Raises
        ------
        InputError
            The material has no flow curve.

        Examples
        --------
        >>> from forming import PowerLaw
        >>> float(PowerLaw(yield_stress=500.0).hardened(1.02).flow_stress(0.3))
        510.0
        """
        raise InputError(f"material {self.name!r} has no flow curve; allowed as a tool, not as a workpiece")

    def check_start(self, where: str, T: float, name: str = "T_billet") -> None:
        """Raise when a workpiece cannot start at temperature `T` [degC], the parameter `name`.

        Raises
        ------
        InputError
            No flow curve, or `T` is outside its range.
        """
        self.vector()
        if self.T_range is not None and not self.T_range[0] <= T <= self.T_range[1]:
            raise InputError(
                f"{where}: {name} = {T:g} degC; allowed: {self.T_range[0]:g} to "
                f"{self.T_range[1]:g} degC, the range of material {self.name!r}"
            )

    def left_range(self, strain: float, rate: float, T: float) -> tuple[str, ...]:
        """Return a sentence for each of the highest strain, rate [1/s] and temperature [degC] above its range.

        Examples
        --------
        >>> from forming import PowerLaw
        >>> PowerLaw(yield_stress=300.0, strain_range=(0.0, 1.0)).left_range(strain=1.5, rate=1.0, T=20.0)
        ("material 'steel': strain reached 1.5; the flow curve is known for 0 to 1",)
        """
        sentences = []
        for name, value, limits, unit in (
            ("strain", strain, self.strain_range, ""),
            ("strain rate", rate, self.rate_range, " 1/s"),
            ("temperature", T, self.T_range, " degC"),
        ):
            if limits is not None and value > limits[1]:
                sentences.append(
                    f"material {self.name!r}: {name} reached {value:.3g}{unit}; the flow curve is known for "
                    f"{limits[0]:g} to {limits[1]:g}{unit}"
                )
        return tuple(sentences)

    def to_dict(self) -> dict[str, object]:
        """Return the material as numbers, texts and lists; `material_from_dict` reads them."""
        return {"kind": type(self).__name__} | asdict(self)
