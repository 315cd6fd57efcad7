"""Virtual laboratory: synthetic sliding compression tests with a known law, always labelled synthetic."""

from __future__ import annotations

from typing import TYPE_CHECKING

from friction_models.common.imports.lazy_names import lazily

if TYPE_CHECKING:
    from .campaign import Campaign as Campaign
    from .further_tests import run_protocol as run_protocol
    from .hidden_effects import HIDDEN as HIDDEN
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

__getattr__, __dir__, __all__ = lazily(__name__, __file__)
