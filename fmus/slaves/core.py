"""The solvers behind the solver FMUs, without FMI: variables in one array, start, step, save, restore."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np

from friction_models.loads import FloatArray


class Solver(ABC):
    """A solver whose Real variables are one array: outputs first, then inputs, then parameters.

    Two hosts drive it: the PythonFMU slave in the simulator's interpreter, and `fmus.slaves.server` in a
    process of its own. A solver sets `process`, an object with `snapshot` and `restore`.

    Parameters
    ----------
    config : dict
        Names (`names`), start values (`start`), places of the first input and the first parameter
        (`first_input`, `first_parameter`), number of Boolean outputs (`flags`), and what the solver
        itself needs; as `fmus.solver_fmus` writes it.

    Attributes
    ----------
    values : numpy.ndarray
        All Real variables.
    flags : numpy.ndarray of bool
        Boolean outputs.
    """

    process: Any = None

    def __init__(self, config: dict[str, Any]) -> None:
        self.config = config
        self.names: list[str] = config["names"]
        self.first_input: int = config["first_input"]
        self.first_parameter: int = config["first_parameter"]
        self.values: FloatArray = np.array(config["start"], dtype=np.float64)
        self.flags = np.zeros(config["flags"], dtype=bool)

    @abstractmethod
    def start(self) -> None:
        """Build the process from `parameters()` and publish its outputs."""

    @abstractmethod
    def advance(self, elapsed: float, step: float) -> None:
        """Advance from `elapsed` [s] since the start by `step` [s] and publish; raise to refuse the step."""

    def parameters(self) -> dict[str, float]:
        """Return the parameters by name."""
        return dict(zip(self.names[self.first_parameter :], self.values[self.first_parameter :].tolist()))

    def inputs(self) -> FloatArray:
        """Return the inputs in order of their value references."""
        return self.values[self.first_input : self.first_parameter]

    def save(self) -> Any:
        """Return a copy of the whole state; `restore` continues from it exactly."""
        # The process is part of it: another one, with other parameters, may run when the state comes back.
        return self.values.copy(), self.flags.copy(), self.process, self.process.snapshot()

    def restore(self, saved: Any) -> None:
        """Go back to what `save` returned, exactly; it can be used again."""
        values, flags, process, snapshot = saved
        self.values[:], self.flags[:] = values, flags
        self.process = process
        self.process.restore(snapshot)
