"""Between the levels of a plan the formula of an effect stands for measurements: the diagnosis says so."""

from itertools import product

from friction_models.discovery import diagnose

from .test_next_tests import made


def between(speeds: tuple[float, ...]) -> list[str]:
    """Return what is said of gaps, of tests whose friction falls with speed."""
    rows = list(product((600.0, 1200.0, 1800.0), speeds, (20.0, 120.0)))
    found = diagnose(*made(rows, "v_rel"), catalogue=["stribeck", "thermal_softening"])
    assert found.effects == ["stribeck"]
    return [w for w in found.warnings if "no test measured" in w]


def test_a_fall_that_no_test_saw_is_a_matter_of_the_formula() -> None:
    (said,) = between((5.0, 10.0, 400.0, 900.0))
    assert "v_rel between 10 and 400 mm/s" in said
    assert "a test at about 63 mm/s would" in said


def test_tests_in_the_fall_need_no_warning() -> None:
    assert between((5.0, 15.0, 45.0, 130.0, 400.0)) == []
