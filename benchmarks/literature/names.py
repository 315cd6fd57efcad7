"""Names of the effects a diagnosis may answer with, and of its verdicts.

This is the only file that knows them. Change a name here and every law, score and table follows.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

#: Key used inside this package -> name used by the catalogue that is measured.
EFFECT: dict[str, str] = {
    "stribeck": "stribeck",
    "viscous": "viscous",
    "hersey": "hersey",
    "speed_log": "rising_speed",
    "speed_power": "rising_speed",
    "softening": "thermal_softening",
    "breakdown": "thermal_breakdown",
    "breakdown_pt": "hot_pressure_breakdown",
    "p_saturation": "pressure_saturation",
    "p_power": "pressure_power",
    "expansion": "surface_expansion",
    "running_in": "running_in",
    "wear_out": "wear_out",
    "work": "work_exhaustion",
    "flash": "flash_temperature",
    "static_peak": "static_peak",
    "rate_state": "rate_state",
    "batch": "batch",
    "roughness": "tool_roughness",
    "drift": "sensor_drift",
    "force_zero": "force_zero",
    "twin": "twin_heating",
}

#: Prefix of the names made from a metadata column.
FACTOR = "factor:"

#: Groups that no data of constant load in a test can separate (keys of EFFECT).
INHERENT_TWINS: tuple[frozenset[str], ...] = (
    frozenset({"p_power", "p_saturation", "force_zero"}),
    frozenset({"stribeck", "rate_state", "flash"}),
)

VERDICTS: tuple[str, ...] = (
    "explained",
    "partly_explained",
    "ambiguous",
    "unknown_structure",
    "nothing_missing",
    "data_problem",
    "out_of_domain",
)

#: Verdicts whose effects a user would add to the model without asking further.
ACCEPTING: frozenset[str] = frozenset({"explained", "partly_explained"})


def name(key: str) -> str:
    """Catalogue name of a key.

    Parameters
    ----------
    key : str
        Key of `EFFECT`, or ``factor:COLUMN``.

    Returns
    -------
    str
        Name as the catalogue writes it.

    Raises
    ------
    KeyError
        If the key is neither a key of `EFFECT` nor a factor.
    """
    if key.startswith("factor:"):
        return FACTOR + key.removeprefix("factor:")
    return EFFECT[key]


def plain(text: str) -> str:
    """Lower case, no spaces, no unit: ``factor:Ra [um]`` and ``factor:ra`` are one name."""
    return re.sub(r"\[[^\]]*\]", "", str(text)).strip().lower().replace(" ", "_").rstrip("_")


def plain_set(keys: Iterable[str]) -> frozenset[str]:
    """Comparable catalogue names of several keys."""
    return frozenset(plain(name(key)) for key in keys)


def in_twin_group(keys: Iterable[str]) -> bool:
    """Whether any of the keys belongs to a group of inherent twins."""
    wanted = set(keys)
    return any(group & wanted for group in INHERENT_TWINS)
