"""A source of signals as a PythonFMU slave."""

from __future__ import annotations

from .base import SolverSlave
from .signals_solver import SignalsSolver


class SignalsSlave(SolverSlave):
    """See `fmus.slaves.signals_solver`."""

    solver_type = SignalsSolver
