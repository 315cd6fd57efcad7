"""The cards that come with the package, and those of a folder of your own."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path

from ..common import InputError, unknown_name
from ..families.loading import load_model as load_folder
from ..models.base import FrictionModel
from .card import Card, read_card
from .naming import PREFIX, is_card

MAX_CARDS = 1000
_DATA = Path(__file__).parent / "data"


def load_cards(folder: str | os.PathLike[str] | None = None) -> dict[str, Card]:
    """Return the cards of a folder by name, or those of the package.

    Raises
    ------
    InputError
        No folder, more than 1000 files, or a file that is no card.

    Examples
    --------
    >>> len(load_cards()) >= 20
    True
    """
    if folder is None:
        return dict(_own())
    place = Path(folder)
    if not place.is_dir():
        raise InputError(f"{place}: no such folder; allowed: a folder of cards (*.yaml)")
    files = sorted(place.glob("*.yaml"))
    if len(files) > MAX_CARDS:
        raise InputError(f"{place}: {len(files)} cards, allowed: at most {MAX_CARDS}")
    return {f.stem: read_card(f) for f in files}


@cache
def _own() -> dict[str, Card]:
    return load_cards(_DATA)


def load_card(name: str) -> Card:
    """Return one card: of the package by its name, or of your own by the path of its file, with or without ``.yaml``.

    Raises
    ------
    InputError
        No such card; the message names the nearest.

    Examples
    --------
    >>> load_card("card:rock-byerlee").title
    'Friction of rocks (Byerlee)'
    >>> load_card("rock-byerly")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: unknown card ... did you mean 'rock-byerlee'?
    """
    text = name.removeprefix(PREFIX)
    path = Path(text)
    if path.suffix == ".yaml" or len(path.parts) > 1:
        return read_card(path if path.suffix == ".yaml" else path.with_name(path.name + ".yaml"))
    if text not in _own():
        raise unknown_name("card", text, _own())
    return _own()[text]


def load_model(folder: str | os.PathLike[str]) -> FrictionModel:
    """Return a model: that of a folder written by `FrictionModel.save`, or of a card, ``card:NAME``.

    Raises
    ------
    InputError
        No such folder or card, or one that cannot be used.

    Examples
    --------
    >>> load_model("card:cold-forging-median").formula_text()
    'mu = mu0 with mu0 = 0.08'
    """
    return load_card(str(folder)).model() if is_card(folder) else load_folder(folder)


def search_cards(text: str, folder: str | os.PathLike[str] | None = None) -> dict[str, Card]:
    """Return the cards in which all words of `text` stand.

    Examples
    --------
    >>> list(search_cards("rock granite"))
    ['rock-granite-ground']
    """
    return {n: c for n, c in load_cards(folder).items() if c.matches(text)}
