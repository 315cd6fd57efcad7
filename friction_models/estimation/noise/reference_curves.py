"""Smooth curves along what tells points or tests apart, and products of two: what the flexible reference is made of."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ...loads import FloatArray
from ...loads.contract import ORDER
from ..campaign.binned_tests import BinnedTests
from ..campaign.curves import products, scaled_loads
from ..campaign.metadata import MOST_LEVELS, MOST_METADATA, is_text
from .histories import histories

#: Places along a load or along metadata between which a curve may bend.
PLACES = 6
#: The same along the distance, where friction changes fast at first.
DISTANCE_PLACES = 8
#: Distance, in standard deviations of a load, over which a curve keeps its value.
REACH, DISTANCE_REACH = 0.8, 0.4
#: Places along a load, distance, and share of the variance of what bends within a short distance.
WAVY_PLACES, WAVY_REACH, WAVES = 14, 0.25, 0.2
#: The same in the order of the tests.
ORDER_PLACES, ORDER_WAVES = 24, 0.5
#: Directions of each of two curves that their product uses.
IN_PRODUCTS = 3
#: The same where one of them runs along metadata; of so many columns of metadata, those with the fewest levels first.
WITH_METADATA, METADATA_IN_PRODUCTS = 2, 4
#: Directions of the levels of a text: with fewer than it takes to tell them apart, those with the fewest tests have no products.
OF_LEVELS = 5
#: Metadata that agrees with a load by more than this correlation over the tests is that load.
SAME_AS_LOAD = 0.999


@dataclass(frozen=True)
class Curves:
    """Curves along one quantity, or products of those along two."""

    of: tuple[int, ...]  #: Places of the quantities in `Reference.names`.
    columns: FloatArray  #: Shape (m, k).


def reference_curves(
    campaign: BinnedTests, without: Collection[str]
) -> tuple[list[str], list[Curves], range]:
    """Return the quantities that tell points or tests apart, curves along them and products, and the places of metadata.

    Names do not tell metadata from loads: a test table may state the nominal speed as ``v_rel``. It is `without` some metadata.
    """
    names: list[str] = []
    columns: list[FloatArray] = []
    means: list[FloatArray] = []

    def level(values: FloatArray) -> FloatArray:
        mean = campaign.of_tests(values)
        return np.asarray((mean - mean.mean()) / max(float(mean.std()), 1e-300))

    for name, values in scaled_loads(campaign).items():
        along = name == "sd" and campaign.path is campaign.distance
        names.append("distance" if along else name)
        columns.append(_smooth(values, WAVY_PLACES, DISTANCE_REACH if along else REACH, WAVES))
        means.append(level(values))
    if "distance" not in names and not campaign.averaged:  # the number of the point, then
        distance = np.sqrt(campaign.average(campaign.distance))
        names.append("distance")
        columns.append(_smooth(distance, DISTANCE_PLACES, DISTANCE_REACH))
    mains = len(names)
    for name, values in histories(campaign).items():
        names.append(name)
        columns.append(_smooth(values, DISTANCE_PLACES, DISTANCE_REACH))
    levels_of, texts = dict[int, int](), set[int]()
    first = len(names)
    # what numbers the tests first, so that a date or a time that says the same is left out beside it
    for name in sorted(set(campaign.system).difference(without), key=lambda n: (n != ORDER, n)):
        values = campaign.metadata(name)
        known = level(values)
        same = any(abs(float(known @ m)) > SAME_AS_LOAD * len(known) for m in means)
        levels = np.unique(values)
        if same or len(levels) < 2 or len(levels_of) == MOST_METADATA:
            continue
        if name == "batch" or is_text(campaign.loads, name):
            if len(levels) > MOST_LEVELS * len(campaign.tests):
                continue
            block = (values[:, None] == levels[None, :]).astype(float)
            texts.add(len(names))
        else:
            # in the order of the tests, what nobody recorded may come and go several times
            places, waves = (ORDER_PLACES, ORDER_WAVES) if name == ORDER else (PLACES, 0.0)
            block = _smooth(values, min(places, len(levels)), REACH, waves)
            means.append(known)
        levels_of[len(names)] = len(levels)
        names.append(name)
        columns.append(block)
    found = [Curves((k,), c) for k, c in enumerate(columns)]
    leading = [_leading(c) for c in columns]
    found += [Curves((a, b), products(leading[a], leading[b])) for a, b in combinations(range(mains), 2)]
    alone = [block[:, :1] for block in leading[:mains]]
    found += [
        Curves((a, b, c), products(products(alone[a], alone[b]), alone[c]))
        for a, b, c in combinations(range(mains), 3)
    ]
    for b in sorted(levels_of, key=lambda k: levels_of[k])[:METADATA_IN_PRODUCTS]:
        few = _leading(columns[b], OF_LEVELS if b in texts else WITH_METADATA)
        found += [Curves((a, b), products(leading[a][:, :WITH_METADATA], few)) for a in range(mains)]
    return names, found, range(first, len(names))


def _smooth(values: FloatArray, places: int, reach: float, waves: float = 0.0) -> FloatArray:
    """Return columns whose random combinations are smooth curves of variance about one, and a straight line.

    The share `waves` of the variance bends within `WAVY_REACH`.
    """
    z = (values - values.mean()) / max(float(values.std()), 1e-300)
    at = np.unique(np.quantile(z, np.linspace(0.0, 1.0, places)).round(9))

    def kernel(a: FloatArray) -> FloatArray:
        apart = a[:, None] - at[None, :]
        smooth, wavy = (np.exp(-0.5 * (apart / r) ** 2) for r in (reach, WAVY_REACH))
        return np.asarray((1.0 - waves) * smooth + waves * wavy)

    root = np.linalg.inv(np.linalg.cholesky(kernel(at) + 1e-6 * np.eye(len(at))))
    return np.column_stack([z, kernel(z) @ root.T])


def _leading(columns: FloatArray, most: int = IN_PRODUCTS) -> FloatArray:
    """Return the strongest directions of a block of curves, shape (m, at most `most`)."""
    centred = columns - columns.mean(axis=0)
    u, s, _ = np.linalg.svd(centred, full_matrices=False)
    kept = s[:most] > 1e-6 * s[0]
    return np.asarray(u[:, :most][:, kept] * s[:most][kept])
