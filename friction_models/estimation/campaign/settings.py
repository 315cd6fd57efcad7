"""Settings of a plan: tests at about the same loads."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import numpy.typing as npt

from ...loads import LOAD_NAMES, FloatArray
from .metadata import MOST_LEVELS, is_text

if TYPE_CHECKING:
    from .binning import Campaign

#: Test means of a load that lie closer than this share of their range are the same setting.
SAME_SETTING = 0.03
#: So are those that agree to this share of their size: set points are not met better.
AS_SET = 0.01
#: The same for temperatures [K].
SAME_TEMPERATURE = 1.5
#: A contact warms up while its set points stay: within this share of the range of its temperatures it is one setting.
WARMS = 0.15
#: With fewer settings, or where fewer tests share one, every test stands for itself: in a random plan some are near by chance.
LEAST_SETTINGS, LEAST_SHARED = 20, 0.5

Indexes: TypeAlias = npt.NDArray[np.intp]


def same_settings(campaign: Campaign, metadata: bool = True) -> list[Indexes]:
    """Return groups of tests with the same mean loads and, with `metadata`, the same levels of it, at least two in each."""
    columns, tests = [_setting(campaign, n) for n in _varied(campaign)], len(campaign.tests)
    for name in sorted(campaign.system) if metadata else ():
        values = campaign.of_tests(campaign.average(campaign.system[name][:, 0]))
        if is_text(campaign.loads, name):
            columns.append(values / 1e-9)  # another level is another setting
        elif len(np.unique(values)) <= MOST_LEVELS * tests:  # else measured anew in each test
            columns.append(values / max(SAME_SETTING * float(np.ptp(values)), 1e-9))
    if not columns:
        return [np.arange(tests)]
    means = np.column_stack(columns)
    groups: list[Indexes] = []
    left = np.lexsort(means.T[::-1])
    while len(left):
        near = np.all(np.abs(means[left] - means[left[0]]) <= 1.0, axis=1)
        if near.sum() > 1:
            groups.append(left[near])
        left = left[~near]
    return groups


def _varied(campaign: Campaign) -> list[str]:
    return [n for n in LOAD_NAMES if n not in campaign.absent and campaign.varies(n)]


def _setting(campaign: Campaign, name: str, share: float = SAME_SETTING) -> FloatArray:
    """Return the means of a load over each test, in units of what counts as the same: a share of their range, or more."""
    values = campaign.distance if name == "sd" else getattr(campaign.loads, name)
    means = campaign.of_tests(campaign.average(values))
    as_set = SAME_TEMPERATURE if name == "T" else AS_SET * float(np.max(np.abs(means)))
    if (
        name in {"v_rel", "sigma_n", "psi"} and means.min() > 0.0
    ):  # levels of a plan often lie powers of ten apart
        means, as_set = np.log(means), AS_SET
    return np.asarray(means / max(share * float(np.ptp(means)), as_set, 1e-12))


def setting_of_tests(campaign: Campaign) -> Indexes:
    """Return the setting of each test, numbered in the order of their loads.

    Tests at the same set points, one after the other while the contact warms up, share what a formula gets wrong there: as
    evidence for a law they are one, and left out together, else the others of a setting give away what it holds (Roberts et al.,
    Ecography 40 (2017) 913).
    """
    averaged = campaign.count.size == len(campaign.tests)
    set_points = [n for n in _varied(campaign) if n != "T" and (averaged or n != "sd")]
    columns = [_setting(campaign, n) for n in set_points]
    if "T" in _varied(campaign):
        columns.append(_temperature(campaign))
    if not columns:
        return campaign.place
    at, setting, count = np.column_stack(columns), np.full(len(campaign.tests), -1), 0
    for k in np.argsort(campaign.place):
        if setting[k] < 0:
            near = np.all(np.abs(at - at[k]) <= 1.0, axis=1)
            setting[near & (setting < 0)] = count
            count += 1
    shared = float(np.mean(np.bincount(setting)[setting] > 1))
    return setting if count >= LEAST_SETTINGS and shared >= LEAST_SHARED else campaign.place


def _temperature(campaign: Campaign) -> FloatArray:
    """Return the temperature that was set for each test, else that of its contact, in units of what counts as the same."""
    if "T_tool" not in campaign.system:
        return _setting(campaign, "T", WARMS)
    tool = campaign.of_tests(campaign.average(campaign.system["T_tool"][:, 0]))
    return np.asarray(tool / max(SAME_SETTING * float(np.ptp(tool)), SAME_TEMPERATURE))
