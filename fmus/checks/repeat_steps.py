"""A few steps of an FMU, to be repeated and compared."""

from __future__ import annotations

import contextlib

import numpy as np

from friction_models.loads import LOAD_NAMES, FloatArray

from ..runtime.fmu_files import UnpackedFmu
from ..runtime.running import RunningFmu

#: Steps of one run.
STEPS = 5


class Play:
    """A few steps of an FMU, with random loads where it is a friction FMU."""

    def __init__(self, fmu: UnpackedFmu) -> None:
        self.outputs = [n for n, v in fmu.variables.items() if v.causality == "output" and v.is_float64]
        experiment = fmu.raw.defaultExperiment
        self.size = 0.01
        with contextlib.suppress(TypeError, ValueError):
            if experiment is not None and float(experiment.stepSize) > 0.0:
                self.size = float(experiment.stepSize)
        self.inputs: list[str] = []
        self.series: FloatArray = np.empty((0, 0))
        if fmu.is_friction:
            points = fmu.contact_points()
            self.inputs = list(LOAD_NAMES)
            rng = np.random.default_rng(2)
            self.series = np.array([random_loads(rng, points).T.ravel() for _ in range(STEPS + 2)])

    def steps(self, fmu: RunningFmu, count: int = STEPS, first: int = 0) -> FloatArray:
        """Make `count` steps from step `first` on, return the outputs, shape (count, outputs)."""
        seen = []
        for k in range(first, first + count):
            if self.inputs:
                fmu.set_real(self.inputs, self.series[k])
            fmu.step(k * self.size, self.size)
            seen.append(fmu.get_real(self.outputs))
        return np.array(seen)


def random_loads(rng: np.random.Generator, count: int) -> FloatArray:
    """Return loads between slow, cold, light and fast, hot, heavy contact, shape (count, 5).

    Examples
    --------
    >>> loads = random_loads(np.random.default_rng(0), 3)
    >>> loads.shape, bool((loads >= 0.0).all())
    ((3, 5), True)
    """
    lower, upper = [0.0, 20.0, 100.0, 0.0, 0.8], [600.0, 500.0, 3000.0, 80.0, 25.0]
    return rng.uniform(lower, upper, size=(count, 5))
