"""Cold forging in simulation: material, tools, the axisymmetric kernel, processes and press records.

Attributes are imported on first use, so that `import forming` compiles nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .materials.materials import FlowTable as FlowTable
    from .materials.materials import HenselSpittel as HenselSpittel
    from .materials.materials import Material as Material
    from .materials.materials import PowerLaw as PowerLaw
    from .materials.materials import steel_16MnCr5 as steel_16MnCr5
    from .press import PressCurves as PressCurves
    from .press import PressLevel as PressLevel
    from .processes.backward_cup_extrusion import BackwardCupExtrusion as BackwardCupExtrusion
    from .processes.batch import FormingRun as FormingRun
    from .processes.batch import FormingTask as FormingTask
    from .processes.batch import run_batch as run_batch
    from .processes.forward_rod_extrusion import ForwardRodExtrusion as ForwardRodExtrusion
    from .processes.names import PROCESSES as PROCESSES
    from .processes.specimen_upsetting import UpsettingResult as UpsettingResult
    from .processes.specimen_upsetting import upset as upset
    from .processes.upsetting import RingCompression as RingCompression
    from .processes.upsetting import Upsetting as Upsetting
    from .results.contact_history import ContactHistory as ContactHistory
    from .results.result import FormingResult as FormingResult
    from .tools.punch_geometry import PunchGeometry as PunchGeometry

_MODULES = {
    "materials.materials": ("Material", "HenselSpittel", "PowerLaw", "FlowTable", "steel_16MnCr5"),
    "tools.punch_geometry": ("PunchGeometry",),
    "processes.specimen_upsetting": ("UpsettingResult", "upset"),
    "processes.forward_rod_extrusion": ("ForwardRodExtrusion",),
    "processes.backward_cup_extrusion": ("BackwardCupExtrusion",),
    "processes.upsetting": ("Upsetting", "RingCompression"),
    "processes.batch": ("FormingTask", "FormingRun", "run_batch"),
    "processes.names": ("PROCESSES",),
    "results.result": ("FormingResult",),
    "results.contact_history": ("ContactHistory",),
    "press": ("PressCurves", "PressLevel"),
}
_EXPORTS = {name: module for module, names in _MODULES.items() for name in names}

__all__ = sorted(_EXPORTS)


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        return getattr(importlib.import_module(f".{_EXPORTS[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
