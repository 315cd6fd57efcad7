"""Compare, diagnose, refine: which physical effect is a friction model missing.

`compare` measures models on tests, `diagnose` says what is missing (or that nothing is), `refine` adds it
and refits. `diagnosis_steps` describes how.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..common.imports.lazy_names import lazily

if TYPE_CHECKING:
    from .answer.diagnosis import Diagnosis as Diagnosis
    from .comparison import Comparison as Comparison
    from .comparison import compare as compare
    from .diagnosis_steps import diagnose as diagnose
    from .refinement import refine as refine

__getattr__, __dir__, __all__ = lazily(__name__, __file__)
