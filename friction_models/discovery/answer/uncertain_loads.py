"""What uncertain loads have to do with an answer: their part of the noise floor, and effects that rest on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from sklearn.base import clone

from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.fit.parameters import FittedTerm
from ...estimation.noise.noise_floor import FloorFromLoads, NoiseFloorNumbers
from ...estimation.search.base_law import BaseLaw
from ...estimation.search.candidates import evaluate_points
from ...loads import FloatArray, TriboLoads
from ...models.base import FrictionModel
from ...models.domain import Domain
from ...models.effective_variance import raised_loads
from ...models.measures import predict_points
from .wording import mu_format


def floor_from_loads(
    campaign: BinnedTests, base: BaseLaw, terms: Sequence[FittedTerm], mu: FloatArray
) -> FloorFromLoads | None:
    """Return the RMS of mu in the averages that the stated uncertainties of the loads give a model with effects.

    Each load is raised by its uncertainty at all points, as `load_uncertainty` does, in the base and in the effects beside it;
    a base that is refitted is refitted to what the effects leave. The errors of a load are common to the points of a test, so
    that they do not average out. None where the data state no uncertainty.

    The campaign is that of the points as measured; `mu`, shape (n,), is the friction coefficient that effects see.
    Raises InputError: an uncertainty that is negative or not finite.
    """
    stated = campaign.loads.stated_uncertainty()
    if not stated:
        return None
    places = {load: raised_loads(campaign.loads, load, u) for load, u in stated.items()}
    own = _of_effects(campaign, campaign.loads, terms, mu)
    law = _fitted(campaign, base, campaign.mu - own)
    usual = _predicted(law, campaign.loads) + own
    by_load = {}
    for load, there in places.items():
        change = _predicted(law, there) + _of_effects(campaign, there, terms, mu) - usual
        by_load[load] = float(np.sqrt(np.average(campaign.average(change) ** 2, weights=campaign.count)))
    return {"total": float(np.sqrt(np.sum(np.square(list(by_load.values()))))), "by_load": by_load}


def uncertain_drivers(campaign: BinnedTests, terms: Sequence[FittedTerm]) -> list[str]:
    """Return a warning for each effect that rests on a load whose uncertainty is as large as its spread between tests."""
    stated = campaign.loads.stated_uncertainty()
    if len(campaign.tests) < 2:
        return []
    said = []
    for term in terms:
        for load in (n for n in term.effect.driver if n in stated):
            size = float(np.sqrt(np.mean(campaign.of_tests(campaign.average(stated[load] ** 2)))))
            spread = float(np.std(campaign.of_tests(campaign.average(getattr(campaign.loads, load))), ddof=1))
            if size >= spread:
                said.append(
                    f"{term.name} rests on {load}, whose standard uncertainty ({size:.3g}) is as large as its spread between tests "
                    f"({spread:.3g}): its amplitude comes out too small, and part of what is seen may be the error of {load}"
                )
    return said


def from_loads_text(floor: NoiseFloorNumbers) -> str:
    """Return the part of uncertain loads in a noise floor, in words; empty where none was stated.

    Examples
    --------
    >>> found = {"sensor": 0.002, "test": 0.003, "drift": 0.0, "total": 0.005, "interval": [0.003, 0.006]}
    >>> from_loads_text({**found, "from_loads": {"total": 0.0021, "by_load": {"T": 0.002, "psi": 0.0006}}})
    "of the floor 0.0050, about 0.0021 (18 % of its square) is what uncertain loads (mostly T) make of the model's own slopes"
    >>> from_loads_text(found)
    ''
    """
    found = floor.get("from_loads")
    if found is None:
        return ""
    size, total = found["total"], floor["total"]
    mostly = max(found["by_load"], key=lambda load: found["by_load"][load])
    slopes = f"uncertain loads (mostly {mostly}) make of the model's own slopes"
    if size == 0.0:
        return "uncertain loads have no part in it: the model does not depend on them"
    f = mu_format(max(size, total), 4)
    if size >= total:
        return (
            f"what {slopes} would be {size:{f}}, the whole floor of {total:{f}}: the uncertainties are stated too large, or an "
            "error is common to all tests"
        )
    return f"of the floor {total:{f}}, about {size:{f}} ({100 * (size / total) ** 2:.0f} % of its square) is what {slopes}"


def _fitted(campaign: BinnedTests, base: BaseLaw, target: FloatArray) -> Any:
    """Return the base as users have it: fitted to what effects leave, or as it was given."""
    if base.fixed or not isinstance(base.model, FrictionModel):
        return base.model
    law = clone(base.model)
    # what effects leave may be negative: the check of mu does not apply
    law._fit(campaign.loads, target, campaign.loads.test_id)
    law.domain_ = Domain.of(campaign.loads)
    return law


def _predicted(law: Any, loads: TriboLoads) -> FloatArray:
    if isinstance(law, FrictionModel):
        return law.predict(loads)
    return predict_points("model", law, loads, loads.tests_table())


def _of_effects(
    campaign: BinnedTests, loads: TriboLoads, terms: Sequence[FittedTerm], mu: FloatArray
) -> FloatArray:
    """Return what the effects make of mu at other loads of the same points, shape (n,)."""
    there = replace(campaign, loads=loads, integrated={}, smooth=None)
    total = np.zeros(len(mu))
    for term in terms:
        columns = evaluate_points(term.effect, there, mu, term.shape)
        for amplitude, column in zip(term.amplitudes.values(), columns, strict=True):
            total = total + amplitude * np.broadcast_to(column, (len(mu), 1))[:, 0]
    return total
