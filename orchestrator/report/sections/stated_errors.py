"""Stated errors of the loads at the contact points, as a part of reports of runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from friction_models.common.markup import table
from friction_models.loads.contract import with_unit

from ...cosim.local_errors import FILE, FINER, StatedError


def stated_errors_table(errors: Mapping[str, Sequence[StatedError]]) -> str:
    """Return the table of the stated errors of runs by name; empty where none were asked for."""
    if not any(errors.values()):
        return ""
    named = len(errors) > 1
    return table(
        [
            *(["model"] if named else []),
            "load",
            "median of the load",
            "its error, median",
            "9 of 10 errors are below",
        ],
        [
            (
                *([label] if named else []),
                with_unit(e.load),
                f"{e.middle:.3g}",
                f"{e.usual:.2g}",
                f"{e.high:.2g}",
            )
            for label, found in errors.items()
            for e in found
        ],
        numeric=range(1 + named, 4 + named),
        caption="How far the loads at the contact points may be off because of the size of the elements, from a further run with "
        f"elements {FINER:.2g} times as large: about nine of ten are closer than their stated error to those of a mesh four times as fine. "
        "Communication steps, material and heat data add errors of their own. Each point and time stands in "
        f"{FILE} of the run.",
    )
