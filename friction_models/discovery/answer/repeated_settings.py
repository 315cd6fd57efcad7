"""How near to one another the tests lie that count as repeats, for texts."""

from __future__ import annotations

import numpy as np

from ...estimation.campaign.binning import BinnedTests
from ...estimation.campaign.settings import SAME_SETTING, in_units
from ...estimation.noise.noise_floor import RepeatsNumbers
from ...estimation.noise.repeats import Repeats, same_settings


class SaidRepeats(RepeatsNumbers):
    """Scatter of repeats, and whether their set points are the same; files of earlier versions do not say it."""

    exact: bool


def said_repeats(campaign: BinnedTests, repeats: Repeats) -> SaidRepeats:
    """Return what files and reports hold of repeats.

    They are exact where the loads of a setting agree as well as a machine meets a set point: a ladder of small steps has settings,
    too, though no two of its tests are at the same loads.
    """
    return {**repeats.to_dict(), "exact": _exact(campaign, repeats)}


def _exact(campaign: BinnedTests, repeats: Repeats) -> bool:
    found = (same_settings(campaign, metadata) for metadata in (True, False))
    groups = next((g for g in found if (len(g), sum(map(len, g))) == (repeats.settings, repeats.tests)), None)
    if groups is None:
        return False
    # no share of the range: what counts as one set point alone
    met = [in_units(name, level, share=0.0) for name, level in campaign.levels.items()]
    return all(np.ptp(level[group]) <= 2.0 for level in met for group in groups)


def settings_text(repeats: RepeatsNumbers) -> str:
    """Return which tests are repeats, in words.

    Examples
    --------
    >>> numbers = {"settings": 14, "tests": 62, "scatter": 0.03, "interval": [0.02, 0.04], "p_value": 0.001}
    >>> settings_text({**numbers, "exact": False})
    '62 tests at 14 settings that agree within 3 % of the range of their loads'
    >>> settings_text({**numbers, "exact": True})
    '62 tests at 14 repeated settings'
    """
    near = repeats.get("exact") is False
    settings = (
        f"settings that agree within {100 * SAME_SETTING:g} % of the range of their loads"
        if near
        else "repeated settings"
    )
    return f"{repeats['tests']} tests at {repeats['settings']} {settings}"
