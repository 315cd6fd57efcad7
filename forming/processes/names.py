"""The forming processes by their short names."""

from __future__ import annotations

from .backward_cup_extrusion import BackwardCupExtrusion
from .base import FormingProcess
from .forward_rod_extrusion import ForwardRodExtrusion
from .upsetting import RingCompression, Upsetting

PROCESSES: dict[str, type[FormingProcess]] = {
    "fre": ForwardRodExtrusion,
    "bce": BackwardCupExtrusion,
    "upsetting": Upsetting,
    "ring": RingCompression,
}
