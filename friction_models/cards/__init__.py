"""Friction cards: laws from public measurements and from the literature, each with source, domain and uncertainty."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..common.imports.lazy_names import lazily

if TYPE_CHECKING:
    from .card import Card as Card
    from .card import HeldOut as HeldOut
    from .card import read_card as read_card
    from .library import load_card as load_card
    from .library import load_cards as load_cards
    from .library import load_model as load_model
    from .library import search_cards as search_cards
    from .naming import PREFIX as PREFIX
    from .naming import is_card as is_card
    from .prior import fit_from_card as fit_from_card

__getattr__, __dir__, __all__ = lazily(__name__, __file__)
