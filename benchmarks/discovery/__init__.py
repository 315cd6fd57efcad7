"""How well missing effects are found, on campaigns made by code of their own, in forms outside the catalogue."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

from friction_models.common import write_json

from ..common import Section
from . import chain, protocols, sequential, study


@dataclass(frozen=True)
class Sizes:
    """How many campaigns of each case."""

    seeds: int = 12
    chain: int = 1
    protocols: int = 3
    sequential: int = 4

    def keep(self, folder: Path) -> None:
        """Write the sizes beside the results, for whoever prints them again."""
        write_json(folder / "sizes.json", asdict(self))

    @classmethod
    def kept(cls, folder: Path) -> Sizes:
        """Return the sizes of the results in a folder, the usual ones where there are none."""
        file = folder / "sizes.json"
        return cls(**json.loads(file.read_text(encoding="utf-8"))) if file.is_file() else cls()


def all_parts(folder: Path, sizes: Sizes, tell: Callable[[str], None] = print) -> list[Section]:
    """Run what is not in `folder` yet; return the tables of all parts."""
    parts: list[Section] = []
    if sizes.seeds:
        parts.append(study.summary(study.run_all(folder, sizes.seeds, tell)))
    if sizes.chain:
        parts.append(chain.summary(chain.run_all(folder, sizes.chain, tell)))
    if sizes.protocols:
        parts.append(protocols.summary(protocols.run_all(folder, sizes.protocols, tell)))
    if sizes.sequential:
        parts.append(sequential.summary(sequential.run_all(folder, sizes.sequential, tell=tell)))
    return parts


def measure(folder: Path) -> Section:
    """Return all parts as one section of the benchmark page, of the sizes that are kept in ``folder/discovery``."""
    place = folder / "discovery"
    first, *others = all_parts(place, Sizes.kept(place))
    lines = list(first["lines"])
    for part in others:
        lines += ["", f"### {part['title']}", "", part["text"], *part["lines"]]
    return {**first, "lines": lines}
