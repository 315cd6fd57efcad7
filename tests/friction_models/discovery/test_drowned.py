"""What sets whole tests apart, and unseen tests show for certain, is named though the search does not see it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import diagnose
from friction_models.discovery.judge.confirmation import Confirmation
from friction_models.discovery.judge.naming.names import Names
from friction_models.discovery.judge.unseen_tests_judge import UnseenTestsJudge


def series(seed: int) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return 48 tests at four settings, that settle along their path each in its own way; every third oil lowers mu."""
    rng = np.random.default_rng(seed)
    sd = np.linspace(100.0, 6000.0, 30)
    frames, oils = [], np.tile(["plain", "A", "B"], 16)
    for k in range(48):
        v, p = (20.0, 100.0)[k % 2], (10.0, 20.0)[k // 2 % 2]
        settles = rng.normal(0.012, 0.012) / (1.0 + sd / rng.uniform(500.0, 3000.0))
        waves = np.cumsum(rng.normal(0.0, 0.002, len(sd)))
        mu = 0.11 - 0.02 * (oils[k] == "B") + rng.normal(0.0, 0.008) + settles + waves - 0.0001 * v
        frames.append(
            pd.DataFrame({"test_id": f"t{k:02d}", "t": sd / v, "v_rel": v, "sigma_n": p, "sd": sd, "mu": mu})
        )
    return pd.concat(frames), pd.DataFrame({"test_id": [f"t{k:02d}" for k in range(48)], "oil": oils})


@pytest.mark.parametrize(
    ("seed", "named"), [(5, ["factor:oil"]), pytest.param(1, [], marks=pytest.mark.nightly)]
)
def test_unseen_tests_name_what_the_search_does_not_see(
    seed: int, named: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """4.8 standard errors in the first campaign, 0.4 in the second."""
    asked: list[Names] = []
    original = UnseenTestsJudge.__call__

    def judged(self: UnseenTestsJudge, *arguments: Any) -> Confirmation:
        asked.append(self.names)
        return original(self, *arguments)

    monkeypatch.setattr(UnseenTestsJudge, "__call__", judged)
    diagnose(*series(seed))
    names = asked[0]
    monkeypatch.setattr(type(names.found), "p_value", lambda *_: 1.0)
    assert [f.name for f in names.that_help([])] == named
