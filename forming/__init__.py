"""Cold forging in simulation: material, tools, the axisymmetric kernel, processes and press records.

Attributes are imported on first use, so that `import forming` compiles nothing.
"""

from __future__ import annotations

import importlib
from typing import Any

_EXPORTS = {
    "Material": "materials.materials",
    "HenselSpittel": "materials.materials",
    "PowerLaw": "materials.materials",
    "FlowTable": "materials.materials",
    "steel_16MnCr5": "materials.materials",
    "PunchGeometry": "tools.punch_geometry",
    "UpsettingResult": "processes.upsetting",
    "upset": "processes.upsetting",
    "ForwardRodExtrusion": "processes.forward_rod_extrusion",
    "BackwardCupExtrusion": "processes.backward_cup_extrusion",
    "Upsetting": "processes.ring",
    "RingCompression": "processes.ring",
    "FormingResult": "results.result",
    "ContactHistory": "results.contact_history",
    "FormingTask": "processes.batch",
    "FormingRun": "processes.batch",
    "run_batch": "processes.batch",
    "PROCESSES": "processes.names",
    "PressCurves": "press",
    "PressLevel": "press",
}

__all__ = sorted(_EXPORTS)


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        return getattr(importlib.import_module(f".{_EXPORTS[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
