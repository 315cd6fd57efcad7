"""Data that several benchmarks share: one full virtual campaign after the twin, and models trained on it."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

from friction_models import FrictionModel, make_model
from friction_models.loads import DataSet
from friction_models.training import train
from sct_twin import SctTwin, virtual_lab

PLAN = "factorial-81+30"
_ROOT = Path(__file__).parents[1]


@cache
def sources(*packages: str) -> str:
    """Return a short hash of the source code of packages: what was made by other code is made again."""
    digest = hashlib.sha256()
    for package in packages:
        for file in sorted((_ROOT / package).rglob("*.py")):
            digest.update(str(file.relative_to(_ROOT)).encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()[:12]


def raw_folder(folder: Path, hidden: str | None, seed: int, plan: str = PLAN) -> Path:
    """Return where the raw records of a campaign lie."""
    return folder / "campaigns" / sources("sct_twin", "forming") / f"{plan}-{hidden or 'null'}-{seed}"


def campaign(folder: Path, hidden: str | None, seed: int, plan: str = PLAN) -> DataSet:
    """Return the data set of a campaign after the twin; made once, then read."""
    raw = raw_folder(folder, hidden, seed, plan)
    data = raw.parent / f"{raw.name}-data"
    if not (raw / "campaign.json").is_file():
        virtual_lab.Campaign(plan=plan, hidden=hidden, seed=seed).run(out=raw)
    if not (data / "dataset.json").is_file():
        SctTwin().run(raw, out=data)
    return DataSet.load(data)


def models(folder: Path) -> dict[str, FrictionModel]:
    """Return a linear, a polynomial and a network model of one campaign."""
    data = campaign(folder, "stribeck", 1)
    found = {}
    for family in ("linear", "polynomial", "ffnn"):
        model = make_model(family)
        train(model, data)
        found[family] = model
    return found
