"""A card as prior knowledge: what a few tests of your own cannot tell is taken from it.

Points of the card stand beside the measured ones and weigh, together, as much as some tests. With the standard uncertainty u of the
card and the scatter s of single tests around it, that is (s / u)^2 tests: as many as it takes for a mean of tests to be as sure as the
card. More tests of your own outweigh it.
"""

from __future__ import annotations

import numpy as np

from ..common import InputError
from ..loads import LOAD_NAMES, FloatArray, TriboLoads
from ..models.base import FrictionModel
from ..models.domain import Domain
from ..models.effective_variance import FitWeights
from ..models.law import Groups
from .card import Card

#: Points of the card.
POINTS = 300
#: Least and most tests that a card weighs as much as, where no number is given.
LEAST, MOST = 0.5, 20.0


def prior_tests(card: Card, off: FloatArray, groups: Groups) -> float:
    """Return how many tests the card weighs as much as, from the deviations `off` of the data from it.

    Examples
    --------
    >>> from friction_models.cards import load_card
    >>> card = load_card("seal-kdn")
    >>> off, tests = np.array([0.0, 0.01, -0.01]), np.array(["a", "b", "c"])
    >>> round(prior_tests(card, off, tests), 2) == round((0.01 / card.uncertainty) ** 2, 2)
    True
    """
    if card.uncertainty is None or not card.uncertainty > 0.0 or groups is None:
        return 1.0
    names = np.unique(groups)
    if len(names) < 3:
        return 1.0
    means = np.array([off[groups == n].mean() for n in names])
    return float(np.clip((means.std(ddof=1) / card.uncertainty) ** 2, LEAST, MOST))


def fit_from_card(
    model: FrictionModel,
    card: Card,
    loads: TriboLoads,
    mu: FloatArray,
    groups: Groups = None,
    tests: float | None = None,
) -> float:
    """Fit `model` to data with a card as prior; return how many tests the card weighed as much as.

    Parameters
    ----------
    tests : float, optional
        That number; 0 fits the data alone.

    Raises
    ------
    InputError
        A family that takes no weights, a number of tests that is none, or a load of the law that the data do not hold.

    Examples
    --------
    Two tests at one pressure, 0.01 above the card; at another pressure the card still decides:

    >>> from friction_models import LinearFriction, TriboLoads
    >>> from friction_models.cards import load_card
    >>> loads = TriboLoads.from_array([[0, 20, 300, 0, 1], [0, 20, 310, 0, 1]])
    >>> model = LinearFriction()
    >>> fit_from_card(model, load_card("rock-granite-ground"), loads, np.array([0.56, 0.56]), np.array(["a", "b"]))
    1.0
    >>> model.predict([[0, 20, 1100, 0, 1]]).round(1).tolist()
    [0.5]
    """
    if not model.takes_weights():
        raise InputError(
            f"--from {card.name}: the {model.family} family takes no weights, so it takes no prior"
        )
    points, target, names = model._checked(loads, mu, groups)
    law = card.model()
    missing = [n for n in law.needed_loads if n in points.absent]
    if missing:
        raise InputError(f"card {card.name!r} depends on {missing[0]!r}, which the data do not hold")
    off = target - law.predict(points)
    weight = prior_tests(card, off, names) if tests is None else float(tests)
    if not 0.0 <= weight <= 1e6:
        raise InputError(f"prior tests = {tests!r}, allowed: a number from 0 to 1e6")
    if weight > 0.0:
        array = points.as_array()
        box = {n: (float(c.min()), float(c.max())) for n, c in zip(LOAD_NAMES, array.T)}
        extra = card.sample(POINTS, box)
        own = 1 if names is None else len(np.unique(names))
        share = weight * len(target) / own / POINTS
        weights = np.r_[np.ones(len(target)), np.full(POINTS, share)]
        both = TriboLoads.from_array(np.vstack([array, extra]))
        all_names = None if names is None else np.r_[names, np.full(POINTS, "card")]
        fitted = np.r_[target, law.predict(extra)]
        model._fit(both, fitted, all_names, **FitWeights(weights / weights.mean()).arguments)
        # What the model knows reaches as far as the card.
        model.domain_ = Domain.of(both).without(points.absent)
        model._record_fit(points, target, names, FitWeights(None))
    else:
        model.fit(points, target, names)
    provenance = model.training_["data"]["provenance"]
    model.training_["data"]["provenance"] = {
        **provenance,
        "prior": f"card {card.name}",
        "prior_tests": weight,
    }
    return weight
