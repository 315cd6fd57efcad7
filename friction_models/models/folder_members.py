"""Which files make a model folder, and whether they are of one model; loads nothing that only models need."""

from __future__ import annotations

from pathlib import Path

from ..common import InputError
from ..common.cached_results import digest, path_digest
from ..common.json_values import JsonObject

CARD, TEXT, ARRAYS, ONNX = "card.json", "card.md", "parameters.npz", "model.onnx"
#: Key of the card: what makes the model, beside the numbers in their file.
MODEL = "model"
#: Key of the card: hashes of the files that say mu, and of its own part that does.
DIGESTS = "sha256"


def digests(folder: Path, model: object) -> dict[str, str]:
    """Return the hashes of the numbers and the graph in a model folder, of those that are there, and of the part `model` of its card."""
    found = {name: path_digest(folder / name) for name in (ARRAYS, ONNX) if (folder / name).is_file()}
    try:
        return {**found, MODEL: digest(model)}
    except (ValueError, RecursionError):  # NaN, which nothing writes; brackets without end
        return {**found, MODEL: "none"}


def check_members(folder: Path, card: JsonObject) -> None:
    """Check that the numbers and the graph in a model folder are those that its card was written with, and its model, too.

    A card of an earlier version names no hashes, or none of its model. Raises InputError, which names the first that is another.
    """
    if DIGESTS not in card:
        return
    named = card[DIGESTS] if isinstance(card[DIGESTS], dict) else {}
    for name, found in digests(folder, card.get(MODEL)).items():
        if name == MODEL and name in named and found != named[name]:
            raise InputError(
                f"{folder}: the model in {CARD} was changed after it was saved, so that it is not that of {ONNX} any more "
                f"(SHA-256 {found[:12]}..., saved as {str(named[name])[:12]}...); allowed: a folder as save() writes it"
            )
        if name != MODEL and found != named.get(name):
            raise InputError(
                f"{folder}: {name} and {CARD} are of two models (SHA-256 {found[:12]}..., in the card "
                f"{str(named.get(name))[:12]}...); allowed: a folder as save() writes it"
            )
