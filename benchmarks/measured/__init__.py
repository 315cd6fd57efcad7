"""The diagnosis on friction that other people measured, graded against answers written before it was run on them."""

from __future__ import annotations

from pathlib import Path

#: The measurements are not part of the repository: they lie beside it.
DATA = Path(__file__).parents[2].parent / "shared" / "data"
