"""Structure that no effect of the catalogue explains: a functional analysis of variance of the residual.

Curves along each load and products of curves of two loads are fitted to the whitened remainder; each block
is compared with what it would fit in pure noise (functional ANOVA; Hooker, J. Comput. Graph. Stat. 16 (2007)).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple, TypedDict

import numpy as np

from ...loads import LOAD_NAMES, FloatArray
from ...loads.contract import ORDER
from ..campaign.binned_tests import BinnedTests
from ..campaign.curves import curve, curve_along, products, scaled_loads, spline_columns, transformed
from ..campaign.metadata import is_text
from .scan import Fit, Projector
from .search_round import SearchRound
from .significance import null_noise

REPLICATES = 399
#: A surface over two loads must follow this much more of a difference than a curve along one of them, and than both curves; all
#: adjusted for their columns.
INTERACTION, PRODUCTS = 0.15, 0.05
#: Places at which curves may bend, that are fitted to measurements, and to what the reference, which may be wavy, predicts otherwise.
KNOTS, WAVY_KNOTS = 3, 5
#: The same in the order of the tests: what nobody recorded may come and go several times.
ORDER_KNOTS = 12
#: Metadata with so few values are levels, whatever lies between them.
MOST_LEVELS_APART = 4
#: Share of a difference of two predictions that each place must follow which is told of it: of the first, and of the second. What is
#: left beside the first one holds most of the chance, and smaller shares of it lie along loads that say nothing.
LEAST_OF_PLACES = (0.1, 0.2)
#: Surfaces that leave less than this share of all numbers free follow anything.
LEAST_FREE = 0.5
#: Columns of each of two curves whose products are a surface.
IN_SURFACES = 3


class StructurePlace(TypedDict):
    """Where structure is left.

    The loads along which it shows, the range of each in which it is strong, its shape in words, and its share of what is
    left.
    """

    variables: list[str]
    region: dict[str, list[float]]
    shape: str
    share: float


@dataclass
class Structure:
    """What a flexible model finds beyond base and effects."""

    excess: float  #: Whitened squared signal of the strongest block beyond what noise gives.
    p_value: float  #: Family-wise over the blocks.
    rms: float  #: RMS of this signal in mu.
    where: list[StructurePlace]  #: Blocks that stand out.


@dataclass(frozen=True)
class Misfit:
    """How far the residual still bends along the loads of the winner."""

    excess: float = 0.0  #: Whitened squared signal beyond what noise gives.
    p_value: float = 1.0


def own_misfit(campaign: BinnedTests, found: SearchRound, fit: Fit, signal: FloatArray, seed: int) -> Misfit:
    """Test whether curves along the loads of an effect fit the residual better than noise does.

    `signal`, shape (m, k), are whitened columns of all effects found.
    """
    columns = spline_columns(campaign, fit.effect.driver)
    project = Projector(np.column_stack([found.whiten(found.columns), signal]))
    q = Projector(project(found.whiten(columns))).q if columns.shape[1] else columns
    if not q.shape[1]:
        return Misfit()
    residual = project(found.residual)
    drop = float(np.sum((q.T @ residual) ** 2))
    null = np.sum((q.T @ _noise(campaign, found, residual, seed, project.q)) ** 2, axis=0)
    return Misfit(drop - float(null.mean()), (1 + int(np.sum(null >= drop))) / (1 + REPLICATES))


def _noise(
    campaign: BinnedTests, found: SearchRound, residual: FloatArray, seed: int, fitted: FloatArray
) -> FloatArray:
    """Return whitened data in which nothing of a residual is missing, shape (m, replicates); `fitted` as of `null_noise`."""
    setting, level = campaign.setting[campaign.test], found.whiten(np.ones(len(found.y)))
    rng = np.random.default_rng([seed, 77])
    return null_noise(residual, level, setting, found.freedom, rng, REPLICATES, fitted)


def find_structure(campaign: BinnedTests, found: SearchRound, signal: FloatArray, seed: int) -> Structure:
    """Look for structure beyond the base and the whitened columns `signal` of the effects found, shape (m, k); k may be 0."""
    curves = _curves(campaign)
    blocks: dict[tuple[str, ...], FloatArray] = {(n,): curves[n] for n in curves}
    for a, b in combinations(curves, 2):
        blocks[(a, b)] = _with_products(curves[a], curves[b])
    base = np.column_stack([found.whiten(found.columns), signal])
    project = Projector(base)
    residual = project(found.residual)
    data = np.column_stack([residual, project(_noise(campaign, found, residual, seed, project.q))])
    scores, fits, excess = [], {}, {}
    for key, columns in blocks.items():
        q = Projector(project(found.whiten(columns))).q
        if not q.shape[1]:
            continue
        drop = np.sum((q.T @ data) ** 2, axis=0)
        scores.append((drop - q.shape[1]) / np.sqrt(2.0 * q.shape[1]))
        fits[key], excess[key] = q, float(drop[0] - q.shape[1])
    if not scores:
        return Structure(0.0, 1.0, 0.0, [])
    table = np.array(scores)
    null = table[:, 1:].max(axis=0)
    p = float((1 + np.sum(null >= table[:, 0].max())) / (1 + REPLICATES))
    keys = list(fits)
    significant = [
        k
        for k in np.argsort(-table[:, 0])
        if (1 + np.sum(null >= table[k, 0])) / (1 + REPLICATES) < 0.05 and _adds(keys[k], excess)
    ]
    strongest = keys[int(np.argmax(table[:, 0]))]
    total = max(float(residual @ residual), 1e-300)
    where = [
        _described(campaign, keys[k], fits[keys[k]] @ (fits[keys[k]].T @ residual), excess[keys[k]] / total)
        for k in significant[:3]
    ]
    return Structure(
        max(excess.values()), p, _rms(campaign, found, fits[strongest], residual, excess[strongest]), where
    )


def _adds(key: tuple[str, ...], excess: Mapping[tuple[str, ...], float]) -> bool:
    """Return whether a block follows clearly more than curves along its loads, which a surface holds.

    The whole is mostly noise here, so what it follows beyond is compared with what the curve follows.
    """
    along = max((excess.get((n,), 0.0) for n in key), default=0.0)
    return len(key) == 1 or excess[key] > (1.0 + INTERACTION) * along


def _rms(
    campaign: BinnedTests, found: SearchRound, q: FloatArray, residual: FloatArray, excess: float
) -> float:
    """Return the rms in mu of a whitened fit, shrunk to the part that is not noise."""
    fit = np.linalg.inv(found.whiten.inverse) @ found.whiten.layout.pad((q @ (q.T @ residual))[:, None])
    values = found.beyond_base(fit[campaign.test, campaign.slot, 0])
    mean_square = float(campaign.count @ values**2 / campaign.count.sum())
    power = float(np.sum((q.T @ residual) ** 2))
    return float(np.sqrt(max(mean_square * max(excess, 0.0) / max(power, 1e-300), 0.0)))


def places_of(campaign: BinnedTests, difference: FloatArray, metadata: Sequence[str]) -> list[StructurePlace]:
    """Return along which loads and metadata a difference of two predictions in the bins, shape (m,), runs, the strongest first.

    `metadata` are columns of the test table that count, too.
    """
    root = np.sqrt(campaign.count)
    target = root * (difference - float(campaign.count @ difference / campaign.count.sum()))
    blocks = _blocks(campaign, metadata)
    whole = max(float(target @ target), 1e-300)
    found: list[StructurePlace] = []
    for least in LEAST_OF_PLACES if blocks else ():
        key, fit = _strongest(campaign, blocks, target)
        share = float(fit @ fit) / whole
        if share <= least:
            break
        found.append(_described(campaign, key, fit, share))
        target = target - fit  # what follows one curve is told once, not again along a load that goes with it
    return found


class _Block(NamedTuple):
    """Orthonormal columns, weighted by points, of a curve or a surface, and of both curves whose products it holds."""

    columns: FloatArray
    apart: FloatArray | None = None


def _blocks(campaign: BinnedTests, metadata: Sequence[str]) -> dict[tuple[str, ...], _Block]:
    """Return curves and surfaces over loads and metadata in the bins."""
    root = np.sqrt(campaign.count)

    def weighted(columns: FloatArray) -> FloatArray:
        mean = np.average(columns, axis=0, weights=campaign.count)
        return Projector(root[:, None] * (columns - mean)).q

    loads = _curves(campaign, WAVY_KNOTS)
    curves = loads | {n: _metadata_curve(campaign, n) for n in metadata}
    found: dict[tuple[str, ...], _Block] = {(n,): _Block(weighted(c)) for n, c in curves.items()}
    for pair in [*combinations(loads, 2), *((a, n) for n in metadata for a in loads)]:
        a, b = (curves[n][:, :IN_SURFACES] for n in pair)
        found[pair] = _Block(weighted(_with_products(a, b)), weighted(np.column_stack([a, b])))
    return found


def _strongest(
    campaign: BinnedTests, blocks: Mapping[tuple[str, ...], _Block], target: FloatArray
) -> tuple[tuple[str, ...], FloatArray]:
    """Return the block that follows most of a difference, weighted by points, and what it follows of it.

    What so many columns would follow by chance does not count. A surface is compared only if it follows more than curves along both
    its loads.
    """
    whole = max(float(target @ target), 1e-300)
    level = campaign.of_tests(target / np.sqrt(campaign.count))[campaign.test]
    # tests are as many numbers as a difference from test to test has; one along the tests has more
    numbers = min(len(campaign.tests) * whole / max(float(campaign.count @ level**2), 1e-300), len(target))

    def followed(q: FloatArray) -> float:
        return float(np.sum((q.T @ target) ** 2)) / whole

    def adjusted(q: FloatArray) -> float:
        """Return the share that columns follow, less what so many would by chance."""
        free = numbers - 1.0 - q.shape[1]
        return 1.0 - (1.0 - followed(q)) * (numbers - 1.0) / free if free > 0.0 else -np.inf

    shares = {key: adjusted(block.columns) for key, block in blocks.items()}

    def needed(key: tuple[str, ...]) -> bool:
        apart = blocks[key].apart
        if apart is None:
            return True
        if numbers - 1.0 - blocks[key].columns.shape[1] <= LEAST_FREE * numbers:
            return False
        one = max(shares[(n,)] for n in key)
        return shares[key] >= max(one + INTERACTION, adjusted(apart) + PRODUCTS)

    best = max(filter(needed, blocks), key=lambda key: (shares[key], followed(blocks[key].columns)))
    q = blocks[best].columns
    return best, q @ (q.T @ target)


def _metadata_curve(campaign: BinnedTests, name: str) -> FloatArray:
    """Return columns of a curve along metadata in the bins: its levels where there are few, else powers."""
    values = campaign.metadata(name)
    levels = np.unique(values)
    if len(levels) <= MOST_LEVELS_APART or is_text(campaign.loads, name):
        return (values[:, None] == levels[None, 1:]).astype(float)
    return curve(values, ORDER_KNOTS if name == ORDER else 1)


def _curves(campaign: BinnedTests, knots: int = KNOTS) -> dict[str, FloatArray]:
    return {n: curve_along(campaign, n, knots) for n in scaled_loads(campaign)}


def _with_products(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return two curves with the products of their first columns."""
    return np.column_stack([a, b, products(a[:, :IN_SURFACES], b[:, :IN_SURFACES])])


def _described(campaign: BinnedTests, key: tuple[str, ...], fit: FloatArray, share: float) -> StructurePlace:
    """Return in which part of the range a fit in the bins is strong, and its shape."""
    weight = np.abs(fit)
    strong = weight >= np.quantile(weight, 0.8)
    region = {}
    for name in key:
        if name not in LOAD_NAMES and is_text(campaign.loads, name):
            continue  # levels have no range
        load = name in LOAD_NAMES
        values = campaign.average(getattr(campaign.loads, name)) if load else campaign.metadata(name)
        low, high = np.quantile(values[strong], [0.1, 0.9])
        region[name] = [float(low), float(high)]
    along = transformed(campaign, key[0]) if key[0] in LOAD_NAMES else campaign.metadata(key[0])
    rising = float(np.corrcoef(along, fit)[0, 1]) if key[0] in region else 0.0
    shape = (
        "interaction"
        if len(key) > 1
        else ("rising" if rising > 0.5 else "falling" if rising < -0.5 else "bent" if region else "levels")
    )
    return {
        "variables": list(key),
        "region": region,
        "shape": shape,
        "share": float(np.clip(share, 0.0, 1.0)),
    }
