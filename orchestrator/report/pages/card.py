"""The page of friction cards: laws, sources, domains and errors in one table, and the response curves of each law."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import pandas as pd

from friction_models.common.markup import paragraph, table
from friction_models.loads import LOAD_NAMES, QUANTITIES, TriboLoads

from ..charts.responses import response_chart
from ..parts.page import Page
from ..parts.theme import looks

if TYPE_CHECKING:
    from friction_models.cards import Card

#: Most cards whose curves are drawn: colours end there.
DRAWN = 6


def card_page(cards: Mapping[str, Card]) -> str:
    """Return the HTML of one or more friction cards."""
    one = next(iter(cards.values())) if len(cards) == 1 else None
    page = Page(
        title=one.title if one else f"{len(cards)} friction cards",
        kicker="tribofmu friction cards",
        lead="Laws with their source, domain and uncertainty. Outside its domain a law keeps its value at the edge.",
        synthetic=any(c.basis == "synthetic" for c in cards.values()),
    )
    headings = ["card", "what", "lubricant", "basis", "law", "domain", "uncertainty of mu", "held-out RMSE (constant)"]  # fmt: skip
    page.add("cards", "Cards", table(headings, [_row(card) for card in cards.values()], range(6, 8)))
    drawn = list(cards.values())[:DRAWN]
    names = [c.name for c in drawn]
    styles = looks(names)
    for card in drawn:
        facts = f"{card.measured[:1].upper()}{card.measured[1:]}. Synthetic: {card.synthetic}. Uncertainty: {card.uncertainty_of}."
        source = paragraph(f"Source: {'; '.join(card.source[k] for k in ('text', 'address', 'licence'))}.")
        shown = [n for n in card.model().needed_loads if card.domain[n][1] > card.domain[n][0]]
        if not shown:
            page.add(
                f"facts-{card.name}", card.title, paragraph(f"{card.model().formula_text()}. {facts}"), source
            )
            continue
        ranges = [n for n, (low, high) in card.domain.items() if high > low]
        columns = dict(zip(LOAD_NAMES, card.sample(200).T))
        loads = TriboLoads.from_frame(pd.DataFrame({n: columns[n] for n in ranges}))
        page.plot(
            f"response-{card.name}",
            card.title,
            response_chart(loads, [(card.name, styles[card.name], card.model())]),
            facts,
            f"Response curves of {card.title}.",
            source,
        )
    if len(cards) > DRAWN:
        page.add(
            "rest", "Not drawn", paragraph(f"{', '.join(list(cards)[DRAWN:])}: ask for each by its name.")
        )
    return page.render()


def _row(card: Card) -> tuple[str, ...]:
    h = card.held_out
    uncertainty = "not stated" if card.uncertainty is None else f"{card.uncertainty:.2g}"
    error = f"{h.rmse:.3g} ({h.constant_rmse:.3g})" if h else "none"
    law, ranges = card.model().formula_text(), card.domain.items()
    domain = ", ".join(f"{n} {low:g} to {high:g} {QUANTITIES[n].unit}" for n, (low, high) in ranges)
    return card.name, card.title, card.lubricant, card.basis, law, domain, uncertainty, error
