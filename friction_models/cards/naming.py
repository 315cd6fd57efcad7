"""How a card is named where a model is taken: ``card:NAME``, or ``card:FOLDER/NAME`` for one of your own."""

from __future__ import annotations

PREFIX = "card:"


def is_card(text: object) -> bool:
    """Whether a name of a model is that of a card.

    Examples
    --------
    >>> is_card("card:rock-byerlee"), is_card("models/linear")
    (True, False)
    """
    return isinstance(text, str) and text.startswith(PREFIX)
