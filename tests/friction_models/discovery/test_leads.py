"""An effect that explains, or that needs fewer loads, leads where unseen tests prefer it; what merely fits a little better does not."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from friction_models.discovery.judge.names import Names
from friction_models.discovery.judge.unseen_tests import ErrorsByTest

#: Falls of the squared error of 16 tests of 9: their mean is 1.6 standard errors above zero in the first, 0.3 in the second.
LIKELY, CHANCE = [6.4, -2.7] * 8, [4.0, -3.4] * 8


class _Effect:
    """An effect, which is its own fit: it leaves a share of what can be predicted, and errors of unseen tests fall by so much."""

    def __init__(
        self,
        name: str,
        *loads: str,
        left: float,
        fall: list[float],
        gain: float = 100.0,
        kind: str = "physics",
    ) -> None:
        self.name, self.driver, self.gain, self.kind = name, loads, gain, kind
        self.effect, self.left, self.fall = self, left, np.array(fall)


def _names(*ranking: _Effect) -> Names:
    """Return the judge of names where unseen tests say of each effect what it holds."""
    unseen = SimpleNamespace(
        campaign=SimpleNamespace(varied=["v_rel", "sigma_n"]),
        errors=lambda effects: ErrorsByTest(9.0 - effects[0].fall, np.zeros(16)),
    )
    beside = SimpleNamespace(shares=lambda kept: SimpleNamespace(left=kept[0].left))
    found = SimpleNamespace(ranking=ranking)
    return Names(cast(Any, unseen), cast(Any, found), cast(Any, None), cast(Any, beside), cast(Any, None))


@pytest.fixture(autouse=True)
def _effects_are_fits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("friction_models.discovery.judge.names.effects_of", list)


def _led(*ranking: _Effect) -> str:
    first = _names(*ranking)._best_led([cast(Any, ranking[0])])[0]
    return first.name


NOTHING = [0.0] * 16


def test_what_explains_leads_where_the_first_does_not() -> None:
    both = _Effect("both", "sigma_n", "v_rel", left=0.3, fall=NOTHING)
    assert _led(both, _Effect("speed", "v_rel", "sigma_n", left=0.05, fall=LIKELY)) == "speed"
    assert _led(both, _Effect("speed", "v_rel", "sigma_n", left=0.25, fall=LIKELY)) == "both"
    assert _led(both, _Effect("speed", "v_rel", "sigma_n", left=0.05, fall=CHANCE)) == "both"


def test_one_that_fits_all_tests_worse_needs_more() -> None:
    both = _Effect("both", "sigma_n", "v_rel", left=0.3, fall=NOTHING)
    assert _led(both, _Effect("speed", "v_rel", "sigma_n", left=0.05, fall=LIKELY, gain=70.0)) == "both"
    certain = [4.0, 3.0] * 8
    assert _led(both, _Effect("speed", "v_rel", "sigma_n", left=0.05, fall=certain, gain=70.0)) == "speed"


def test_a_law_of_fewer_loads_leads_though_the_first_explains() -> None:
    both = _Effect("both", "sigma_n", "v_rel", left=0.1, fall=NOTHING)
    assert _led(both, _Effect("pressure", "sigma_n", left=0.08, fall=LIKELY)) == "pressure"
    assert _led(both, _Effect("pressure", "sigma_n", left=0.08, fall=CHANCE)) == "both"
    assert _led(both, _Effect("other", "v_rel", "sigma_n", left=0.08, fall=LIKELY)) == "both"
    assert _led(both, _Effect("zero", "sigma_n", left=0.08, fall=LIKELY, kind="fault")) == "both"
