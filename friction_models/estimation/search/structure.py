"""Structure that no effect of the catalogue explains: a functional analysis of variance of the residual.

Curves along each load and products of curves of two loads are fitted to the whitened remainder; each block
is compared with what it would fit in pure noise (functional ANOVA; Hooker, J. Comput. Graph. Stat. 16 (2007)).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TypedDict

import numpy as np

from ...loads import LOAD_NAMES, FloatArray
from ..campaign.binning import BinnedTests
from ..campaign.curves import curve, products, scaled_loads, spline_columns, transformed
from ..campaign.metadata import is_text
from .scan import Fit, Projector
from .search_round import SearchRound
from .significance import null_noise

REPLICATES = 399
#: A surface over two loads must follow this much more of a difference than a curve along one of them, both adjusted for their columns.
INTERACTION = 0.15
#: Places at which curves may bend, that are fitted to measurements, and to what the reference, which may be wavy, predicts otherwise.
KNOTS, WAVY_KNOTS = 3, 5
#: Metadata with so few values are levels, whatever lies between them.
MOST_LEVELS_APART = 4
#: Places that are told of a difference of two predictions.
MOST_PLACES = 2


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
    null = np.sum((q.T @ _noise(campaign, found, residual, seed, project.q.shape[1])) ** 2, axis=0)
    return Misfit(drop - float(null.mean()), (1 + int(np.sum(null >= drop))) / (1 + REPLICATES))


def _noise(
    campaign: BinnedTests, found: SearchRound, residual: FloatArray, seed: int, fitted: int = 0
) -> FloatArray:
    """Return whitened data in which nothing of a residual is missing, shape (m, replicates); `fitted` numbers were fitted to it."""
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
    data = np.column_stack([residual, project(_noise(campaign, found, residual, seed))])
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
        k for k in np.argsort(-table[:, 0]) if (1 + np.sum(null >= table[k, 0])) / (1 + REPLICATES) < 0.05
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
    mean = float(campaign.count @ difference / campaign.count.sum())
    target = root * (difference - mean)
    whole = max(float(target @ target), 1e-300)
    curves = _curves(campaign, WAVY_KNOTS)
    levels = campaign.of_tests(difference)[campaign.test] - mean
    # tests are as many numbers as a difference from test to test has; one along the tests has more
    numbers = min(len(campaign.tests) * whole / max(float(campaign.count @ levels**2), 1e-300), len(target))
    shares: dict[tuple[str, ...], tuple[float, FloatArray]] = {}
    ranks: dict[tuple[str, ...], int] = {}

    def add(key: tuple[str, ...], columns: FloatArray) -> None:
        q = Projector(root[:, None] * (columns - np.average(columns, axis=0, weights=campaign.count))).q
        fit = q @ (q.T @ target)
        shares[key], ranks[key] = (float(fit @ fit) / whole, fit), q.shape[1]

    def add_surface(a: str, b: str, columns: FloatArray) -> None:
        add((a, b), _with_products(curves[a], columns))
        if adjusted((a, b)) < max(adjusted((a,)), adjusted((b,))) + INTERACTION:
            del shares[(a, b)]

    def adjusted(key: tuple[str, ...]) -> float:
        """Return the share less what so many columns would follow by chance."""
        free = numbers - 1.0 - ranks[key]
        return 1.0 - (1.0 - shares[key][0]) * (numbers - 1.0) / free if free > 0.0 else -np.inf

    for n in curves:
        add((n,), curves[n])
    for a, b in combinations(curves, 2):
        add_surface(a, b, curves[b])
    for n in metadata:
        columns = _metadata_curve(campaign, n)
        add((n,), columns)
        for a in curves:
            add_surface(a, n, columns)
    best = sorted(shares, key=lambda key: -shares[key][0])
    return [
        _described(campaign, key, shares[key][1], shares[key][0])
        for key in best[:MOST_PLACES]
        if shares[key][0] > 0.1
    ]


def _metadata_curve(campaign: BinnedTests, name: str) -> FloatArray:
    """Return columns of a curve along metadata in the bins: its levels where there are few, else powers."""
    values = campaign.average(campaign.system[name][:, 0])
    levels = np.unique(values)
    if len(levels) <= MOST_LEVELS_APART or is_text(campaign.loads, name):
        return (values[:, None] == levels[None, 1:]).astype(float)
    return curve(values, 1)


def _curves(campaign: BinnedTests, knots: int = KNOTS) -> dict[str, FloatArray]:
    return {n: curve(values, knots) for n, values in scaled_loads(campaign).items()}


def _with_products(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return two curves with the products of their first columns."""
    return np.column_stack([a, b, products(a[:, :3], b[:, :3])])


def _described(campaign: BinnedTests, key: tuple[str, ...], fit: FloatArray, share: float) -> StructurePlace:
    """Return in which part of the range a fit in the bins is strong, and its shape."""
    weight = np.abs(fit)
    strong = weight >= np.quantile(weight, 0.8)
    region = {}
    for name in key:
        if name not in LOAD_NAMES and is_text(campaign.loads, name):
            continue  # levels have no range
        values = campaign.average(
            getattr(campaign.loads, name) if name in LOAD_NAMES else campaign.system[name][:, 0]
        )
        low, high = np.quantile(values[strong], [0.1, 0.9])
        region[name] = [float(low), float(high)]
    along = (
        transformed(campaign, key[0])
        if key[0] in LOAD_NAMES
        else campaign.average(campaign.system[key[0]][:, 0])
    )
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
