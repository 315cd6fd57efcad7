"""Cold forging in simulation: material, tools, the axisymmetric kernel, processes and press records.

Attributes are imported on first use, so that `import forming` compiles nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from friction_models.common.imports.lazy_names import lazily

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

__getattr__, __dir__, __all__ = lazily(__name__, __file__)
