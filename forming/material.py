"""Workpiece material: flow curve after Hensel and Spittel, elasticity, heat."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from friction_models.loads import InputError, unknown_name

from .fe.shape import FloatArray

FORMS = ("inverse_strain", "rate_temperature")


@dataclass(frozen=True)
class HenselSpittel:
    r"""Elasto-viscoplastic material with a Hensel-Spittel flow curve.

    Two readings of five published coefficients are in use, and `form` says which one is meant:

    ``"inverse_strain"``
        :math:`k_f = A\,e^{m_1 T}\,\varphi^{m_2}\,\dot\varphi^{m_3}\,e^{m_4/\varphi}`
    ``"rate_temperature"``
        :math:`k_f = A\,e^{m_1 T}\,\varphi^{m_2}\,\dot\varphi^{m_3 + m_4 T}`

    Strain and rate are bounded from below smoothly,
    :math:`\varphi \to \sqrt{\varphi^2 + \varphi_0^2}`, because the law has no yield point at zero.

    Parameters
    ----------
    A : float
        Coefficient [MPa].
    m1 : float
        Temperature coefficient [1/K]; temperatures are in degC.
    m2, m3, m4 : float
        Exponents, see above.
    form : {"inverse_strain", "rate_temperature"}
        The reading of `m4`.
    E : float
        Young's modulus [MPa].
    nu : float
        Poisson's ratio.
    rho : float
        Density [kg/m3].
    cp : float
        Specific heat [J/(kg K)].
    conductivity : float
        Heat conductivity [W/(m K)].
    taylor_quinney : float
        Share of plastic work that becomes heat.
    strain_floor, rate_floor : float
        Lower bounds of strain and strain rate [1/s] in the law.
    name : str
        For reports.

    Raises
    ------
    InputError
        An unknown form, or a value outside its physical limits.
    """

    A: float
    m1: float
    m2: float
    m3: float
    m4: float
    form: Literal["inverse_strain", "rate_temperature"] = "inverse_strain"
    E: float = 210_000.0
    nu: float = 0.3
    rho: float = 7850.0
    cp: float = 470.0
    conductivity: float = 42.0
    taylor_quinney: float = 0.9
    strain_floor: float = 2e-3
    rate_floor: float = 1e-3
    name: str = "steel"

    def __post_init__(self) -> None:
        if self.form not in FORMS:
            raise unknown_name("form", self.form, FORMS, f"material {self.name!r}")
        for name in ("A", "E", "rho", "cp", "conductivity", "strain_floor", "rate_floor"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"material {self.name!r}: {name} = {value!r}; allowed: a finite number > 0")
        if not 0.0 <= self.nu < 0.5:
            raise InputError(f"material {self.name!r}: nu = {self.nu!r}; allowed: 0 <= nu < 0.5")
        if not 0.0 <= self.taylor_quinney <= 1.0:
            raise InputError(
                f"material {self.name!r}: taylor_quinney = {self.taylor_quinney!r}; allowed: 0 to 1"
            )

    @property
    def shear_modulus(self) -> float:
        """Shear modulus [MPa]."""
        return self.E / (2.0 * (1.0 + self.nu))

    @property
    def bulk_modulus(self) -> float:
        """Bulk modulus [MPa]."""
        return self.E / (3.0 * (1.0 - 2.0 * self.nu))

    @property
    def heat_capacity(self) -> float:
        """Heat capacity of a volume [N/(mm2 K)], which is the number in MJ/(m3 K)."""
        return self.rho * self.cp * 1e-6

    def flow_stress(
        self, strain: npt.ArrayLike, T: npt.ArrayLike = 20.0, rate: npt.ArrayLike = 1.0
    ) -> FloatArray:
        """Return the flow stress [MPa] for plastic strain, temperature [degC] and strain rate [1/s]."""
        phi = np.hypot(np.asarray(strain, dtype=np.float64), self.strain_floor)
        phi_dot = np.hypot(np.asarray(rate, dtype=np.float64), self.rate_floor)
        T = np.asarray(T, dtype=np.float64)
        inverse, slope = self._m4_by_form()
        return self.A * np.exp(self.m1 * T + inverse / phi) * phi**self.m2 * phi_dot ** (self.m3 + slope * T)

    def _m4_by_form(self) -> tuple[float, float]:
        return (self.m4, 0.0) if self.form == "inverse_strain" else (0.0, self.m4)

    def vector(self) -> FloatArray:
        """Return the ten numbers the kernels read (order: see `forming.fe.element`)."""
        inverse, slope = self._m4_by_form()
        return np.array(
            [
                self.A,
                self.m1,
                self.m2,
                self.m3,
                inverse,
                slope,
                self.shear_modulus,
                self.bulk_modulus,
                self.strain_floor,
                self.rate_floor,
            ]
        )


def steel_16MnCr5(form: Literal["inverse_strain", "rate_temperature"] = "inverse_strain") -> HenselSpittel:
    """Return case-hardening steel 16MnCr5 (1.7131) with the coefficients of the paper; handbook heat data.

    The two readings of the fifth coefficient differ by +0.4 % at 20 degC and +8 % at 200 degC and 100/s.
    """
    return HenselSpittel(
        A=677.443,
        m1=-0.000788968,
        m2=0.103451,
        m3=0.0253737,
        m4=8.45076e-05,
        form=form,
        name="16MnCr5",
    )
