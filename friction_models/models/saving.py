"""Models on disk: a folder with `model.onnx`, `card.json`, `card.md` and `parameters.npz`; never a pickle."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from ..common import atomic_folder, check_folder, folders, write_json, write_text
from .folder_members import ARRAYS, CARD, DIGESTS, MODEL, ONNX, TEXT, digests
from .law import FrictionLaw
from .model_card import card_text


def save_model(model: FrictionLaw, folder: str | os.PathLike[str]) -> Path:
    """Write a fitted model into `folder` (replaced as a whole); return its path.

    Raises InputError: the model is not fitted, or `folder` is a file or holds something else than a model.
    """
    from .onnx_export import export

    target = Path(folder)
    check_folder(target, folders.MODEL)
    content, arrays = model.parts()
    card = model.card
    with atomic_folder(target, folders.MODEL) as temporary:
        write_text(temporary / TEXT, card_text(card))
        np.savez(temporary / ARRAYS, allow_pickle=False, **arrays)
        export(model, temporary / ONNX)
        told = {"format": "tribofmu-model", "format_version": 1, DIGESTS: digests(temporary, content)}
        write_json(temporary / CARD, {**told, **card, MODEL: content})
    return target
