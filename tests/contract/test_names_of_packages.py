"""Names that a package imports at first use are there for `dir()`, by which notebooks complete them."""

from __future__ import annotations

import importlib

import pytest

PACKAGES = ["friction_models", "fmus", "forming", "orchestrator", "sct_twin"]
PARTS = ["cards", "discovery", "loads", "training"]


@pytest.mark.parametrize("name", [*PACKAGES, *(f"friction_models.{part}" for part in PARTS)])
def test_all_public_names_are_listed(name: str) -> None:
    package = importlib.import_module(name)
    assert package.__all__ and set(package.__all__) <= set(dir(package))
    assert "__name__" in dir(package)
