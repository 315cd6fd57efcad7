"""Recompute the numbers that ``answers.yaml`` gives as reasons: ``python -m benchmarks.measured.statistics [SET ...]``.

Only pandas, NumPy and SciPy are used, nothing of the diagnosis itself.

The unit is the independent group: a test, or the cell of loads when the tests of a cell are repeats or neighbours.
Errors are root mean squares of predictions for groups that were left out; shape parameters are chosen on the other
groups only. ``share`` is the part of the avoidable squared error (straight base minus flexible reference) that one form
removes on left-out groups.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from .miba import miba_dynamic, miba_static
from .oil_and_rock import motor_oil, sepiolite
from .seal import pneumatic_seal
from .silicone_and_alloys import al10cu_composites, pla_dragonskin, pla_sil950

SETS: dict[str, Callable[[Path], dict[str, object]]] = {
    "motor_oil": motor_oil,
    "sepiolite": sepiolite,
    "miba_dynamic": miba_dynamic,
    "miba_static": miba_static,
    "pla_dragonskin": pla_dragonskin,
    "pla_sil950": pla_sil950,
    "pneumatic_seal": pneumatic_seal,
    "al10cu_composites": al10cu_composites,
}
