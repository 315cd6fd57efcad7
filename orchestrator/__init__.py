"""Couples friction FMUs with forming FMUs, compares forces, runs the whole loop; the only package that knows all others.

Attributes are imported on first use, so that `tribofmu --help` answers at once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from friction_models.common.imports.lazy_names import lazily

if TYPE_CHECKING:
    from fmus.runtime.errors import SimulationError as SimulationError

    from .cosim.master import Master as Master
    from .cosim.ready_made import extrusion_system as extrusion_system
    from .cosim.run_folders import Run as Run
    from .cosim.system import System as System
    from .force_curves.forces import ForceComparison as ForceComparison
    from .force_curves.forces import compare_force as compare_force
    from .prediction.predict_sct import predict_sct as predict_sct

__getattr__, __dir__, __all__ = lazily(__name__, __file__)
