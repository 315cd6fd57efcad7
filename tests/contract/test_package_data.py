"""An installed package holds every file that the sources hold, not only its Python modules."""

from __future__ import annotations

import tomllib
from fnmatch import fnmatch
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGES = ("friction_models", "forming", "sct_twin", "fmus", "orchestrator")


def test_every_file_beside_the_modules_is_installed() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
    patterns = settings["package-data"]["*"]
    beside = [
        f
        for package in PACKAGES
        for f in (ROOT / package).rglob("*")
        if f.is_file() and f.suffix != ".py" and f.parent.name != "__pycache__"
    ]
    assert len(beside) > 30
    left_out = [str(f.relative_to(ROOT)) for f in beside if not any(fnmatch(f.name, p) for p in patterns)]
    assert not left_out
