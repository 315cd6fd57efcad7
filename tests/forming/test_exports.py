"""What `from forming import ...` offers, and that type checkers see it."""

import ast
import inspect
from pathlib import Path

import pytest

import forming
from forming.processes.upsetting import UpsettingOptions


def typed_names() -> dict[str, str]:
    """Return the names of the TYPE_CHECKING block and the modules they come from."""
    tree = ast.parse(Path(str(forming.__file__)).read_text(encoding="utf-8"))
    block = next(n for n in tree.body if isinstance(n, ast.If) and ast.unparse(n.test) == "TYPE_CHECKING")
    imports = [statement for statement in block.body if isinstance(statement, ast.ImportFrom)]
    # `import X as X`: only so it counts as handed on, under mypy's strict rules.
    return {a.name: str(i.module) for i in imports for a in i.names if a.asname == a.name}


def test_every_exported_name_is_typed_and_can_be_imported() -> None:
    assert typed_names() == forming._EXPORTS
    assert forming.__all__ == sorted(forming._EXPORTS)
    for name in forming.__all__:
        assert getattr(forming, name) is not None


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="'forming' has no attribute 'ForwardRod'"):
        forming.__getattr__("ForwardRod")


def test_a_ring_takes_the_typed_options_of_upsetting() -> None:
    own = list(inspect.signature(forming.Upsetting).parameters)
    assert [*own[:3], *UpsettingOptions.__annotations__] == own
