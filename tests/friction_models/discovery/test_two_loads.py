"""A law of two loads is named only where two laws of one load each do not predict unseen tests as well."""

from __future__ import annotations

import pytest

from benchmarks.literature import make
from benchmarks.literature.case import Case
from friction_models.discovery import Diagnosis, diagnose
from friction_models.discovery.judge.doubts import MOSTLY

#: Sizes of the laws beside the scatter between tests.
LARGE = (1.0, 3.0)
#: Points a test: what is judged lies between tests, and more of them only take longer.
POINTS = 24


def answer(seed: int, recipe: str, *laws: str) -> Diagnosis:
    """Diagnose a campaign with hidden laws of the literature."""
    kind = "pair" if len(laws) > 1 else "single"
    campaign = make(Case(f"{kind}-{seed}", kind, tuple(sorted(laws)), recipe, seed, LARGE, points=POINTS))
    return diagnose(campaign.data, campaign.tests)


def test_speed_and_temperature_are_no_viscous_film() -> None:
    """Unseen tests prefer the two by more than two standard errors; the search finds `viscous` first."""
    found = answer(990031, "lhs30", "rise_limiting_shear", "softening_johnson_cook")
    assert set(found.effects) == {"rising_speed", "thermal_softening"}, found.sentence


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("seed", "recipe", "laws", "right"),
    [
        (990027, "random_walk", ("rise_rational", "softening_johnson_cook"), "rising_speed"),
        (990017, "quantised", ("stribeck_rational", "breakdown_weibull"), "stribeck"),
    ],
)
def test_beside_the_temperature_a_law_of_the_speed_says_as_much_as_one_of_both(
    seed: int, recipe: str, laws: tuple[str, ...], right: str
) -> None:
    found = answer(seed, recipe, *laws)
    if right not in found.effects:  # then it is said to do as well
        assert found.confidence <= MOSTLY and "thermal" in found.effects[1], found.sentence
        said = [w for w in found.warnings if w.startswith("in the place of")]
        assert right in found.confusion_set or any(right in w for w in said), found.warnings


@pytest.mark.nightly
def test_a_law_of_two_loads_stays() -> None:
    found = answer(990081, "random_walk", "breakdown_index")
    assert found.effects == ["hot_pressure_breakdown"] and found.confidence > 0.9, found.sentence
