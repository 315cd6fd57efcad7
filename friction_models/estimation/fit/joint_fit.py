"""Base and effects fitted together, as `refine` does."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from sklearn.base import clone

from ...effects.base import Effect
from ...loads import FloatArray, TriboLoads
from ...models.base import FrictionModel, Groups
from ...models.domain import Domain
from ...models.effective_variance import FitWeights
from ...models.tangent import polynomial_columns
from ..campaign.binned_tests import BinnedTests
from ..campaign.binning import campaign_of
from ..search.base_law import BaseLaw, base_law
from .joint_problem import solve_jointly


@dataclass
class JointFit:
    """Fitted base and parameters of the effects."""

    base: FrictionModel
    shapes: list[dict[str, float]]
    amplitudes: list[dict[str, float]]
    noise_floor: dict[str, object]


def fit_jointly(
    base: FrictionModel,
    effects: Sequence[Effect],
    loads: TriboLoads,
    mu: FloatArray,
    groups: Groups,
    system: Mapping[str, FloatArray],
    weights: FloatArray | None = None,
) -> JointFit:
    """Fit a base, unfitted as yet, and effects to measured friction, shape (n,).

    `groups` holds the test of each point; without it every point counts alike (ordinary least squares). `system` holds the
    metadata columns [n, 1] that the effects need. With `weights` of the points, shape (n,), mean 1, the covariance of a bin is
    that of the noise floor, divided by its mean weight.
    """
    campaign = campaign_of(loads, mu, groups)
    campaign.system = dict(system)
    law = surrogate(base, campaign)
    problem = solve_jointly(campaign, law, effects, weights)
    coefficients, amplitudes = problem.solve(problem.shapes)
    fitted = clone(base)
    if base.form == "linear" and not law.fixed:
        target = law.columns @ coefficients
    else:
        target = mu - problem.contribution(amplitudes)
    # the target of the base may be negative where an effect carries the level: the check of mu does not apply
    fitted._fit(
        campaign.loads, target, groups, **FitWeights(weights if fitted.takes_weights() else None).arguments
    )
    fitted.domain_ = Domain.of(loads)
    fitted.training_, fitted.errors_ = {}, {}
    named = [
        {a.name: float(v) for a, v in zip(e.amplitudes, values, strict=True)}
        for e, values in zip(effects, amplitudes, strict=True)
    ]
    noise_floor = dict(problem.estimated.to_dict()) if problem.estimated else {}
    return JointFit(fitted, problem.shapes, named, noise_floor)


def surrogate(base: FrictionModel, campaign: BinnedTests) -> BaseLaw:
    """Return columns that stand for the base while the effects are identified."""
    if base.form != "flexible":
        return base_law(base, campaign)
    # a flexible base would swallow the effect: second order stands in, the base itself is fitted to the rest
    return BaseLaw(base.family, polynomial_columns(campaign.loads, 2), np.zeros(len(campaign.mu)), model=base)
