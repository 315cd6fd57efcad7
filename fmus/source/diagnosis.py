"""What a diagnosis says of a friction model, as part of the card that its FMU carries."""

from __future__ import annotations

import hashlib
import os
from dataclasses import replace
from pathlib import Path

from ..interface.friction_source import FrictionSource

#: What is taken over; the whole answer stays in its file, which the digest names.
_TAKEN = ("verdict", "sentence", "effects", "confusion_set", "confidence", "model", "synthetic")


def with_diagnosis(source: FrictionSource, path: str | os.PathLike[str]) -> FrictionSource:
    """Return the model with the verdict of a diagnosis, which ``diagnose --json`` wrote to `path`, in its card.

    Raises InputError: no such file, or no diagnosis.
    """
    from friction_models.discovery.answer.changes import read_diagnosis

    file = Path(path)
    answer = read_diagnosis(file)
    told = {key: answer[key] for key in _TAKEN if key in answer}
    told["file_sha256"] = hashlib.sha256(file.read_bytes()).hexdigest()
    return replace(source, card=source.card | {"diagnosis": told})
