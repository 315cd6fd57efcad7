"""Statistics of learning curves, and networks that are trained together."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.base import clone

from friction_models import PolynomialFriction
from friction_models.common import InputError
from friction_models.families.ffnn import FeedForwardFriction, fit_together
from friction_models.loads import LOAD_NAMES
from friction_models.training import (
    best_parameters,
    cross_validate,
    growing_sets,
    lowest_error,
    needed_tests,
    needed_with_interval,
    percentile_curve,
    share_fewer,
)

from .made_up import campaign

SIZES = (5, 10, 20, 40, 80)


def falling(plateau: float = 0.0, repeats: int = 10, scatter: float = 0.0, factor: float = 0.1) -> np.ndarray:
    """Errors ``plateau + factor / tests`` with a factor on each repeat, shape (repeats, sizes)."""
    by_repeat = 1.0 + scatter * np.linspace(-1.0, 1.0, repeats)
    return by_repeat[:, None] * (plateau + factor / np.array(SIZES)[None, :])


def test_tests_needed_of_a_power_law_are_exact() -> None:
    curve = falling()[0]
    for accuracy in (0.015, 0.01, 0.0031):
        assert needed_tests(SIZES, curve, accuracy) == pytest.approx(0.1 / accuracy, rel=1e-12)


def test_a_curve_must_stay_below() -> None:
    sizes = (5, 10, 20, 40)
    assert needed_tests(sizes, np.array([0.02, 0.005, 0.02, 0.005]), 0.01) == pytest.approx(20 * 2**0.5)
    assert needed_tests(sizes, np.array([0.005, 0.004, 0.003, 0.002]), 0.01) == 5.0
    assert needed_tests(sizes, np.array([0.005, 0.004, 0.003, 0.02]), 0.01) is None
    assert needed_tests(sizes, np.array([0.02, 0.01, 0.0, 0.0]), 0.01) == pytest.approx(10.0)


def test_percentile_lies_between_the_two_worst_of_ten() -> None:
    errors = np.arange(10.0)[:, None] * np.ones(3)
    assert percentile_curve(errors) == pytest.approx([8.55] * 3)
    assert percentile_curve(np.full((10, 2), 0.3)) == pytest.approx([0.3, 0.3])


def test_held_out_tests_are_resampled_too() -> None:
    repeats = falling(scatter=0.1)
    alike = np.repeat(repeats[:, :, None], 6, axis=2)
    assert percentile_curve(alike) == pytest.approx(percentile_curve(repeats), rel=1e-12)
    assert needed_with_interval(SIZES, alike, 0.01).tests == pytest.approx(
        needed_with_interval(SIZES, repeats, 0.01).tests
    )
    # The same MAE, most of it from two of six tests: another six might have been much easier, or harder.
    uneven = alike * np.array([2.4, 2.4, 0.3, 0.3, 0.3, 0.3])
    narrow, wide = (needed_with_interval(SIZES, e, 0.01) for e in (alike, uneven))
    assert wide.tests == pytest.approx(narrow.tests, rel=1e-9)
    assert narrow.lower and narrow.upper and wide.lower and wide.upper
    assert wide.lower < 0.6 * narrow.lower and wide.upper > 1.4 * narrow.upper
    low, lower, upper = lowest_error(uneven)
    assert lower < 0.7 * low and upper > 1.3 * low
    # Tests are drawn for both alike: what is better in every test is never worse, whichever tests are drawn.
    fewer, more = share_fewer(SIZES, 0.6 * uneven, uneven, 0.01)
    assert fewer > 0.9 and more == 0.0


def test_interval_holds_the_number_and_closes_without_scatter() -> None:
    exact = needed_with_interval(SIZES, falling(), 0.01)
    assert (exact.lower, exact.upper, exact.reached) == (pytest.approx(10.0), pytest.approx(10.0), 1.0)
    assert not exact.at_most and exact.text() == "10 (10 - 10)"
    found = needed_with_interval(SIZES, falling(scatter=0.4), 0.01)
    assert found.tests is not None and found.lower is not None and found.upper is not None
    assert 10.0 < found.lower < found.tests <= found.upper <= 14.0
    assert found == needed_with_interval(SIZES, falling(scatter=0.4), 0.01)


def test_an_accuracy_out_of_reach_says_so() -> None:
    never = needed_with_interval(SIZES, falling(plateau=0.02), 0.01)
    assert (never.tests, never.upper, never.reached, never.text()) == (None, None, 0.0, "not reached")
    at_once = needed_with_interval(SIZES, falling(factor=1e-4), 0.01)
    assert at_once.at_most and at_once.text() == "<= 5"
    # Reached by most repeats, but not by the worst: the interval is open at the top.
    errors = falling()
    errors[0] = 0.05
    some = needed_with_interval(SIZES, errors, 0.01)
    assert some.tests is None and some.upper is None
    assert some.lower == pytest.approx(10.0) and 0.2 < some.reached < 0.5


def test_share_fewer_tells_a_saving_from_none() -> None:
    fast, slow = falling(scatter=0.1), falling(scatter=0.1, factor=0.3)
    assert share_fewer(SIZES, fast, slow, 0.01) == (1.0, 0.0)
    assert share_fewer(SIZES, slow, fast, 0.01) == (0.0, 1.0)
    assert share_fewer(SIZES, fast, fast, 0.01) == (0.0, 0.0)
    assert share_fewer(SIZES, falling(plateau=0.02), falling(plateau=0.03), 0.01) == (0.0, 0.0)
    assert share_fewer(SIZES, fast, falling(plateau=0.02), 0.01) == (1.0, 0.0)


def test_lowest_error_and_its_interval() -> None:
    low, lower, upper = lowest_error(falling(plateau=0.004, scatter=0.2))
    assert low == pytest.approx(percentile_curve(falling(plateau=0.004, scatter=0.2))[-1])
    assert lower < low <= upper <= 1.2 * (0.004 + 0.1 / 80)


@pytest.mark.parametrize(
    ("sizes", "errors", "message"),
    [
        ((5, 10), np.ones((3, 3)), "repeats x 2 sizes"),
        ((5, 5), np.ones((3, 2)), "growing numbers"),
        ((5,), np.ones((0, 1)), "repeats x 1 sizes"),
    ],
)
def test_shapes_that_do_not_fit_are_refused(sizes: tuple[int, ...], errors: np.ndarray, message: str) -> None:
    with pytest.raises(InputError, match=message):
        needed_with_interval(sizes, errors, 0.01)


def test_training_sets_grow_and_do_not_depend_on_the_order_of_tests() -> None:
    names = [f"t{k}" for k in range(12)]
    sets = growing_sets(names, 4, seed=3)
    assert sets == growing_sets(names[::-1], 4, seed=3)
    assert all(sorted(order) == sorted(names) for order in sets)
    assert len({tuple(order) for order in sets}) == 4
    assert growing_sets(names, 6, seed=3)[:4] == sets


def lesson(seed: int, tests: int = 6) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    frame = campaign(tests, 12, seed=seed)
    return frame[list(LOAD_NAMES)].to_numpy(), frame["mu"].to_numpy(), frame["test_id"].to_numpy().astype(str)


def test_models_trained_together_are_those_trained_one_by_one() -> None:
    """Different data, scaling, seeds, decay and shapes; also one that stops long before the others."""
    data = [lesson(seed) for seed in range(4)]
    together = [
        FeedForwardFriction(seed=1, hidden=(5,), members=2, epochs=12, weight_decay=0.1, patience=12),
        FeedForwardFriction(seed=2, hidden=(5,), members=2, epochs=12, weight_decay=3.0, patience=12),
        FeedForwardFriction(seed=3, hidden=(5,), members=2, epochs=12, patience=1, learning_rate=0.05),
        FeedForwardFriction(seed=4, hidden=(4, 3), members=3, epochs=8, patience=12),
    ]
    alone = [clone(model).fit(*own) for model, own in zip(together, data)]
    fit_together(together, data)
    for one, other, own in zip(alone, together, data):
        assert one.epochs_ == other.epochs_
        assert one.predict(own[0]) == pytest.approx(other.predict(own[0]), abs=1e-12)
        assert one.errors_["train"]["mae"] == pytest.approx(other.errors_["train"]["mae"], rel=1e-9)
        assert one.domain_ == other.domain_ and one.training_["splits"] == other.training_["splits"]
    assert alone[0].predict(data[0][0]) != pytest.approx(alone[1].predict(data[0][0]), abs=1e-4)


def test_early_stop_of_one_model_leaves_the_others_alone() -> None:
    data = [lesson(0), lesson(1)]

    def network(seed: int) -> FeedForwardFriction:
        return FeedForwardFriction(
            hidden=(4,), members=1, epochs=40, patience=3, learning_rate=0.03, seed=seed
        )

    pair = [network(5), network(6)]
    fit_together(pair, data)
    for model, own, seed in zip(pair, data, (5, 6)):
        assert model.epochs_ == network(seed).fit(*own).epochs_


def test_lessons_of_unequal_length_are_learned_together() -> None:
    pair = [FeedForwardFriction(hidden=(4,), members=1, epochs=15, seed=s) for s in (0, 1)]
    fit_together(pair, [lesson(0, tests=4), lesson(1, tests=9)])
    assert all(model.errors_["train"]["mae"] < 0.02 for model in pair)


def test_folds_and_grid_in_one_batch_find_the_better_network() -> None:
    frame = campaign(10, 12)
    model = FeedForwardFriction(hidden=(6,), members=1, epochs=25)
    best, table = best_parameters(model, {"learning_rate": [1e-5, 1e-2]}, frame, folds=5)
    assert best == {"learning_rate": 1e-2}
    single = cross_validate(model.set_params(learning_rate=1e-2), frame, folds=5)
    assert table["mae"].iloc[0] == pytest.approx(single.measures["mae"], rel=1e-9)
    assert table["mae"].iloc[0] < 0.5 * table["mae"].iloc[1]


def test_search_of_other_families_goes_one_combination_at_a_time() -> None:
    seen: list[tuple[int, int]] = []
    best, table = best_parameters(
        PolynomialFriction(), {"degree": [1, 2]}, campaign(30, 8), progress=lambda *step: seen.append(step)
    )
    assert seen == [(1, 2), (2, 2)] and best == {"degree": table["degree"].iloc[0]}
    assert table["rmse"].is_monotonic_increasing
    with pytest.raises(InputError, match="did you mean 'degree'"):
        best_parameters(PolynomialFriction(), {"degre": [1]}, campaign(6, 8))
