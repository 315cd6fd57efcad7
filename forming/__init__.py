"""Cold forging in simulation: material, tools, the axisymmetric kernel, processes and press records.

Attributes are imported on first use, so that `import forming` compiles nothing.
"""

from __future__ import annotations

import importlib
from typing import Any

_EXPORTS = {
    "Material": "material",
    "HenselSpittel": "material",
    "PowerLaw": "material",
    "FlowTable": "material",
    "steel_16MnCr5": "material",
    "PunchGeometry": "punch_geometry",
    "UpsettingResult": "upsetting",
    "upset": "upsetting",
    "ForwardRodExtrusion": "fre",
    "BackwardCupExtrusion": "bce",
    "Upsetting": "ring",
    "RingCompression": "ring",
    "FormingResult": "result",
    "ContactHistory": "result",
    "FormingTask": "batch",
    "FormingRun": "batch",
    "run_batch": "batch",
    "PROCESSES": "processes",
    "PressCurves": "press",
    "PressLevel": "press",
}

__all__ = sorted(_EXPORTS)


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        return getattr(importlib.import_module(f".{_EXPORTS[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
