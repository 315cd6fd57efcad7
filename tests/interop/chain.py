"""Loads -> friction -> meter, as a system for SSP, and what comes out at its end."""

from __future__ import annotations

from friction_models.loads import LOADS, FloatArray
from orchestrator import System

from .comparing import PRINTED, Case, Result, compared
from .running import Outcome
from .subjects import SCALE, STEP, STEPS, Subjects


def chain(case: Case, subjects: Subjects) -> System:
    """Return loads -> friction -> meter; what friction has in step k comes from the source after step k - 1."""
    n = case.points
    return System.from_dict(
        {
            "name": "chain",
            "communication_step": STEP,
            "stop_time": STEP * STEPS,
            "components": {
                "source": {"fmu": str(subjects.source(n))},
                "friction": {"fmu": str(subjects.friction(case.model, case.fmi, n))},
                "meter": {"fmu": str(subjects.meter(n))},
            },
            "connections": [f"source.{q.name} -> friction.{q.name}" for q in LOADS]
            + ["friction.mu -> meter.mu"],
            "record": ["meter.scaled", "friction.mu"],
        }
    )


def delayed(case: Case, outcome: Outcome, expected: FloatArray, tolerance: float = PRINTED) -> Result:
    """Compare after the two steps that mu takes to the meter's output."""
    if outcome.result and "values" in outcome.result:
        values = outcome.result["values"]
        outcome = Outcome({"values": values[1:]}, outcome.seen)
        expected = expected[: len(values) - 1]
    return compared(outcome, expected, tolerance, SCALE)
