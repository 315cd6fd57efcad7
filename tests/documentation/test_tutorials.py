"""Tutorials and the gallery are run as they stand: files, commands, code, what they say, pictures."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from .walking import WALKED, Walk, walked


@pytest.mark.parametrize("page", WALKED, ids=lambda p: p.stem)
def test_page_runs_as_it_stands(page: Path, tmp_path: Path) -> None:
    with walked(page, tmp_path) as walk:
        missing = [p.name for p in walk.pictures if not p.is_file()]
    assert walk.pictures, f"{page.name}: no picture"
    assert not missing, f"{page.name}: {missing}; `python -m tests.documentation.walking` draws them"


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("```python\nprint(1 + 1)\n```\n\n```text\n3\n```\n", "not said"),
        ("```sh\ntribofmu evaluate nothing --data nowhere\n```\n", "nowhere|nothing"),
        ("```sh\nrm -rf other\n```\n", "rm -rf other"),
        ("```python\nx = 1\n```\n\n![a](a.svg)\n", "nothing to draw"),
    ],
)
def test_a_page_that_is_wrong_is_noticed(text: str, fault: str, tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(text, encoding="utf-8")
    with pytest.raises(AssertionError, match=fault):
        Walk(page, tmp_path).whole()


def test_every_picture_belongs_to_a_page() -> None:
    drawn = {
        p
        for page in WALKED
        for p in re.findall(r"\]\((?:tutorials/)?(pictures/[^)]+)\)", page.read_text("utf-8"))
    }
    for folder in {page.parent / "pictures" for page in WALKED}:
        assert {f"pictures/{p.name}" for p in folder.glob("*")} <= drawn
