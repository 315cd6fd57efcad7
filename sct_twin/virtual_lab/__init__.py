"""Virtual laboratory: synthetic sliding compression tests with a known law, always labelled synthetic."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .campaign import Campaign as Campaign
    from .campaign import load_truth as load_truth
    from .hidden import HIDDEN as HIDDEN
    from .plans import PLAN_NAMES as PLAN_NAMES
    from .press import press_curves as press_curves

_EXPORTS = {
    "Campaign": "campaign",
    "load_truth": "campaign",
    "HIDDEN": "hidden",
    "PLAN_NAMES": "plans",
    "press_curves": "press",
}

__all__ = sorted(_EXPORTS)


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        return getattr(importlib.import_module(f".{_EXPORTS[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
