"""The catalogue of physical effects, one file each; users add their own as `tribofmu.effects` entry points.

`base` says what an effect is, `parameters` what its numbers are, `declaration` checks one; the folders hold the effects by what drives them, and do not see each other.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..common import InputError, unknown_name
from ..common.imports.plugins import offered
from .base import Effect, EffectContext, Memory, Shape
from .data_faults.force_zero import ForceZero
from .data_faults.sensor_drift import SensorDrift
from .data_faults.twin_heating import TwinHeating
from .declaration import declaration_fault
from .distance.rate_state import RateState
from .distance.running_in import RunningIn
from .distance.static_peak import StaticPeak
from .distance.wear_out import WearOut
from .distance.work_exhaustion import WorkExhaustion
from .empirical.effect import PREFIX as _EMPIRICAL
from .empirical.effect import empirical_effect
from .metadata.batch import Batch
from .metadata.factor import PREFIX as _FACTOR
from .metadata.factor import factor_effect
from .metadata.tool_roughness import ToolRoughness
from .parameters import Amplitude, ShapeParameter
from .pressure_and_surface.pressure_power import PressurePower
from .pressure_and_surface.pressure_saturation import PressureSaturation
from .pressure_and_surface.surface_expansion import SurfaceExpansion
from .speed.hersey import Hersey
from .speed.rising_speed import RisingSpeed
from .speed.stribeck import Stribeck
from .speed.viscous import Viscous
from .temperature.flash_temperature import FlashTemperature
from .temperature.hot_pressure_breakdown import HotPressureBreakdown
from .temperature.thermal_breakdown import ThermalBreakdown
from .temperature.thermal_softening import ThermalSoftening
from .together import check_together

ENTRY_POINT_GROUP = "tribofmu.effects"

_OWN: tuple[type[Effect], ...] = (
    Stribeck,
    RisingSpeed,
    Hersey,
    Viscous,
    ThermalSoftening,
    ThermalBreakdown,
    HotPressureBreakdown,
    PressureSaturation,
    PressurePower,
    SurfaceExpansion,
    RunningIn,
    WearOut,
    WorkExhaustion,
    FlashTemperature,
    StaticPeak,
    RateState,
    Batch,
    ToolRoughness,
    SensorDrift,
    ForceZero,
    TwinHeating,
)


def load_catalogue() -> dict[str, type[Effect]]:
    """Return the own effects and those of installed plug-ins by name.

    A plug-in that cannot be used (import error, not an `Effect`, incomplete, name already taken) is left out with a
    warning that names it.

    Examples
    --------
    >>> load_catalogue()["viscous"].title
    'viscous share of the lubricant film'
    """
    catalogue: dict[str, type[Effect]] = {effect.name: effect for effect in _OWN}

    def fault(effect: Any) -> str | None:
        if not (isinstance(effect, type) and issubclass(effect, Effect)):
            return "not an Effect class"
        if wrong := declaration_fault(effect):
            return wrong
        if effect.name in catalogue:
            return f"the name {effect.name!r} is taken"
        try:
            check_together("catalogue", [*catalogue.values(), effect])
        except InputError as error:
            return str(error)
        return None

    for effect in offered(ENTRY_POINT_GROUP, "effect", fault):
        catalogue[effect.name] = effect
    return catalogue


#: Effects by name.
CATALOGUE: dict[str, type[Effect]] = load_catalogue()

#: Effects that are made from what follows in their name, by its beginning.
_MADE: dict[str, Callable[[str], type[Effect]]] = {_EMPIRICAL: empirical_effect, _FACTOR: factor_effect}


def _made_from(name: str) -> type[Effect] | None:
    """Return the effect that is made from a name, None for other names; raise InputError for a wrong one."""
    if name not in CATALOGUE:
        for start, make in _MADE.items():
            if name.startswith(start):
                return make(name.removeprefix(start))
    return None


def known_effect(name: str) -> bool:
    """Return whether an effect has this name: one of the catalogue, or one that is made from its name.

    Examples
    --------
    >>> [known_effect(n) for n in ("stribeck", "empirical:bump(T)", "factor:operator", "stribek")]
    [True, True, True, False]
    """
    try:
        return name in CATALOGUE or _made_from(name) is not None
    except InputError:
        return False


def make_effect(effect: str | Effect | type[Effect]) -> Effect:
    """Return an effect from its name, its class or itself; ``factor:COLUMN`` is the effect of a column of the test table.

    Raises
    ------
    InputError
        A name that the catalogue does not hold, something that is no effect, or an effect whose declaration is incomplete.

    Examples
    --------
    >>> make_effect("stribeck")
    Stribeck()
    >>> make_effect("empirical:bump(T)").driver
    ('T',)
    >>> make_effect("factor:operator").metadata
    ('operator',)
    >>> make_effect("stribek")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: unknown effect 'stribek'; allowed: ...; did you mean 'stribeck'?
    """
    own = effect if isinstance(effect, type) else type(effect)
    if issubclass(own, Effect):
        fault = declaration_fault(own)
        if fault:
            raise InputError(f"effect {own.__name__}: {fault}")
        return effect if isinstance(effect, Effect) else own()
    if not isinstance(effect, str):
        raise InputError(f"effect {effect!r}: allowed is a name of the catalogue, or an Effect")
    made = _made_from(effect)
    if made is not None:
        return made()
    if effect not in CATALOGUE:
        raise unknown_name("effect", effect, [*CATALOGUE, "factor:COLUMN"])
    return CATALOGUE[effect]()


__all__ = [
    "CATALOGUE",
    "Amplitude",
    "Batch",
    "Effect",
    "EffectContext",
    "FlashTemperature",
    "ForceZero",
    "Hersey",
    "HotPressureBreakdown",
    "Memory",
    "PressurePower",
    "PressureSaturation",
    "RateState",
    "RisingSpeed",
    "RunningIn",
    "SensorDrift",
    "Shape",
    "ShapeParameter",
    "StaticPeak",
    "Stribeck",
    "SurfaceExpansion",
    "ThermalBreakdown",
    "ThermalSoftening",
    "ToolRoughness",
    "TwinHeating",
    "Viscous",
    "WearOut",
    "WorkExhaustion",
    "empirical_effect",
    "factor_effect",
    "known_effect",
    "load_catalogue",
    "make_effect",
]
