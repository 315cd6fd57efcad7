"""Materials with a flow curve: Hensel-Spittel, power laws, tables."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import ClassVar, Literal, Self

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError, unknown_name
from friction_models.common.ranges import is_number

from ..fe.flow import EXTENDED, POWER, TABLE
from ..fe.mesh.shape import FloatArray
from .base import Material

FORMS = ("inverse_strain", "rate_temperature")


@dataclass(frozen=True, kw_only=True)
class HenselSpittel(Material):
    r"""Elasto-viscoplastic material with a Hensel-Spittel flow curve, T in degC.

    .. math:: k_f = A\,e^{m_1 T}\,T^{m_9}\,\varphi^{m_2 + n_1 T}\,e^{(m_4 + l_1 T)/\varphi}\,
              (1+\varphi)^{m_5 T}\,e^{m_7 \varphi}\,\dot\varphi^{m_3 + m_8 T}

    Two readings of five published coefficients are in use, and `form` says which one is meant:

    ``"inverse_strain"``
        `m4` as above: :math:`k_f = A\,e^{m_1 T}\,\varphi^{m_2}\,\dot\varphi^{m_3}\,e^{m_4/\varphi}`
    ``"rate_temperature"``
        `m4` in the place of `m8`: :math:`k_f = A\,e^{m_1 T}\,\varphi^{m_2}\,\dot\varphi^{m_3 + m_4 T}`

    Strain and rate are bounded from below smoothly,
    :math:`\varphi \to \sqrt{\varphi^2 + \varphi_0^2}`, because the law has no yield point at zero;
    :math:`T^{m_9}` is that of 1 degC below 1 degC.

    Parameters
    ----------
    A : float
        Coefficient [MPa].
    m1 : float
        Temperature coefficient [1/K].
    m2, m3, m4, m5, m7, m8, m9, n1, l1 : float
        Exponents, see above; there is no m6.
    form : {"inverse_strain", "rate_temperature"}
        The reading of `m4`.
    strain_floor, rate_floor : float
        Lower bounds of strain and strain rate [1/s] in the law.

    Raises
    ------
    InputError
        An unknown form, or a value outside its physical limits.

    Examples
    --------
    Without softening, and at a rate of 1/s, the stress grows with the strain to the power m2:

    >>> from forming import HenselSpittel
    >>> steel = HenselSpittel(A=800.0, m1=0.0, m2=0.5, m3=0.01)
    >>> steel.flow_stress([0.25, 1.0], T=20.0, rate=1.0).round(1).tolist()
    [400.0, 800.0]
    """

    A: float
    m1: float
    m2: float
    m3: float
    m4: float = 0.0
    form: Literal["inverse_strain", "rate_temperature"] = "inverse_strain"
    m5: float = 0.0
    m7: float = 0.0
    m8: float = 0.0
    m9: float = 0.0
    n1: float = 0.0
    l1: float = 0.0
    strain_floor: float = 2e-3
    rate_floor: float = 1e-3

    _positive: ClassVar[tuple[str, ...]] = ("A", "E", "rho", "strain_floor", "rate_floor")

    def __post_init__(self) -> None:
        where = f"material {self.name!r}"
        if self.form not in FORMS:
            raise unknown_name("form", self.form, FORMS, where)
        for name in ("m1", "m2", "m3", "m4", "m5", "m7", "m8", "m9", "n1", "l1"):
            if not is_number(getattr(self, name)):
                raise InputError(f"{where}: {name} = {getattr(self, name)!r}; allowed: a finite number")
        if self.form == "rate_temperature" and self.m8 != 0.0:
            raise InputError(f"{where}: m8 = {self.m8!r}; allowed: 0 where m4 takes its place")
        super().__post_init__()

    def flow_stress(
        self, strain: npt.ArrayLike, T: npt.ArrayLike = 20.0, rate: npt.ArrayLike = 1.0
    ) -> FloatArray:
        """Return the flow stress [MPa] for plastic strain, temperature [degC] and strain rate [1/s]."""
        phi = np.hypot(np.asarray(strain, dtype=np.float64), self.strain_floor)
        phi_dot = np.hypot(np.asarray(rate, dtype=np.float64), self.rate_floor)
        T = np.asarray(T, dtype=np.float64)
        inverse, slope = self._m4_by_form()
        kf = self.A * np.exp(self.m1 * T + (inverse + self.l1 * T) / phi + self.m7 * phi)
        kf = kf * phi ** (self.m2 + self.n1 * T) * (1.0 + phi) ** (self.m5 * T)
        return kf * phi_dot ** (self.m3 + slope * T) * np.maximum(T, 1.0) ** self.m9

    def hardened(self, factor: float) -> Self:
        """Return the material with `factor` times the flow stress."""
        return replace(self, A=factor * self.A)

    def _m4_by_form(self) -> tuple[float, float]:
        return (self.m4, self.m8) if self.form == "inverse_strain" else (0.0, self.m4)

    def vector(self) -> FloatArray:
        """Return the numbers that the kernels read; see `forming.fe.flow`."""
        inverse, slope = self._m4_by_form()
        more = [self.m5, self.m7, self.m9, self.n1, self.l1]
        law = (self.A, self.m1, self.m2, self.m3, inverse, slope)
        numbers = [*law, self.shear_modulus, self.bulk_modulus, self.strain_floor, self.rate_floor]
        return np.array([[*numbers, EXTENDED, *more]]) if any(more) else np.array(numbers)


@dataclass(frozen=True, kw_only=True)
class PowerLaw(Material):
    r"""Ludwik, Swift and constant flow stress: :math:`k_f = (k_0 + K(\varphi_0+\varphi)^n)(\dot\varphi/\dot\varphi_0)^m`.

    Parameters
    ----------
    yield_stress, K : float
        k0 and K [MPa]; at least one is positive.
    n, prestrain : float
        Exponent and :math:`\varphi_0`, both 0 or more.
    rate_exponent, reference_rate : float
        m (0: no influence) and the rate at which the first factor holds [1/s].
    strain_floor, rate_floor : float
        Smooth lower bounds, as for `HenselSpittel`.

    Raises
    ------
    InputError
        A value outside its physical limits.

    Examples
    --------
    Ludwik, k0 + K strain^n:

    >>> from forming import PowerLaw
    >>> PowerLaw(yield_stress=300.0, K=400.0, n=0.5).flow_stress([0.25, 1.0]).round(3).tolist()
    [500.0, 700.0]

    A constant flow stress that grows by a tenth over a decade of the strain rate:

    >>> import math
    >>> steel = PowerLaw(yield_stress=500.0, rate_exponent=math.log10(1.1))
    >>> steel.flow_stress(0.5, rate=[1.0, 10.0]).round(2).tolist()
    [500.0, 550.0]
    """

    yield_stress: float = 0.0
    K: float = 0.0
    n: float = 0.0
    prestrain: float = 0.0
    rate_exponent: float = 0.0
    reference_rate: float = 1.0
    strain_floor: float = 1e-6
    rate_floor: float = 1e-3

    _positive: ClassVar[tuple[str, ...]] = ("E", "rho", "strain_floor", "rate_floor", "reference_rate")

    def __post_init__(self) -> None:
        where = f"material {self.name!r}"
        for name in ("yield_stress", "K", "n", "prestrain", "rate_exponent"):
            value = getattr(self, name)
            if not (is_number(value) and value >= 0.0):
                raise InputError(f"{where}: {name} = {value!r}; allowed: a finite number >= 0")
        if self.yield_stress + self.K <= 0.0:
            raise InputError(f"{where}: yield_stress = K = 0; allowed: at least one above 0 MPa")
        super().__post_init__()

    def hardened(self, factor: float) -> Self:
        """Return the material with `factor` times the flow stress."""
        return replace(self, yield_stress=factor * self.yield_stress, K=factor * self.K)

    def vector(self) -> FloatArray:
        """Return the numbers that the kernels read; see `forming.fe.flow`."""
        law = (self.yield_stress, self.K, self.n, self.prestrain, self.rate_exponent, self.reference_rate)
        numbers = [*law, self.shear_modulus, self.bulk_modulus, self.strain_floor, self.rate_floor]
        return np.array([[*numbers, POWER]])


@dataclass(frozen=True, kw_only=True)
class FlowTable(Material):
    """Flow stress from a table over strain, strain rate and temperature.

    The logarithm of the stress is interpolated: by a monotone cubic (Fritsch and Carlson, SIAM J. Numer.
    Anal. 17, 1980) in strain, linearly in the logarithm of the rate and in temperature. Outside the table
    the stress of its edge holds.

    Parameters
    ----------
    strains, rates, temperatures : sequence of float
        Rising values; rates above 0 [1/s], temperatures in degC. One value: no influence.
    stresses : nested sequences, shape (temperatures, rates, strains)
        Flow stress [MPa].

    Raises
    ------
    InputError
        Axes that do not rise, another shape, or a stress that is not positive.

    Examples
    --------
    Two strains at two temperatures; beyond the table its edge holds:

    >>> from forming import FlowTable
    >>> steel = FlowTable(
    ...     strains=(0.0, 1.0), rates=(1.0,), temperatures=(20.0, 220.0), stresses=[[[400.0, 900.0]], [[400.0, 400.0]]]
    ... )
    >>> steel.flow_stress([0.0, 1.0, 2.0], T=20.0).round(3).tolist()
    [400.0, 900.0, 900.0]

    Half-way between the temperatures the logarithm of the stress is the mean, sqrt(900 * 400):

    >>> round(float(steel.flow_stress(1.0, T=120.0)), 3)
    600.0
    >>> steel.T_range
    (20.0, 220.0)
    """

    strains: tuple[float, ...]
    rates: tuple[float, ...]
    temperatures: tuple[float, ...]
    stresses: tuple[tuple[tuple[float, ...], ...], ...]

    #: Most values of an axis.
    longest: ClassVar[int] = 200

    def __post_init__(self) -> None:
        where = f"material {self.name!r}"
        axes = []
        for name, low in (("strains", 0.0), ("rates", 1e-12), ("temperatures", -273.15)):
            axis = tuple(float(v) for v in getattr(self, name))
            if not 1 <= len(axis) <= self.longest:
                raise InputError(f"{where}: {name} has {len(axis)} values; allowed: 1 to {self.longest}")
            if not all(map(math.isfinite, axis)) or axis[0] < low:
                raise InputError(f"{where}: {name} begins with {axis[0]:g}; allowed: finite, {low:g} or more")
            for a, b in pairwise(axis):
                if not a < b:
                    raise InputError(f"{where}: {name}: {b:g} comes after {a:g}; allowed: rising values")
            object.__setattr__(self, name, axis)
            axes.append(axis)
        shape = (len(axes[2]), len(axes[1]), len(axes[0]))
        try:
            stresses = np.array(self.stresses, dtype=np.float64)
        except (ValueError, TypeError):
            raise InputError(f"{where}: the rows of stresses differ in length; allowed: {shape}") from None
        if stresses.shape != shape:
            raise InputError(
                f"{where}: stresses has the shape {stresses.shape}; allowed: {shape} "
                "(temperatures, rates, strains)"
            )
        if not (np.isfinite(stresses) & (stresses > 0.0)).all():
            at = np.argwhere(~(np.isfinite(stresses) & (stresses > 0.0)))[0]
            raise InputError(
                f"{where}: stress {stresses[tuple(at)]!s} MPa at temperature {axes[2][at[0]]:g} degC, rate "
                f"{axes[1][at[1]]:g} 1/s, strain {axes[0][at[2]]:g}; allowed: finite, > 0"
            )
        object.__setattr__(self, "stresses", tuple(tuple(map(tuple, block)) for block in stresses.tolist()))
        for name, axis in zip(("strain_range", "rate_range", "T_range"), axes):
            if getattr(self, name) is None and len(axis) > 1:
                object.__setattr__(self, name, (axis[0], axis[-1]))
        super().__post_init__()

    def hardened(self, factor: float) -> Self:
        """Return the material with `factor` times the flow stress."""
        harder = tuple(tuple(tuple(factor * v for v in row) for row in block) for block in self.stresses)
        return replace(self, stresses=harder)

    def vector(self) -> FloatArray:
        """Return the numbers that the kernels read; see `forming.fe.flow`."""
        from scipy.interpolate import PchipInterpolator

        strains, logs = np.array(self.strains), np.log(np.array(self.stresses))
        slopes = np.zeros_like(logs)
        if len(strains) > 1:
            slopes = PchipInterpolator(strains, logs, axis=2).derivative()(strains)
        head = [0.0] * 6 + [self.shear_modulus, self.bulk_modulus, 0.0, 0.0, TABLE]
        head += [float(len(axis)) for axis in (self.strains, self.rates, self.temperatures)]
        axes = [strains, np.log(self.rates), self.temperatures]
        return np.concatenate([head, *axes, logs.ravel(), slopes.ravel()])[None]
