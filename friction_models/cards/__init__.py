"""Friction cards: laws from public measurements and from the literature, each with source, domain and uncertainty."""

from __future__ import annotations

import os

from ..families.loading import load_model as _load_folder
from ..models.base import FrictionModel
from .card import Card, HeldOut, read_card
from .library import PREFIX, is_card, load_card, load_cards, search_cards
from .prior import fit_from_card

__all__ = [
    "PREFIX",
    "Card",
    "HeldOut",
    "fit_from_card",
    "is_card",
    "load_card",
    "load_cards",
    "load_model",
    "read_card",
    "search_cards",
]


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
    return load_card(str(folder)).model() if is_card(folder) else _load_folder(folder)
