"""Variables, model description and configuration of a solver FMU."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from friction_models.loads import Quantity

from ..slaves.core import SolverConfig, SolverFacts
from .description import Description
from .quantities import DeclaredVariable


def signal(
    name: str,
    unit: str,
    meaning: str,
    start: float = 0.0,
    lower: float | None = None,
    upper: float | None = None,
    nominal: float | None = None,
) -> DeclaredVariable:
    """Return an output or input of a solver, not yet numbered.

    Examples
    --------
    >>> signal("F_n", "N", "normal force").unit
    'N'
    """
    return DeclaredVariable(
        name, "", unit=unit, start=start, lower=lower, upper=upper, description=meaning, nominal=nominal
    )


def indexed(q: Quantity, n: int, i: int) -> DeclaredVariable:
    """Return the signal of a quantity at marker `i` of `n`; one marker has no index.

    Examples
    --------
    >>> from friction_models.loads import LOADS
    >>> indexed(LOADS[0], 3, 1).name, indexed(LOADS[0], 1, 0).name
    ('v_rel[2]', 'v_rel')
    """
    name = q.name if n == 1 else f"{q.name}[{i + 1}]"
    return signal(name, q.unit, q.meaning, q.nominal, q.lower, q.upper, q.nominal)


@dataclass(frozen=True)
class SolverInterface:
    """A solver as an FMU.

    Outputs, inputs, parameters, flags and further outputs are numbered in this order: what came later is numbered last, so
    that the numbers of the others stay.

    Examples
    --------
    >>> interface = SolverInterface(
    ...     "signals", "a press", "press", outputs=[signal("F_n", "N", "normal force")], inputs=[], parameters={},
    ...     experiment=(0.1, 1.0),
    ... )
    >>> [(v.name, v.causality, v.unit) for v in interface.variables()]
    [('F_n', 'output', 'N')]
    """

    solver: str  #: ``forming`` or ``twin``.
    title: str
    identifier: str  #: C identifier.
    outputs: Sequence[DeclaredVariable]
    inputs: Sequence[DeclaredVariable]
    parameters: Mapping[str, tuple[str, float]]  #: Name to unit and value.
    experiment: tuple[float, float]  #: Communication step and end of the default experiment [s].
    flags: Sequence[str] = ()  #: Boolean outputs.
    further: Sequence[DeclaredVariable] = ()  #: Outputs that are numbered after all others.
    meanings: Mapping[str, str] = field(default_factory=dict)  #: What the parameters are.
    fixed: SolverFacts = field(default_factory=SolverFacts)  #: What else the solver is told.

    def variables(self) -> list[DeclaredVariable]:
        """Return all variables in file order."""
        # Outputs answer the inputs of the step before: no direct dependence, no algebraic loop for any master.
        computed: dict[str, Any] = {
            "initial": "calculated",
            "depends": (),
            "initial_depends": tuple(self.parameters),
        }
        outputs, further = (
            [replace(s, causality="output", start=None, lower=None, upper=None, **computed) for s in signals]
            for signals in (self.outputs, self.further)
        )
        inputs = [replace(s, causality="input") for s in self.inputs]
        parameters = [
            DeclaredVariable(
                name,
                "parameter",
                "fixed",
                "exact",
                unit=unit,
                start=value,
                description=self.meanings.get(name, ""),
            )
            for name, (unit, value) in self.parameters.items()
        ]
        meaning = "whether the marker is in contact"
        flags = [
            DeclaredVariable(name, "output", "discrete", type="Boolean", description=meaning, **computed)
            for name in self.flags
        ]
        found = [*outputs, *inputs, *parameters, *flags, *further]
        return [replace(v, reference=i) for i, v in enumerate(found)]

    def config(self) -> SolverConfig:
        """Return what the solver is made from; it keeps the further outputs behind the others."""
        reals = [v for v in self.variables() if v.type == "Real"]
        head, last = len(self.outputs), len(reals) - len(self.further)
        reals = [*reals[:head], *reals[last:], *reals[head:last]]
        return {
            **self.fixed,
            "names": [v.name for v in reals],
            "further": len(self.further),
            "first_input": head + len(self.further),
            "first_parameter": head + len(self.further) + len(self.inputs),
            "start": [float(v.start or 0.0) for v in reals],
            "flags": len(self.flags),
        }

    def description(self, target: str) -> Description:
        """Return the model description, without GUID; it is the same for all targets but for where it runs."""
        step, stop = self.experiment
        where = "Python" if target == "python" else "a Python process of its own"
        return Description(
            model_name=self.title,
            identifier=self.identifier,
            guid="",
            text=f"{self.title}; runs in {where} with the package tribofmu",
            variables=self.variables(),
            co_simulation={
                "needsExecutionTool": True,
                "canHandleVariableCommunicationStepSize": True,
                "canInterpolateInputs": False,
                "canBeInstantiatedOnlyOncePerProcess": False,
                "canNotUseMemoryManagementFunctions": True,
                "canGetAndSetFMUstate": True,
                "canSerializeFMUstate": True,
            },
            step=step,
            stop=stop,
            annotations={"target": target},
            warns=True,
        )
