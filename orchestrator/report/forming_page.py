"""The page of a forming result, made by `forming` itself."""

from __future__ import annotations

from pathlib import Path


def forming_page(folder: Path) -> str:
    """Return the HTML of a folder written by `forming.FormingResult.save`."""
    from forming.results.files import load_result
    from forming.results.page import report_page

    return report_page(*load_result(folder))
