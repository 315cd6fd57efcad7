"""Effects that contribute the same: which of them is named first does not hang on single tests."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import diagnose
from friction_models.discovery.judge.naming.rivals import Rivals
from friction_models.effects import CATALOGUE
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.search.search_round import plainness

from ..estimation_cases import measured

CHANGES = 4


def under_pressure(seed: int) -> pd.DataFrame:
    """Return tests in which mu falls with pressure by a hyperbolic tangent; constant pressures cannot part its twins."""
    data = measured(np.random.default_rng(seed), tests=36, points=6, between=0.002)
    return data.assign(mu=data["mu"] - 0.06 * np.tanh(data["sigma_n"] / 900.0))


def first_names(data: pd.DataFrame, rng: np.random.Generator) -> set[str]:
    """Return the first names of answers to the data without a tenth of the tests, each time another one."""
    names = np.array(sorted(data["test_id"].unique()))
    told = set()
    for _ in range(CHANGES):
        kept = rng.permutation(names)[4:]
        told.update(diagnose(data[data["test_id"].isin(kept)]).effects[:1])
    return told


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.nightly)])
def test_the_first_of_twins_does_not_hang_on_single_tests(seed: int) -> None:
    told = first_names(under_pressure(seed), np.random.default_rng(seed))
    # fewest numbers first, then the order of the catalogue; a fault last
    assert told == {"pressure_power"}


SIGNAL = np.linspace(-1.0, 1.0, 40)
#: Contributions in the data: of three that are the same one is a fault, and of two that resemble it one has fewer numbers.
SIGNALS = {
    "pressure_saturation": SIGNAL,
    "pressure_power": SIGNAL + 1e-3 * SIGNAL**2,
    "force_zero": SIGNAL,
    "flash_temperature": SIGNAL + 0.2 * SIGNAL**2,
}


@pytest.mark.parametrize(
    ("power", "named"),
    [(0.00300, "pressure_power"), (0.00301, "pressure_power"), (0.00310, "pressure_saturation")],
)
def test_what_unseen_tests_prefer_by_a_hair_does_not_lead_a_plainer_one(power: float, named: str) -> None:
    """They prefer the saturation by 0, 0.7 and 6.8 % of the squared error."""
    fits: list[Any] = [
        SimpleNamespace(name=n, effect=CATALOGUE[n](), signal=signal) for n, signal in SIGNALS.items()
    ]
    left = dict.fromkeys(SIGNALS, 0.003) | {"pressure_power": power}
    found = SimpleNamespace(ranking=fits, plainness=lambda fit: plainness(fit, list(CATALOGUE)))
    straight = SimpleNamespace(errors=lambda kept: SimpleNamespace(rms=left[kept[0].name]))
    rivals = Rivals(prepare(under_pressure(0)), *(cast(Any, part) for part in (found, straight, None)))
    assert [f.name for f in rivals.plainest_first(fits[:1])] == [named]
    assert rivals.plainest_first([]) == []


def test_what_the_search_could_not_try_alone_is_listed_last() -> None:
    """The twin's heating beside another name, where the slope of the model alone is the same as it."""
    seen: Any = SimpleNamespace(name="twin_heating", effect=CATALOGUE["twin_heating"]())
    assert plainness(seen, ["stribeck", "running_in"])[-1] == 2


@pytest.mark.parametrize(("steps", "named"), [(False, "rising_speed"), (True, "rate_state")])
def test_a_memory_that_no_test_can_show_is_a_law_of_the_speed(steps: bool, named: str) -> None:
    """Their contributions agree to 0.99, and unseen tests prefer the memory by 3 % of the squared error."""
    parts = []
    for k in range(9):
        v = np.repeat([5.0, 50.0], 10) if steps else np.full(20, 5.0 * 2.0**k)
        sd = np.linspace(0.5, 20.0, 20)
        parts.append(
            pd.DataFrame({"test_id": f"t{k}", "v_rel": v, "sd": sd, "t": np.cumsum(1.0 / v), "mu": 0.1})
        )
    fits: list[Any] = [
        SimpleNamespace(name=n, effect=CATALOGUE[n](), signal=SIGNAL + bend * (SIGNAL**2 - 1.0 / 3.0))
        for n, bend in (("rate_state", 0.0), ("rising_speed", 0.25))
    ]
    left = {"rate_state": 0.0030, "rising_speed": 0.0030 * 1.03**0.5}
    found = SimpleNamespace(ranking=fits, plainness=lambda fit: plainness(fit, list(CATALOGUE)))
    straight = SimpleNamespace(errors=lambda kept: SimpleNamespace(rms=left[kept[0].name]))
    rivals = Rivals(
        prepare(pd.concat(parts, ignore_index=True)), *(cast(Any, p) for p in (found, straight, None))
    )
    assert [f.name for f in rivals.plainest_first(fits[:1])] == [named]
