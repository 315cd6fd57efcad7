"""Workpiece material: flow curve, elasticity, heat; as an object, or from a file by `load`."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from itertools import pairwise
from typing import Any, ClassVar, Literal

import numpy as np
import numpy.typing as npt

from friction_models.loads import InputError, unknown_name

from .fe.flow import EXTENDED, POWER, TABLE, flow_stresses
from .fe.shape import FloatArray
from .temperature import Property, checked_property, scaled

FORMS = ("inverse_strain", "rate_temperature")
Range = tuple[float, float] | None


@dataclass(frozen=True, kw_only=True)
class Material:
    """What every material has besides its flow curve; the subclasses add that.

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
        Where the flow curve holds, in 1, 1/s and degC; None: not known.
    name : str
        For reports.
    source : str
        Where the numbers come from.

    Raises
    ------
    InputError
        A value outside its physical limits.
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
            if not (_is_number(value) and value > 0):
                raise InputError(f"{where}: {name} = {value!r}; allowed: a finite number > 0")
        for name in ("cp", "conductivity"):
            object.__setattr__(self, name, checked_property(getattr(self, name), f"{where}: {name}"))
        if not (_is_number(self.nu) and 0.0 <= self.nu < 0.5):
            raise InputError(f"{where}: nu = {self.nu!r}; allowed: 0 <= nu < 0.5")
        for name in ("taylor_quinney", "emissivity"):
            value = getattr(self, name)
            if not (_is_number(value) and 0.0 <= value <= 1.0):
                raise InputError(f"{where}: {name} = {value!r}; allowed: 0 to 1")
        for name in ("strain_range", "rate_range", "T_range"):
            value = getattr(self, name)
            if value is not None:
                if len(value) != 2 or not all(map(_is_number, value)) or not value[0] < value[1]:
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
        """Return the flow stress [MPa] for plastic strain, temperature [degC] and strain rate [1/s]."""
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

    def check_start(self, where: str, T: float) -> None:
        """Raise when a workpiece cannot start at temperature `T` [degC].

        Raises
        ------
        InputError
            No flow curve, or `T` is outside its range.
        """
        self.vector()
        if self.T_range is not None and not self.T_range[0] <= T <= self.T_range[1]:
            raise InputError(
                f"{where}: workpiece temperature = {T:g} degC; allowed: {self.T_range[0]:g} to "
                f"{self.T_range[1]:g} degC, the range of material {self.name!r}"
            )

    def left_range(self, strain: float, rate: float, T: float) -> tuple[str, ...]:
        """Return a sentence for each of the highest strain, rate [1/s] and temperature [degC] above its range."""
        told = []
        for name, value, limits, unit in (
            ("strain", strain, self.strain_range, ""),
            ("strain rate", rate, self.rate_range, " 1/s"),
            ("temperature", T, self.T_range, " degC"),
        ):
            if limits is not None and value > limits[1]:
                told.append(
                    f"material {self.name!r}: {name} reached {value:.3g}{unit}; the flow curve is known for "
                    f"{limits[0]:g} to {limits[1]:g}{unit}"
                )
        return tuple(told)

    def to_dict(self) -> dict[str, Any]:
        """Return numbers, texts and lists that `material_from_dict` understands."""
        return {"kind": type(self).__name__} | asdict(self)


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
            if not _is_number(getattr(self, name)):
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
            if not (_is_number(value) and value >= 0.0):
                raise InputError(f"{where}: {name} = {value!r}; allowed: a finite number >= 0")
        if self.yield_stress + self.K <= 0.0:
            raise InputError(f"{where}: yield_stress = K = 0; allowed: at least one above 0 MPa")
        super().__post_init__()

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


KINDS: dict[str, type[Material]] = {c.__name__: c for c in (HenselSpittel, PowerLaw, FlowTable, Material)}


def material_from_dict(content: Mapping[str, Any]) -> Material:
    """Return the material that `Material.to_dict` was asked for; without a kind: Hensel-Spittel."""
    given = dict(content)
    kind = given.pop("kind", "HenselSpittel")
    if kind not in KINDS:
        raise unknown_name("kind of material", kind, KINDS)
    return KINDS[kind](**given)


def load(source: str | os.PathLike[str]) -> Material:
    """Return a material by the name of a shipped file (``"16MnCr5"``, ``"1.2379"``) or the path of a YAML file.

    Raises
    ------
    InputError
        No such material or file, or a file that cannot be used; the message names key, value and what is
        allowed.
    """
    from .material_file import read_material

    return read_material(source)


#: How a material is given: itself, the name of a shipped one, the path of a file, or what `to_dict` returned.
MaterialSource = Material | str | os.PathLike[str] | Mapping[str, Any] | None


def as_material(material: MaterialSource) -> Material:
    """Return a material as it is, or by name or path; None: 16MnCr5.

    Raises
    ------
    InputError
        Something else, or see `load`.
    """
    if material is None:
        return steel_16MnCr5()
    if isinstance(material, Material):
        return material
    if isinstance(material, (str, os.PathLike)):
        return load(material)
    if isinstance(material, Mapping):
        return material_from_dict(material)
    raise InputError(
        f"material = {material!r:.60}; allowed: a material, the name of a shipped one, or the path of a file"
    )


def steel_16MnCr5(form: Literal["inverse_strain", "rate_temperature"] = "inverse_strain") -> HenselSpittel:
    """Return case-hardening steel 16MnCr5 (1.7131) with the coefficients of the paper; handbook heat data.

    The two readings of the fifth coefficient differ by +0.4 % at 20 degC and +8 % at 200 degC and 100/s.
    """
    return replace(_shipped_16MnCr5(), form=form)


@lru_cache(maxsize=1)
def _shipped_16MnCr5() -> HenselSpittel:
    steel = load("16MnCr5")
    assert isinstance(steel, HenselSpittel)
    return steel


def _is_number(value: Any) -> bool:
    number = isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
    return number and math.isfinite(value)
