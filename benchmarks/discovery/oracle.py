"""What nobody could see: how clearly a hidden part stands out for one who knows everything but its size.

The oracle knows the form of the hidden effect, its shape parameters and the statistics of the noise, and asks for this
effect alone, beside a linear law of the measured loads. Its generalised least squares estimate of the size divided by
its standard error is normal around `clarity` with a standard deviation of one; no diagnosis has more to go by.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import norm

from friction_models.discovery.judge.verdict import LEVEL
from friction_models.effects import CATALOGUE

from .form_sets import SETS
from .generator import DRIFT, DRIFT_LENGTH, SCATTER, Made, sensor

LOADS = ["v_rel", "T", "sigma_n", "sd", "psi"]


def clarity(made: Made, noise: float, forms: str) -> float:
    """Return the expected size of the hidden part of the training tests over its standard error, for plain noise.

    Parameters
    ----------
    made : Made
        A campaign with plain noise.
    noise : float
        Its noise level.
    forms : str
        Its set of forms.
    """
    train = made.points["test_id"].isin(made.tests.loc[made.tests["role"] == "train", "test_id"]).to_numpy()
    points = made.points[train].reset_index(drop=True)
    loads = points[LOADS].to_numpy()
    around = (loads - loads.mean(axis=0)) / np.maximum(loads.std(axis=0), 1e-9)
    columns = np.column_stack([np.ones(len(loads)), around, made.part[train]])
    normal = np.zeros((columns.shape[1],) * 2)
    for rows in points.groupby("test_id").indices.values():
        apart = np.abs(np.subtract.outer(rows, rows)) * SETS[forms].spacing
        own = np.eye(len(rows)) * sensor(float(points["v_rel"].iloc[rows[-1]])) ** 2
        covariance = noise**2 * (SCATTER**2 + DRIFT**2 * np.exp(-apart / DRIFT_LENGTH) + own)
        normal += columns[rows].T @ np.linalg.solve(covariance, columns[rows])
    base = normal[:-1, :-1]
    free = normal[-1, -1] - normal[-1, :-1] @ np.linalg.lstsq(base, normal[:-1, -1], rcond=1e-12)[0]
    return float(np.sqrt(max(free, 0.0)))


def power(clear: float) -> float:
    """Return how often the oracle finds an effect of this clarity, with as many effects to try as the catalogue has.

    It calls an effect there at the rate of false alarms at which the diagnosis does.
    """
    return float(norm.cdf(clear - norm.isf(LEVEL / len(CATALOGUE))))
