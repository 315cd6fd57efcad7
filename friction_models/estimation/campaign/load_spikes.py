"""Single readings of a load that no machine can have had: one point far off its neighbours."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ...loads import FloatArray, TriboLoads
from .cleaning import lone_points, lone_text, median_of_five

#: Loads that are searched, and the value [in their unit] below which a reading counts as this one; distance only grows, and says itself.
SEARCHED = {"v_rel": 0.0, "T": 100.0, "sigma_n": 0.0, "psi": 0.0}
#: Share of its value by which a reading is off, at least: less, a load may jump by within a point.
OFF = 0.5
#: A speed that reads low is wrong if the way from the point before to the one after is at least this share of what the neighbours say.
TRAVELLED = 0.75


def without_load_spikes(
    loads: TriboLoads, names: npt.NDArray[np.str_], warnings: list[str]
) -> tuple[TriboLoads, npt.NDArray[np.bool_]]:
    """Return loads with single readings far off their neighbours replaced by the median of five, and at which points, shape (n,).

    The slope along a load hangs on its outermost values: three readings of 960 that were a hundred times too large hid a Stribeck
    effect. Steps, ramps and what a load does for two points or more pass unchanged, and a rest, in which nothing slides.

    Examples
    --------
    >>> T = np.r_[np.full(6, 80.0), 1500.0, np.full(6, 80.0)]
    >>> one = np.ones(13)
    >>> said = []
    >>> cleaned, where = without_load_spikes(TriboLoads(50 * one, T, 500 * one, one, one), np.full(13, "a"), said)
    >>> float(cleaned.T.max()), int(where.sum()), said
    (80.0, 1, ['taken from their neighbours, far off them: T at 1 single point (test a)'])
    """
    cleaned: dict[str, Any] = {}
    anywhere = np.zeros(len(loads), dtype=bool)
    for name, least in SEARCHED.items():
        values = np.asarray(getattr(loads, name), dtype=np.float64)
        if name in loads.absent or np.ptp(values) == 0.0:
            continue
        middle = median_of_five(values)
        spike = lone_points(values, middle, names, OFF * np.maximum(np.abs(middle), least))
        if name == "v_rel":
            spike &= (values > middle) | _slides(loads, middle)
        if spike.any():
            cleaned[name] = np.where(spike, middle, values)
            anywhere |= spike
            warnings.append(f"taken from their neighbours, far off them: {name} at {lone_text(spike, names)}")
    return (replace(loads, **cleaned) if cleaned else loads), anywhere


def _slides(loads: TriboLoads, speed: FloatArray) -> npt.NDArray[np.bool_]:
    """Return where the contact slides on about as fast as the neighbours of a point say, shape (n,); nowhere where that is not recorded."""
    slides = np.zeros(len(loads), dtype=bool)
    if loads.t is None or "sd" in loads.absent:
        return slides
    way, time = loads.sd[2:] - loads.sd[:-2], loads.t[2:] - loads.t[:-2]
    slides[1:-1] = (way > 0.0) & (way >= TRAVELLED * speed[1:-1] * time)
    return slides
