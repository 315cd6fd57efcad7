"""An installed package holds every file that the sources hold, not only its Python modules."""

from __future__ import annotations

import tomllib
from fnmatch import fnmatch
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGES = ("friction_models", "forming", "sct_twin", "fmus", "orchestrator")


def test_every_file_beside_the_modules_is_installed() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
    patterns = dict(settings["package-data"])
    everywhere = patterns.pop("*")
    own = [f"{package.replace('.', '/')}/{p}" for package, found in patterns.items() for p in found]
    beside = [
        f
        for package in PACKAGES
        for f in (ROOT / package).rglob("*")
        if f.is_file() and f.suffix != ".py" and f.parent.name != "__pycache__"
    ]
    assert len(beside) > 30
    left_out = [
        name
        for f in beside
        if not any(fnmatch(f.name, p) for p in everywhere)
        and not any(fnmatch(name := f.relative_to(ROOT).as_posix(), p) for p in own)
    ]
    assert not left_out
