"""What `from forming import ...` offers."""

import inspect

import pytest

import forming
from forming.processes.upsetting import UpsettingOptions


def test_every_exported_name_can_be_imported() -> None:
    assert "ForwardRodExtrusion" in forming.__all__ and len(forming.__all__) > 15
    for name in forming.__all__:
        assert getattr(forming, name) is not None


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="'forming' has no attribute 'ForwardRod'"):
        forming.__getattr__("ForwardRod")


def test_a_ring_takes_the_typed_options_of_upsetting() -> None:
    own = list(inspect.signature(forming.Upsetting).parameters)
    assert [*own[:3], *UpsettingOptions.__annotations__] == own
