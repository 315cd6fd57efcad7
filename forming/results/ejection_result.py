"""Result of ejecting or stripping a product, and its files."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from friction_models.common import write_json

from ..fe.mesh.shape import FloatArray
from ..tools.ejection_tools import GripPatch
from .contact_history import ContactHistory
from .force_curve import averaged

if TYPE_CHECKING:  # FMUs of the solver start without pandas
    import pandas as pd

_COLUMNS = {"travel": "mm", "force": "kN", "work": "J", "grip": "kN"}
_HEAD = ["phase", *(f"{name} [{unit}]" for name, unit in _COLUMNS.items())]
#: Names of the phases.
PHASES = ("withdraw", "release", "eject")
_FIGURES, _TEXTS = ("energy_balance", "slip_regularisation"), ("how", "status", "message")
#: Largest number of rows and bytes of a file that is read back.
_ROWS, _BYTES = 100_000, 20_000_000


@dataclass(frozen=True)
class EjectionResult:
    """Force against travel, first while the punch is withdrawn, then while the ejector pushes."""

    #: ``"ejector"`` or ``"stripper"``.
    how: str
    #: ``"withdraw"`` (the punch), ``"release"`` (the stripper goes back) or ``"eject"``, one entry an
    #: increment.
    phase: tuple[str, ...]
    #: Of the tool that moves in the phase, from its start in the phase [mm], shape (n,).
    travel: FloatArray
    #: Of that tool, positive against its motion [kN]: negative where the workpiece, springing back, drives
    #: it, shape (n,).
    force: FloatArray
    #: Of that tool in the phase so far [J], shape (n,).
    work: FloatArray
    #: Axial force that the friction of the tools at rest can carry, mu times the contact force [kN], shape
    #: (n,).
    grip: FloatArray
    #: Where the tools hold the product once the punch is free.
    patches: tuple[GripPatch, ...]
    #: Loads at the material markers; its `stroke` is the travel of all phases together.
    contact: ContactHistory | None = None
    #: (plastic + friction + elastic + contact springs) / external - 1 over forming and ejection.
    energy_balance: float = 0.0
    #: v0 of the friction law that the solver needed, as a share of the tool speed; the friction of parts that
    #: slip slower than this is not all used.
    slip_regularisation: float = 0.02
    #: ``"ok"``, or ``"stopped"`` and where and why.
    status: str = "ok"
    message: str = ""

    def of_phase(self, phase: str) -> np.ndarray:
        """Return which entries belong to a phase, shape (n,)."""
        return np.array([p == phase for p in self.phase], dtype=bool)

    def largest(self, phase: str) -> float:
        """Return the highest force of a phase, averaged over 0.5 mm of travel [kN]; 0 where nothing resists."""
        on = self.of_phase(phase)
        return max(0.0, float(averaged(self.travel[on], self.force[on]).max(initial=0.0)))

    @property
    def max_force(self) -> float:
        """Highest force of the step asked for: of the ejector, or of the punch in the stripper [kN]."""
        return self.largest("eject" if self.how == "ejector" else "withdraw")

    @property
    def total_work(self) -> float:
        """Work against the grip, what the springing back gives to the punch not counted [J]."""
        parts = []
        for phase in dict.fromkeys(self.phase):
            on = self.of_phase(phase)
            travel, force = np.append(0.0, self.travel[on]), np.maximum(self.force[on], 0.0)
            parts.append(float(np.trapezoid(np.append(force[0], force), travel)))
        return sum(parts)

    def to_frame(self) -> pd.DataFrame:
        """Return phase, travel [mm], force [kN], work [J] and grip [kN] as a table."""
        import pandas as pd

        return pd.DataFrame({"phase": list(self.phase)} | {name: getattr(self, name) for name in _COLUMNS})


def save_ejection(result: EjectionResult, folder: Path) -> None:
    """Write ``ejection.csv`` and ``ejection.json`` into a folder."""
    with (folder / "ejection.csv").open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(_HEAD)
        numbers = zip(*(getattr(result, name) for name in _COLUMNS))
        writer.writerows([phase, *(f"{v:.9g}" for v in row)] for phase, row in zip(result.phase, numbers))
    found: dict[str, object] = {name: getattr(result, name) for name in (*_TEXTS, *_FIGURES)}
    found |= {"max_force": result.max_force, "total_work": result.total_work}
    write_json(folder / "ejection.json", found | {"patches": [asdict(p) for p in result.patches]})


def load_ejection(folder: Path) -> EjectionResult | None:
    """Read what `save_ejection` wrote, without the contact history; None where there is none.

    Raises ValueError, KeyError, TypeError, OSError: the files hold something else.
    """
    table, about = folder / "ejection.csv", folder / "ejection.json"
    if not table.is_file() and not about.is_file():
        return None
    if max(table.stat().st_size, about.stat().st_size) > _BYTES:
        raise ValueError("the files of the ejection are too large")
    try:
        with table.open(encoding="utf-8", newline="") as stream:
            rows = list(csv.reader(stream))
    except csv.Error as error:
        raise ValueError(f"ejection.csv: {error}") from None
    if not rows or rows[0] != _HEAD or len(rows) > _ROWS or any(len(row) != len(_HEAD) for row in rows):
        raise ValueError("ejection.csv holds other columns or rows")
    if not {row[0] for row in rows[1:]} <= set(PHASES):
        raise ValueError(f"ejection.csv holds a phase that is none of {', '.join(PHASES)}")
    numbers = np.array([[float(v) for v in row[1:]] for row in rows[1:]]).reshape(-1, len(_COLUMNS))
    given = json.loads(about.read_text(encoding="utf-8"))
    try:
        patches = tuple(
            GripPatch(str(p.pop("tool")), **{k: float(v) for k, v in p.items()}) for p in given["patches"]
        )
        figures: dict[str, Any] = {name: float(given[name]) for name in _FIGURES}
    except OverflowError:
        raise ValueError("ejection.json holds a number that is too large") from None
    found = [*figures.values(), *(v for p in patches for v in list(vars(p).values())[1:])]
    if not np.isfinite(numbers).all() or not all(map(math.isfinite, found)):
        raise ValueError("the ejection holds numbers that are not finite")
    columns: dict[str, Any] = {name: column.copy() for name, column in zip(_COLUMNS, numbers.T)}
    texts: dict[str, Any] = {name: str(given[name]) for name in _TEXTS}
    phase = tuple(row[0] for row in rows[1:])
    return EjectionResult(phase=phase, patches=patches, **texts, **columns, **figures)
