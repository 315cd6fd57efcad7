"""Channels of a sliding compression test and the units they may be written in."""

from __future__ import annotations

from dataclasses import dataclass

from friction_models.loads import InputError, unknown_name


@dataclass(frozen=True)
class Channel:
    """A recorded quantity: canonical unit, factor (and offset) from every unit that is understood."""

    name: str
    unit: str
    meaning: str
    lower: float
    upper: float
    units: dict[str, float]

    def factor(self, unit: str, where: str) -> tuple[float, float]:
        """Return (factor, offset) that turn a value in `unit` into the canonical unit.

        Raises
        ------
        InputError
            The unit does not measure this quantity.
        """
        text = _spelling(unit)
        if self.name == "T_plate" and text == "K":
            return 1.0, -273.15
        if text not in self.units:
            allowed = [*self.units, *(["K"] if self.name == "T_plate" else [])]
            raise unknown_name(f"unit of column {self.name!r}", unit, allowed, where)
        return self.units[text], 0.0


_SPELLINGS = {"°C": "degC", "C": "degC", "mm/s^2": "mm/s2", "mm/s²": "mm/s2", "m/s^2": "m/s2", "m/s²": "m/s2"}


def _spelling(unit: str) -> str:
    text = unit.strip().strip("[]").strip()
    return _SPELLINGS.get(text, text)


_FORCE = {"N": 1.0, "kN": 1e3, "MN": 1e6}
_ACCELERATION = {"mm/s2": 1.0, "m/s2": 1e3, "g": 9806.65}

CHANNELS: dict[str, Channel] = {
    channel.name: channel
    for channel in (
        Channel("t", "s", "time", -1e6, 1e7, {"s": 1.0, "ms": 1e-3}),
        Channel("F_n", "N", "normal force", -1e5, 1e8, _FORCE),
        Channel("F_r", "N", "force that drives the plate", -1e8, 1e8, _FORCE),
        Channel("s", "mm", "plate position", -1e5, 1e5, {"mm": 1.0, "m": 1e3, "um": 1e-3, "cm": 10.0}),
        Channel("a", "mm/s2", "plate acceleration", -1e8, 1e8, _ACCELERATION),
        Channel("T_plate", "degC", "plate temperature", -100.0, 1500.0, {"degC": 1.0}),
        Channel("v", "mm/s", "plate speed", -1e5, 1e5, {"mm/s": 1.0, "m/s": 1e3}),
    )
}
CHANNEL_NAMES: tuple[str, ...] = tuple(CHANNELS)
#: What every record holds, and the channels of which one at least tells how the plate moves.
REQUIRED = ("t", "F_n", "F_r")
MOTION = ("s", "v")


def channel(name: str, where: str = "") -> Channel:
    """Return the channel of this name.

    Raises
    ------
    InputError
        No such channel; names the nearest one.
    """
    if name not in CHANNELS:
        raise unknown_name("quantity", name, CHANNELS, where)
    return CHANNELS[name]


def check_scale(unit: object, where: str) -> str:
    """Return the unit as text, or refuse what is not one."""
    if not isinstance(unit, str) or not unit.strip():
        raise InputError(f"{where}: unit {unit!r} is not a text such as 'kN'; allowed: a unit name")
    return unit
