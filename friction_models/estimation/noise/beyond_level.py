"""Odd tests that no other test of their coating, or batch, reaches: what they show may be what it does there."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from ...loads import POINT_UNITS
from ...loads.contract import behind
from ..campaign.binned_tests import BinnedTests
from ..campaign.curves import on_scale
from ..campaign.factors import texts_of
from ..campaign.metadata import is_text
from .odd_tests import BEYOND

#: Tests of a level that say how far they reach.
LEAST_OF_LEVEL = 3
#: Columns of a test that are told.
TOLD = 2


def beyond_level_text(campaign: BinnedTests, odd: Collection[str]) -> str:
    """Return in a sentence each which of some tests no other test of their level reaches along a load; empty without any."""
    columns = {n: texts_of(campaign, n) for n in sorted(campaign.system) if is_text(campaign.loads, n)}
    sentences = []
    for name in odd:
        own = campaign.tests.index(name)
        beyond = (_beyond(campaign, column, texts, own) for column, texts in columns.items())
        if found := [text for text in beyond if text][:TOLD]:
            sentences.append(
                f". {name} is the only test of {' and of '.join(found)}: it may show a law that begins there, so repeat it"
            )
    return "".join(sentences)


def _beyond(campaign: BinnedTests, column: str, texts: Sequence[Any], own: int) -> str:
    """Return a level and the load along which a test goes farthest beyond all others of it, in words; empty where it does not."""
    labels = np.array([str(text) for text in texts])
    others = np.flatnonzero((labels == labels[own]) & (np.arange(len(labels)) != own))
    if len(others) < LEAST_OF_LEVEL:
        return ""
    most, said = BEYOND, ""
    for load, level in campaign.levels.items():
        z, reached, unit = on_scale(load, level), level[others], behind(POINT_UNITS[load])
        size = max(float(np.ptp(z)), 1e-300)
        above, below = (z[own] - z[others].max()) / size, (z[others].min() - z[own]) / size
        if above > most:
            most, said = above, f"{column} {labels[own]} at {load} above {reached.max():.3g}{unit}"
        if below > most:
            most, said = below, f"{column} {labels[own]} at {load} below {reached.min():.3g}{unit}"
    return said
