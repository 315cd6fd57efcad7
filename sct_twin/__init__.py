"""The sliding compression test: measurement records, the digital twin, a virtual laboratory."""

from __future__ import annotations

from typing import TYPE_CHECKING

from friction_models.common.imports.lazy_names import lazily

if TYPE_CHECKING:
    from . import virtual_lab as virtual_lab
    from .ingest.raw_campaign import RawCampaign as RawCampaign
    from .records.record import SctRecord as SctRecord
    from .twin.digital_twin import SctTwin as SctTwin
    from .twin.digital_twin import TwinResult as TwinResult
    from .twin.process import SctProcess as SctProcess

__getattr__, __dir__, __all__ = lazily(__name__, __file__)
