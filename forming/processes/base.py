"""A forming process that runs as a whole with given friction; the base of all processes and of extrusion."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from friction_models.common import InputError
from friction_models.common.ranges import check_range

from ..results.field_recorder import recorder_for
from ..results.local_errors import FINER, local_errors
from ..results.result import FormingResult
from ..tools.elasticity import UNITS, ElasticTools
from .ejection import Ejection, ejection_choice
from .friction_input import Friction
from .lag_warning import lag_warnings
from .run_log import RunLog
from .stepwise import StepwiseProcess


class FormingProcess(StepwiseProcess):
    """A forming process; its parameters are those of `StepwiseProcess` and of the process itself."""

    #: What the last `run` gave; after an error in the friction law, too: what there was until then.
    result: FormingResult | None = None

    def run(
        self,
        friction: Friction = 0.08,
        stroke: float = 20.0,
        progress: Callable[[float], None] | None = None,
        communication_step: float = 0.1,
        snapshots: int | Sequence[float] | None = None,
        eject: bool | str = False,
        with_errors: bool = False,
    ) -> FormingResult:
        """Form a fresh billet by `stroke` [mm].

        Parameters
        ----------
        friction : float or callable
            Coefficient of friction, or ``friction(loads[n, 5], t) -> mu[n]``, evaluated after each
            communication step and used in the next: a lag of one step.
        progress : callable, optional
            Called with the share of the stroke done.
        communication_step : float
            Travel between two evaluations of the friction [mm].
        snapshots : int or sequence of float, optional
            Keep the fields: so many times, evenly from the start to the end, or at these strokes [mm].
        eject : bool or str
            After the stroke, withdraw the punch and get the product off the tools: True, or one of `ejections`.
            `result.ejection` holds what it took; a stroke that stops is not followed by it.
        with_errors : bool
            Run once more with elements two thirds as large, which takes more than twice as long again, and state in
            ``result.contact.errors`` how far the loads at the markers may be off because of the mesh. A callable friction
            is asked by both runs.

        Raises
        ------
        InputError
            An impossible stroke, or friction that is NaN or negative; `result` then holds what there was
            until then.
        """
        check_range(self.name, "stroke", stroke, 1e-3, self.max_stroke, "mm")
        check_range(self.name, "communication_step", communication_step, 1e-4, 10.0, "mm")
        how = ejection_choice(self, eject) if eject else None
        self.start(friction)
        steps = max(1, math.ceil(stroke / communication_step - 1e-9))
        recorder = None if snapshots is None else recorder_for(snapshots, stroke, self.name)
        log = RunLog(self, recorder)
        for k in range(steps):
            mu = self.simulation.state.mu
            log.end = stroke * (k + 1) / steps
            going = self.advance(log.end - self.stroke, log.observe)
            log.add(mu)
            if not going:
                break
            if callable(friction):
                try:
                    self.set_mu(friction(self.loads(), self.time))
                except Exception as error:
                    message = f"stopped at stroke {self.stroke:.3f} mm: {error}"
                    self.result = replace(log.result(), status="stopped", message=message)
                    raise
            if progress is not None:
                progress((k + 1) / steps)
        self.result = replace(log.result(), inputs=self._inputs(friction, communication_step))
        if callable(friction):
            late = lag_warnings(stroke / steps, self.name)
            self.result = replace(self.result, warnings=(*self.result.warnings, *late))
        if with_errors and self.result.status == "ok":
            self.result = self._with_errors(self.result, friction, stroke, communication_step)
        if how is not None and self.result.status == "ok":
            ejection = Ejection(self, how)
            try:
                ejection.run(friction, communication_step)
            finally:
                self.result = replace(self.result, ejection=ejection.result())
        return self.result

    def _inputs(self, friction: Friction, communication_step: float) -> dict[str, float | str]:
        """Return what a result is made with, for its files."""
        mu = "a function of the loads" if callable(friction) else float(friction)
        about = {
            "process": self.name,
            "material": self.material.name,
            "mu": mu,
            "communication_step": communication_step,
        }
        return {**about, **self.numbers, "n_points": self.n_points}

    def _with_errors(
        self, result: FormingResult, friction: Friction, stroke: float, communication_step: float
    ) -> FormingResult:
        """Return the result with the errors of its local loads, or with a sentence why they are not known."""
        other = copy.copy(self)
        other.coarsening = FINER * self.coarsening
        try:
            found = other.run(friction, stroke, communication_step=communication_step)
            reason = "" if found.status == "ok" else found.message
        except InputError as error:
            reason = str(error)
        if reason:
            note = f"{self.name}: errors of the loads are not known; the run with smaller elements: {reason}"
            return replace(result, warnings=(*result.warnings, note))
        ours, finer = result.contact, found.contact
        errors = local_errors(ours.loads, ours.active, (finer.loads, finer.active))
        return replace(result, contact=replace(ours, errors=errors))


class Extrusion(FormingProcess):
    """Extrusion of a billet between a die, a punch and an ejector.

    Parameters
    ----------
    die_outer_diameter : float, optional
        Outer diameter of the die [mm]: it widens elastically; rigid by default.
    punch_length : float, optional
        Length of the punch column [mm], which is shortened by the force; rigid by default.
    press_stiffness : float, optional
        Stiffness of the press [kN/mm]; rigid by default. `stroke` is that of the ram, ahead of the punch.
    tool_modulus : float
        Young's modulus of the tools [GPa].
    """

    elasticity: ElasticTools
    ejector_diameter: float

    def _set_tools(self, elasticity: ElasticTools, ejector_diameter: float | None, opening: float) -> None:
        """Take the elastic tools and the ejector, by default 0.95 of the `opening` [mm] it stands in."""
        self.elasticity = elasticity
        low, high = 0.2 * opening, 0.98 * opening
        self.units |= UNITS
        self.ranges |= elasticity.ranges | {"ejector_diameter": (low, high)}
        if ejector_diameter is not None:
            check_range(self.name, "ejector_diameter", ejector_diameter, low, high, "mm")
        self.ejector_diameter = 0.95 * opening if ejector_diameter is None else ejector_diameter
