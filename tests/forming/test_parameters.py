"""Parameters as the processes declare them: complete, and the ranges are those that the constructors keep."""

from __future__ import annotations

import inspect

import pytest

from forming.processes.names import PROCESSES
from forming.processes.parameters import declared
from friction_models.common import InputError


@pytest.mark.parametrize("process", PROCESSES)
def test_every_number_is_declared_and_its_limits_are_those_that_are_kept(process: str) -> None:
    found = declared(process)
    assert all(p.meaning for p in found.values())
    for name in ("speed", "T_tool", "diameter", "material", "n_points"):
        assert name in found
    for parameter in found.values():
        if parameter.low is None or parameter.high is None:
            assert parameter.kind in {"switch", "material"}
            continue
        margin = 1 if parameter.kind == "count" else 1e-3 * parameter.high
        for value in (parameter.low - margin, parameter.high + margin):
            with pytest.raises(InputError, match=parameter.name):
                PROCESSES[process](**{parameter.name: value})


def test_what_the_form_offers_is_what_the_constructor_takes() -> None:
    own = inspect.signature(PROCESSES["fre"]).parameters
    assert list(declared("fre")) == list(own)
    assert {n: p.default for n, p in declared("fre").items()} == {n: p.default for n, p in own.items()}


def test_a_name_or_value_that_cannot_be_is_a_sentence() -> None:
    with pytest.raises(InputError, match="did you mean 'half_angle'"):
        declared("fre", {"half_angel": 3})
    with pytest.raises(InputError, match="allowed: 10 to 80 degrees"):
        declared("fre", {"half_angle": 3})
