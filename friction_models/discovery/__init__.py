"""Compare, diagnose, refine: which physical effect is a friction model missing.

`compare` measures models on tests, `diagnose` says what is missing (or that nothing is), `refine` adds it
and refits. `diagnosis_steps` describes how.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .answer.diagnosis import Diagnosis as Diagnosis
    from .comparison import Comparison as Comparison
    from .comparison import compare as compare
    from .diagnosis_steps import diagnose as diagnose
    from .refinement import refine as refine

_EXPORTS = {
    "Comparison": "comparison",
    "Diagnosis": "answer.diagnosis",
    "compare": "comparison",
    "diagnose": "diagnosis_steps",
    "refine": "refinement",
}

__all__ = sorted(_EXPORTS)


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        return getattr(importlib.import_module(f".{_EXPORTS[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
