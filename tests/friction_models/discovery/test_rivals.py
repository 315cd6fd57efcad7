"""What stands beside a further name as its rival."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from friction_models.discovery.judge.naming.rivals import Rivals
from friction_models.discovery.judge.unseen_tests import ErrorsByTest


@pytest.mark.parametrize(("gain", "listed"), [(60.0, ["other"]), (6.0, [])])
def test_a_rival_of_a_further_name_gains_a_good_part_of_what_it_gains(gain: float, listed: list[str]) -> None:
    """Unseen tests tell neither apart, be it that both predict as well, or that the scatter of few tests hides how much worse one is."""
    first, named, other = (
        SimpleNamespace(name=n, gain=g, effect=SimpleNamespace(metadata=()))
        for n, g in (("first", 500.0), ("named", 100.0), ("other", gain))
    )
    same = ErrorsByTest(np.linspace(1.0, 2.0, 9), np.zeros(9))
    straight: Any = SimpleNamespace(errors=lambda fits: same)
    found: Any = SimpleNamespace(ranking=[first], just=lambda *fits: False, p_value=lambda fit: 0.0)
    campaign: Any = SimpleNamespace(averaged=False, system={})
    further: Any = lambda known, level=0.05: [named, other]  # noqa: E731
    kept: Any = [first, named]
    assert Rivals(campaign, found, straight, further).of(kept, 0.0) == {"first": [], "named": listed}


@pytest.mark.parametrize(("beside", "listed"), [(True, []), (False, ["other"])])
def test_what_helps_no_unseen_test_is_a_rival_only_where_the_scan_prefers_it(
    beside: bool, listed: list[str]
) -> None:
    """A first name that was looked for beside another one: alone, in the scan, its rivals look better than it."""
    first, second, other = (
        SimpleNamespace(name=n, gain=g, effect=SimpleNamespace(metadata=(), driver=(load,)))
        for n, g, load in (("first", 50.0, "T"), ("second", 500.0, "sd"), ("other", 400.0, "v_rel"))
    )

    def errors(fits: Any) -> ErrorsByTest:
        # the other one in the place of the first leaves as much as if that were left out
        size = 1.0 if "first" in {f.name for f in fits} else 4.0
        return ErrorsByTest(size * np.linspace(0.2, 3.0, 6), np.zeros(6))

    found: Any = SimpleNamespace(
        ranking=[second, other, first], just=lambda a, b: b is second, p_value=lambda fit: 0.0
    )
    campaign: Any = SimpleNamespace(averaged=False, system={}, tests=["t"] * 6)
    further: Any = lambda known, level=0.05: []  # noqa: E731
    rivals = Rivals(campaign, found, SimpleNamespace(errors=errors), further)
    kept: Any = [first, second] if beside else [first]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Rivals, "_led", lambda self, kept, instead: False)
        patch.setattr("friction_models.discovery.judge.naming.rivals.one_cause", lambda *given: False)
        assert rivals.of(kept, 0.0)["first"] == listed
