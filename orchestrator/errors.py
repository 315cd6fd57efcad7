"""Failures that are not the user's input: a component that stops in the middle of a run."""

from __future__ import annotations

from collections.abc import Sequence

from friction_models.loads import InputError


class SimulationError(RuntimeError):
    """A component failed while the system ran; the message names component, time and cause."""


def collected(where: str, problems: Sequence[str]) -> InputError:
    """Join the problems found in one place into one error, so that all of them are seen at once."""
    if len(problems) == 1:
        return InputError(f"{where}: {problems[0]}")
    listed = "".join(f"\n  {k}. {text}" for k, text in enumerate(problems, 1))
    return InputError(f"{where}: {len(problems)} problems:{listed}")
