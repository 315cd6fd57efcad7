"""FMUs: friction models for any simulator, the forming solver and the tribometer twin for co-simulation.

Attributes are imported on first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from friction_models.common.imports.lazy_names import lazily

if TYPE_CHECKING:
    from .checks.checking import CheckReport as CheckReport
    from .checks.checking import check as check
    from .runtime.fixed_friction import FmuModel as FmuModel
    from .runtime.fixed_friction import read_friction_fmu as read_friction_fmu
    from .ssp.packing import pack_ssp as pack_ssp
    from .targets.packing import pack as pack
    from .targets.signals import pack_signals as pack_signals
    from .targets.solvers import pack_forming as pack_forming
    from .targets.solvers import pack_twin as pack_twin

__getattr__, __dir__, __all__ = lazily(__name__, __file__)
