"""Whether adding the named effects lowers the error on tests that the fit did not see."""

from __future__ import annotations

from typing import Any

from friction_models.common import InputError
from friction_models.discovery import refine
from friction_models.effects import make_effect
from friction_models.loads import DataSet

#: About so many points, every k-th of each test: enough to compare two fits, and quick.
MOST_POINTS = 3000


def confirmed(model: Any, data: DataSet, effects: list[str]) -> dict[str, object] | None:
    """Return what `refine` notes about adding effects: ``before``, ``after``, ``judged_by``.

    None where it cannot be judged: nothing is named, a fixed base (an FMU, a constant), a fault of the data (a
    correction of the data, not of the model), too few tests.

    Parameters
    ----------
    model : FrictionModel or object with ``predict``
        Base of the diagnosis.
    data : DataSet
        What the diagnosis saw.
    effects : list of str
        What it names.
    """
    try:
        if not effects or any(make_effect(e).kind == "fault" for e in effects):
            return None
        step = max(1, len(data.points) // MOST_POINTS)
        place = data.points.groupby("test_id", sort=False).cumcount()
        points = data.points[place % step == 0]
        history = refine(points, data.tests, model=model, add=effects, force=True).error_history_
    except InputError:
        return None
    return dict(history[-1]) if history else None
