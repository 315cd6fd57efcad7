"""Loads, friction and position of the material markers over a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from friction_models.loads import LOAD_NAMES

from ..fe.mesh.shape import FloatArray

if TYPE_CHECKING:  # FMUs of the solver start without pandas
    import pandas as pd


@dataclass(frozen=True)
class ContactHistory:
    """Loads of the material markers at each communication step.

    Attributes
    ----------
    stroke : ndarray, shape (n,)
        End of the step [mm].
    loads : ndarray, shape (n, n_points, 5)
        In the order of the loads contract.
    active : ndarray of bool, shape (n, n_points)
        Whether the marker is in contact; the loads of the others are those of their last contact.
    mu : ndarray, shape (n, n_points)
        Coefficients of friction that acted during the step.
    position : ndarray, shape (n, n_points, 2)
        r, z [mm].
    tau_over_k : ndarray, shape (n, n_points)
        Friction stress over shear yield stress k = kf / sqrt(3) at the end of the step; 0 out of contact.
    errors : ndarray, shape (n, n_points, 5), or None
        How far the loads may be off because of the mesh, in their units: about nine of ten are closer to those of a
        much finer mesh. None: the run was not asked for it.

    Examples
    --------
    One step, two markers, of which the second does not touch a tool:

    >>> from forming import ContactHistory
    >>> loads = np.array([[[5.0, 20.0, 800.0, 0.1, 1.0], [0.0, 20.0, 0.0, 0.0, 1.0]]])
    >>> history = ContactHistory(
    ...     stroke=np.array([0.1]),
    ...     loads=loads,
    ...     active=np.array([[True, False]]),
    ...     mu=np.full((1, 2), 0.08),
    ...     position=np.zeros((1, 2, 2)),
    ...     tau_over_k=np.zeros((1, 2)),
    ... )
    >>> history.to_frame()[["point", "sigma_n", "mu"]].values.tolist()
    [[0.0, 800.0, 0.08]]
    """

    stroke: FloatArray
    loads: FloatArray
    active: npt.NDArray[np.bool_]
    mu: FloatArray
    position: FloatArray
    tau_over_k: FloatArray
    errors: FloatArray | None = None

    def to_frame(self) -> pd.DataFrame:
        """Return one row for each marker in contact at each step."""
        import pandas as pd

        step, point = np.nonzero(self.active)
        columns: dict[str, npt.ArrayLike] = {"stroke": self.stroke[step], "point": point}
        columns |= {name: self.loads[step, point, k] for k, name in enumerate(LOAD_NAMES)}
        if self.errors is not None:
            columns |= {f"{name}_error": self.errors[step, point, k] for k, name in enumerate(LOAD_NAMES)}
        columns |= {"mu": self.mu[step, point], "tau_over_k": self.tau_over_k[step, point]}
        columns |= {"r": self.position[step, point, 0], "z": self.position[step, point, 1]}
        return pd.DataFrame(columns)
