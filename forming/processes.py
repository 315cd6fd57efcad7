"""The forming processes by their short names."""

from __future__ import annotations

from .bce import BackwardCupExtrusion
from .fre import ForwardRodExtrusion
from .process import FormingProcess
from .ring import RingCompression, Upsetting

PROCESSES: dict[str, type[FormingProcess]] = {
    "fre": ForwardRodExtrusion,
    "bce": BackwardCupExtrusion,
    "upsetting": Upsetting,
    "ring": RingCompression,
}
