"""Virtual laboratory: synthetic sliding compression tests with a known law, always labelled synthetic."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .campaign import Campaign as Campaign
    from .further_tests import run_protocol as run_protocol
    from .hidden import HIDDEN as HIDDEN
    from .law import load_truth as load_truth
    from .lubricants import LUBRICANTS as LUBRICANTS
    from .plans import PLAN_NAMES as PLAN_NAMES
    from .press import NINE_LEVELS as NINE_LEVELS
    from .press import press_curves as press_curves
    from .protocols import PROTOCOLS as PROTOCOLS
    from .rig.file_formats import FORMATS as FORMATS
    from .rig.instruments import Faults as Faults
    from .rig.instruments import Instruments as Instruments
    from .rig.specimen import Rig as Rig

_EXPORTS = {
    "Campaign": "campaign",
    "run_protocol": "further_tests",
    "HIDDEN": "hidden",
    "Faults": "rig.instruments",
    "Instruments": "rig.instruments",
    "LUBRICANTS": "lubricants",
    "PLAN_NAMES": "plans",
    "NINE_LEVELS": "press",
    "press_curves": "press",
    "PROTOCOLS": "protocols",
    "FORMATS": "rig.file_formats",
    "Rig": "rig.specimen",
    "load_truth": "law",
}

__all__ = sorted(_EXPORTS)


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        return getattr(importlib.import_module(f".{_EXPORTS[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
