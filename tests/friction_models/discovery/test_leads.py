"""An effect that explains leads where the first does not and unseen tests prefer it; what only fits a little better does not."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from friction_models.discovery.judge.naming.names import Names
from friction_models.discovery.judge.unseen_tests import ErrorsByTest

#: Falls of the squared error of 16 tests of 9: their mean is 1.6 standard errors above zero in the first, 0.3 in the second.
LIKELY, CHANCE = [6.4, -2.7] * 8, [4.0, -3.4] * 8


class _Effect:
    """An effect, which is its own fit: it leaves a share of what can be predicted, for `sure` or not, and errors of unseen tests fall by so much."""

    def __init__(
        self, name: str, left: float, fall: list[float], gain: float = 100.0, sure: bool = True
    ) -> None:
        self.name, self.left, self.fall, self.gain, self.sure = name, left, np.array(fall), gain, sure


def _names(*ranking: _Effect) -> Names:
    """Return the judge of names where unseen tests say of each effect what it holds."""
    unseen = SimpleNamespace(errors=lambda effects: ErrorsByTest(9.0 - effects[0].fall, np.zeros(16)))
    beside = SimpleNamespace(shares=lambda kept: SimpleNamespace(left=kept[0].left, believed=kept[0].sure))
    found = SimpleNamespace(ranking=ranking)
    return Names(cast(Any, unseen), cast(Any, found), cast(Any, None), cast(Any, beside), cast(Any, None))


@pytest.fixture(autouse=True)
def _effects_are_fits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("friction_models.discovery.judge.naming.names.effects_of", list)


def _led(*ranking: _Effect) -> str:
    first = _names(*ranking)._best_led([cast(Any, ranking[0])])[0]
    return first.name


NOTHING = [0.0] * 16


def test_what_explains_leads_where_the_first_does_not() -> None:
    both = _Effect("both", 0.3, NOTHING)
    assert _led(both, _Effect("speed", 0.05, LIKELY)) == "speed"
    assert _led(both, _Effect("speed", 0.25, LIKELY)) == "both"
    assert _led(both, _Effect("speed", 0.05, CHANCE)) == "both"


def test_what_may_explain_goes_on_leading() -> None:
    """Twins of a law take turns on unseen tests: the reference must say for certain that the first leaves something."""
    assert _led(_Effect("both", 0.17, NOTHING, sure=False), _Effect("speed", 0.05, LIKELY)) == "both"


def test_one_that_fits_all_tests_worse_needs_more() -> None:
    both = _Effect("both", 0.3, NOTHING)
    assert _led(both, _Effect("speed", 0.05, LIKELY, gain=70.0)) == "both"
    certain = [4.0, 3.0] * 8
    assert _led(both, _Effect("speed", 0.05, certain, gain=70.0)) == "speed"


def test_what_the_weights_of_a_fit_gain_is_no_merit_of_a_name() -> None:
    """A name lowered the error of a plain fit by a quarter, of which its weights alone made all but a hundredth."""
    effect = _Effect("hersey", 0.0, [2.0, 2.5] * 8)
    names = _names(effect)
    cast(Any, names.found).p_value = lambda fit: 0.001
    cast(Any, names.beside).without_names = ErrorsByTest(np.tile([7.05, 6.57], 8), np.zeros(16))
    assert names.that_help([cast(Any, effect)]) == []
    cast(Any, names.beside).without_names = ErrorsByTest(np.full(16, 9.0), np.zeros(16))
    assert names.that_help([cast(Any, effect)]) == [effect]
