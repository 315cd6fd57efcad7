"""Force, work and contact of a forming run, as numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from friction_models.common.wording import counted

from ..fe.mesh.shape import FloatArray
from .contact_history import ContactHistory
from .ejection_result import EjectionResult
from .fields import FieldHistory
from .force_curve import FORCE_WINDOW, averaged

if TYPE_CHECKING:  # FMUs of the solver start without pandas
    import pandas as pd


@dataclass(frozen=True, repr=False)
class FormingRecord:
    """Numbers of a forming run; arrays have one entry per communication step.

    Attributes
    ----------
    stroke : ndarray, shape (n,)
        Stroke of the ram [mm], starting at 0.
    force : ndarray, shape (n,)
        Punch force [kN].
    work : ndarray, shape (n,)
        Work of the ram so far [J].
    max_tau_over_k : float
        Highest friction stress over shear yield stress k = kf / sqrt(3) in the whole run.
    share_above_0_6k : float
        Share of the contact (area and time) with a friction stress above 0.6 k.
    energy_balance : float
        (plastic + friction + elastic + contact springs) / external - 1.
    volume_change : float
        Relative change of the unloaded volume.
    increments, remeshes, failed_increments : int
        Counts.
    contact : ContactHistory
        Loads at the material markers.
    status, message : str
        ``"ok"``, or ``"stopped"`` and where and why.
    compression, expansion : ndarray, shape (n,)
        Shortening of punch and press, widening of the die [mm]; 0 where the tools are rigid.
    fields : FieldHistory
        Snapshots of the fields, if the run was asked for them.
    heat_balance : float
        Rise of the workpiece's heat + what left it - what arose in it, over the largest of these.
    warnings : tuple of str
        Where the run left the range in which the flow curve is known; it went on with the edge of a table or the
        law's own extension. And friction that lags too far behind the loads.
    ejection : EjectionResult or None
        Forces and work of ejecting the product, if the run was asked for it.
    inputs : dict
        What the run was made with: process, its numbers in their units, material, friction, communication step [mm].
    """

    stroke: FloatArray
    force: FloatArray
    work: FloatArray
    max_tau_over_k: float
    share_above_0_6k: float
    energy_balance: float
    volume_change: float
    increments: int
    remeshes: int
    failed_increments: int
    contact: ContactHistory
    status: str = "ok"
    message: str = ""
    compression: FloatArray = field(default_factory=lambda: np.zeros(0))
    expansion: FloatArray = field(default_factory=lambda: np.zeros(0))
    fields: FieldHistory = field(default_factory=lambda: FieldHistory(()))
    heat_balance: float = 0.0
    warnings: tuple[str, ...] = ()
    ejection: EjectionResult | None = None
    inputs: Mapping[str, float | str] = field(default_factory=dict)

    def __repr__(self) -> str:
        size = f"{counted(max(len(self.stroke) - 1, 0), 'step')} to {self.stroke[-1] if len(self.stroke) else 0.0:g} mm"
        return f"{type(self).__name__}({size}, max_force={self.max_force:.4g} kN, {self.status})"

    @property
    def smooth_force(self) -> FloatArray:
        """Force averaged over 0.5 mm of stroke [kN].

        Surface nodes that pass the roundings of the tools ripple the force by 0.16 % (rms) and up to 0.4 % of its
        maximum at the default mesh; the average leaves 0.07 % and 0.18 % (rod, 20 mm), see `force_ripple`.
        """
        return averaged(self.stroke, self.force)

    def force_ripple(self, smooth: bool = True) -> tuple[float, float]:
        """Return the ripple of the force in the second half of the stroke, as shares of its maximum.

        It is what is left over a fitted polynomial of degree 5; 0 for records below 20 entries.

        Parameters
        ----------
        smooth : bool
            Of `smooth_force`, which `max_force` is read from; else of `force`.

        Returns
        -------
        tuple of float
            Root of the mean square, and largest deviation.
        """
        end = self.stroke[-1]
        late = (self.stroke >= 0.5 * end) & (self.stroke <= end - 0.5 * FORCE_WINDOW)
        if late.sum() < 20 or not self.max_force > 0.0:
            return 0.0, 0.0
        force = (self.smooth_force if smooth else self.force)[late]
        trend = np.polynomial.Chebyshev.fit(self.stroke[late], force, 5)
        left = (force - trend(self.stroke[late])) / self.max_force
        return float(np.sqrt(np.mean(left**2))), float(np.abs(left).max())

    @property
    def max_force(self) -> float:
        """Highest force [kN], read from `smooth_force`."""
        return float(self.smooth_force.max(initial=0.0))

    def to_frame(self) -> pd.DataFrame:
        """Return stroke [mm], force [kN] and work [J] as a table."""
        import pandas as pd

        return pd.DataFrame({"stroke": self.stroke, "force": self.force, "work": self.work})
