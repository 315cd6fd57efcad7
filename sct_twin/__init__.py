"""The sliding compression test: measurement records, the digital twin, a virtual laboratory."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import virtual_lab as virtual_lab
    from .ingest.raw_campaign import RawCampaign as RawCampaign
    from .records.record import SctRecord as SctRecord
    from .twin.digital_twin import SctTwin as SctTwin
    from .twin.digital_twin import TwinResult as TwinResult
    from .twin.process import SctProcess as SctProcess

_EXPORTS = {
    "SctTwin": "twin.digital_twin",
    "TwinResult": "twin.digital_twin",
    "SctRecord": "records.record",
    "SctProcess": "twin.process",
    "RawCampaign": "ingest.raw_campaign",
}

__all__ = ["virtual_lab", *sorted(_EXPORTS)]


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        return getattr(importlib.import_module(f".{_EXPORTS[name]}", __name__), name)
    if name == "virtual_lab":
        return importlib.import_module(".virtual_lab", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
