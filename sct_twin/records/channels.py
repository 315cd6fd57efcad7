"""Channels of a sliding compression test and the units they may be written in."""

from __future__ import annotations

from dataclasses import dataclass

from friction_models.common import InputError, unknown_name
from friction_models.common.units import units_like


@dataclass(frozen=True)
class Channel:
    """A recorded quantity with its canonical unit and physical limits.

    >>> CHANNELS["F_n"].unit, CHANNELS["F_n"].units
    ('N', ['N', 'kN', 'MN'])
    """

    name: str
    unit: str
    meaning: str
    lower: float
    upper: float

    @property
    def units(self) -> list[str]:
        """The units it may be written in without further help."""
        return units_like(self.unit)


CHANNELS: dict[str, Channel] = {
    channel.name: channel
    for channel in (
        Channel("t", "s", "time", -1e6, 1e7),
        Channel("F_n", "N", "normal force", -1e5, 1e8),
        Channel("F_r", "N", "force that drives the plate", -1e8, 1e8),
        Channel("s", "mm", "plate position", -1e5, 1e5),
        Channel("a", "mm/s2", "plate acceleration", -1e8, 1e8),
        Channel("T_plate", "degC", "plate temperature", -100.0, 1500.0),
        Channel("v", "mm/s", "plate speed", -1e5, 1e5),
    )
}
CHANNEL_NAMES: tuple[str, ...] = tuple(CHANNELS)
#: What every record holds, and the channels of which one at least tells how the plate moves.
REQUIRED = ("t", "F_n", "F_r")
MOTION = ("s", "v")


def channel(name: str, where: str = "") -> Channel:
    """Return the channel of this name. Raises InputError: no such channel; names the nearest one.

    >>> channel("T_plate").unit
    'degC'
    >>> channel("T_plat")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: unknown quantity 'T_plat'; allowed: ...; did you mean 'T_plate'?
    """
    if name not in CHANNELS:
        raise unknown_name("quantity", name, CHANNELS, where)
    return CHANNELS[name]


def check_scale(unit: object, where: str) -> str:
    """Return the unit as text, or refuse what is not one."""
    if not isinstance(unit, str) or not unit.strip():
        raise InputError(f"{where}: unit {unit!r} is not a text such as 'kN'; allowed: a unit name")
    return unit
