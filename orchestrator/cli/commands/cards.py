"""`cards`: the library of friction laws, listed, searched, shown and drawn."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from friction_models.common import InputError

from ..common.console import say, write_page, write_result
from ..common.files_named import Commands
from ..common.options import Json, Report

app = Commands(rich_markup_mode="rich")


@app.command(
    epilog="Examples: tribofmu cards;  tribofmu cards seal-kdn --report seal.html;  tribofmu cards --search oil;  "
    "tribofmu pack card:motor-oil-steel-glass -o friction.fmu;  tribofmu compare --models card:seal-kdn 0.08 --data data"
)
def cards(
    name: Annotated[
        str | None, typer.Argument(help="Name of a card, or path of your own; without it all are listed.")
    ] = None,
    search: Annotated[str | None, typer.Option(help="Words that must stand in the card.")] = None,
    folder: Annotated[Path | None, typer.Option(help="Folder of your own cards (*.yaml).")] = None,
    json: Json = None,
    report: Report = None,
) -> None:
    """List, search, show and draw friction cards: laws with source, domain and uncertainty.

    A card is a model: `card:NAME`, or `card:FOLDER/NAME` for one of your own, stands wherever a model is taken.
    """
    from friction_models.cards import load_card, load_cards, search_cards

    if name is not None:
        if search is not None:
            raise InputError("--search: looks through all cards; allowed: without the name of one")
        path = name if folder is None else str(folder / f"{name}.yaml")
        card = load_card(path)
        found = {card.name: card}
        say(card.text())
    else:
        found = load_cards(folder) if search is None else search_cards(search, folder)
        width = max(map(len, found), default=0)
        for key, each in found.items():
            held = f"; held-out RMSE {each.held_out.rmse:.3g}" if each.held_out else ""
            say(f"{key:{width}}  {each.title} ({each.basis}{held})")
        if not found:
            say("no card" if search is None else f"no card holds the words {search!r}")
    write_result(json, {key: each.to_dict() for key, each in found.items()})
    write_page(report, "cards", found)
