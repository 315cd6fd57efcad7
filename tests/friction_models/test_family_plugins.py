"""Families that installed packages offer: known by name; one that cannot be used costs a warning."""

from __future__ import annotations

from typing import Any

import pytest

from friction_models import ConstantFriction
from friction_models.common.imports import plugins
from friction_models.families.registry import FAMILIES, load_families


class Theirs(ConstantFriction):
    family = "theirs"


class Nameless(ConstantFriction):
    family = ""


class Entry:
    """Stands for an entry point."""

    name, value = "own", "package:Own"

    def __init__(self, offered: Any) -> None:
        self.offered = offered

    def load(self) -> Any:
        if isinstance(self.offered, Exception):
            raise self.offered
        return self.offered


@pytest.mark.parametrize(
    ("offered", "said"),
    [
        (ImportError("no module named x"), "no module named x"),
        (dict, "not a FrictionModel class"),
        (Nameless, "family = ''; allowed: a text"),
        (ConstantFriction, "the name 'constant' is taken"),
    ],
)
def test_a_family_that_cannot_be_used_is_left_out_with_a_warning(
    offered: Any, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(plugins, "entry_points", lambda group: [Entry(offered), Entry(Theirs)])
    with pytest.warns(UserWarning, match=r"family plug-in 'own' \(package:Own\) is left out: ") as seen:
        families = load_families()
    assert said in str(seen[0].message)
    assert families == FAMILIES | {"theirs": Theirs}
