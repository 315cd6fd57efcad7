"""The forming processes as a PythonFMU slave."""

from __future__ import annotations

from .base import SolverSlave
from .forming_solver import FormingSolver


class FormingSlave(SolverSlave):
    """See `fmus.slaves.forming_solver`."""

    solver_type = FormingSolver
