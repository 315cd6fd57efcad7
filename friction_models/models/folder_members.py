"""Which files make a model folder, and whether they are of one model; loads nothing that only models need."""

from __future__ import annotations

from pathlib import Path

from ..common import InputError
from ..common.cached_results import path_digest
from ..common.json_values import JsonObject

CARD, TEXT, ARRAYS, ONNX = "card.json", "card.md", "parameters.npz", "model.onnx"
#: Key of the card: hashes of the files that say mu.
DIGESTS = "sha256"


def digests(folder: Path) -> dict[str, str]:
    """Return the hashes of the numbers and the graph in a model folder, of those that are there."""
    return {name: path_digest(folder / name) for name in (ARRAYS, ONNX) if (folder / name).is_file()}


def check_members(folder: Path, card: JsonObject) -> None:
    """Check that the numbers and the graph in a model folder are those that its card was written with.

    A card of an earlier version names none. Raises InputError, which names the first that is another.
    """
    if DIGESTS not in card:
        return
    named = card[DIGESTS] if isinstance(card[DIGESTS], dict) else {}
    for name, found in digests(folder).items():
        if found != named.get(name):
            raise InputError(
                f"{folder}: {name} and {CARD} are of two models (SHA-256 {found[:12]}..., in the card "
                f"{str(named.get(name))[:12]}...); allowed: a folder as save() writes it"
            )
