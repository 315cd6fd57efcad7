"""Settings of a plan: tests at about the same loads, which are one witness of a law."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
import numpy.typing as npt

from ...loads import FloatArray
from ...loads.splits import Mask

#: Test means of a load that lie closer than this share of their range are the same setting.
SAME_SETTING = 0.03
#: So are those that agree to this share of their size: set points are not met better.
AS_SET = 0.01
#: Loads that a machine holds: a standard deviation below `AS_SET` is its control. A small change of T [degC] or psi may matter.
HELD = ("v_rel", "sigma_n", "sd")
#: What counts as the same temperature [K].
SAME_TEMPERATURE = 1.5
#: A contact warms up while its set points stay: within this share of the range of its temperatures it is one setting.
WARMS = 0.15
#: With fewer settings, or where fewer tests share one, every test stands for itself: in a random plan some are near by chance.
LEAST_SETTINGS, LEAST_SHARED = 16, 0.5

Indexes = npt.NDArray[np.intp]


def varies(name: str, values: FloatArray, averaged: bool) -> bool:
    """Return whether a load takes more than one value, beyond what a machine makes of one set point.

    `values`, shape (m,), are averages. A distance counts as set where every test is `averaged`: along a
    test it grows.
    """
    if not np.ptp(values) > 1e-9 * max(1.0, float(np.max(np.abs(values)))):
        return False
    if name not in HELD or (name == "sd" and not averaged):
        return True
    return not is_held(name, values)


def is_held(name: str, values: FloatArray) -> bool:
    """Return whether values of a load scatter no more than where a machine, or a room, holds it."""
    spread = float(np.std(values))
    return spread <= (SAME_TEMPERATURE if name == "T" else AS_SET * abs(float(np.mean(values))))


def in_units(name: str, means: FloatArray, share: float = SAME_SETTING) -> FloatArray:
    """Return the means of a load over each test, in units of what counts as the same: a share of their range, or more."""
    as_set = SAME_TEMPERATURE if name in {"T", "T_tool"} else AS_SET * float(np.max(np.abs(means)))
    # levels of a plan often lie powers of ten apart
    if name in {"v_rel", "sigma_n", "psi"} and means.min() > 0.0:
        means, as_set = np.log(means), AS_SET
    return np.asarray(means / max(share * float(np.ptp(means)), as_set, 1e-12))


def same_pairs(columns: Iterable[FloatArray], tests: int) -> Mask:
    """Return which tests agree in all columns in units of what counts as the same, shape (tests, tests)."""
    same = np.ones((tests, tests), dtype=bool)
    for column in columns:
        same &= np.abs(column[:, None] - column) <= 1.0
    return same


def setting_of_tests(means: Mapping[str, FloatArray], place: Indexes) -> Indexes:
    """Return the setting of each test, numbered in an order of the tests.

    Tests at the same set points, one after the other while the contact warms up, share what a formula gets wrong there: as
    evidence for a law they are one, and left out together, else the others of a setting give away what it holds (Roberts et al.,
    Ecography 40 (2017) 913).

    `means`, shape (tests,) each, are those of the loads that were set; of temperatures ``T_tool`` where it is known, else ``T``.
    The `place` of each test in the order, shape (tests,), is returned where every test stands for itself.
    """
    if not means:
        return place
    columns = [in_units(n, m, WARMS if n == "T" else SAME_SETTING) for n, m in means.items()]
    same, setting, count = same_pairs(columns, len(place)), np.full(len(place), -1), 0
    for k in np.argsort(place):
        if setting[k] < 0:
            setting[same[k] & (setting < 0)] = count
            count += 1
    shared = float(np.mean(np.bincount(setting)[setting] > 1))
    return setting if count >= LEAST_SETTINGS and shared >= LEAST_SHARED else place
