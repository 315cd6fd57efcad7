"""The site of the documentation is read and resolved without a warning: every page in it, no dead link, docstrings that are text."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from .test_pages import PAGES, ROOT

DOCS = ROOT / "docs"


@pytest.mark.nightly
def test_the_site_has_no_warning(tmp_path: Path) -> None:
    pytest.importorskip("sphinx")
    # The builder that writes nothing reads all pages and follows all links.
    command = [
        sys.executable,
        "-m",
        "sphinx",
        "-q",
        "-W",
        "--keep-going",
        "-b",
        "dummy",
        "-c",
        "docs",
        ".",
        str(tmp_path),
    ]
    done = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": str(ROOT)}
    )
    assert done.returncode == 0, done.stderr


def test_every_page_has_its_place() -> None:
    named: set[str] = set()

    def gather(part: object) -> None:
        if isinstance(part, dict):
            named.update(str(part[key]) for key in ("root", "file") if key in part)
        for inner in part.values() if isinstance(part, dict) else part if isinstance(part, list) else ():
            gather(inner)

    gather(yaml.safe_load((DOCS / "_toc.yml").read_text(encoding="utf-8")))
    here = {str(page.relative_to(ROOT).with_suffix("")) for page in PAGES}
    assert here <= named
    reference = {name for name in named if name.startswith("docs/reference/")}
    assert named - here - reference == {"CHANGELOG"}
