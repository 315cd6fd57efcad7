"""All pages: what each shows, how its folder is known, and the function that makes it."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from friction_models.common import unknown_name


@dataclass(frozen=True)
class PageKind:
    """A kind of page.

    Attributes
    ----------
    name : str
    shows : str
        In a few words.
    function : str
        ``"module:function"``, imported at use: charts and what they draw take a second to import.
    marker : str
        File by which a folder with such a page is known; empty where a command gives the content.
    """

    name: str
    shows: str
    function: str
    marker: str = ""

    def html(self, *content: Any) -> str | None:
        """Return the page as HTML; None for a folder with the marker of this kind that is of another kind."""
        module, _, function = self.function.partition(":")
        html: str | None = getattr(import_module(module), function)(*content)
        return html


_HERE = __package__
#: Folders first, in the order in which they are tried.
PAGES = {
    kind.name: kind
    for kind in (
        PageKind("demo", "the loop of a demo", f"{_HERE}.demo_page:demo_page", "demo.json"),
        PageKind("study", "what a study found", f"{_HERE}.study_pages:study_page", "manifest.json"),
        PageKind("run", "a co-simulation", f"{_HERE}.run_page:run_page", "manifest.json"),
        PageKind(
            "prediction", "predicted tests", f"{_HERE}.prediction_page:prediction_page", "prediction.json"
        ),
        PageKind("forming", "a forming result", f"{_HERE}.forming_page:forming_page", "forming.json"),
        PageKind("diagnosis", "what a model is missing", f"{_HERE}.diagnosis_page:diagnosis_page"),
        PageKind("refinement", "a model before and after", f"{_HERE}.refinement_page:refinement_page"),
        PageKind("comparison", "models beside each other", f"{_HERE}.comparison_page:comparison_page"),
        PageKind("coverage", "loads that were never tested", f"{_HERE}.coverage_page:coverage_page"),
        PageKind("attribution", "causes of a deviation", f"{_HERE}.attribution_page:attribution_page"),
        PageKind("learning-curve", "tests needed", f"{_HERE}.learning_curve_page:learning_curve_page"),
        PageKind("forming-error", "errors of forces", f"{_HERE}.forming_error_page:forming_error_page"),
        PageKind("lag", "what one-step lag costs", f"{_HERE}.lag_page:lag_page"),
        PageKind(
            "extrapolation", "friction beyond the tests", f"{_HERE}.extrapolation_page:extrapolation_page"
        ),
    )
}


def page_of(name: str, *content: Any) -> str:
    """Return the page of a kind, from the content that its function takes.

    Raises
    ------
    InputError
        No such kind.
    """
    if name not in PAGES:
        raise unknown_name("page", name, PAGES)
    return PAGES[name].html(*content) or ""


def page_of_folder(folder: Path) -> str | None:
    """Return the page of a folder by the files in it; None where there is no page for it."""
    for kind in PAGES.values():
        if kind.marker and (folder / kind.marker).is_file() and (html := kind.html(folder)) is not None:
            return html
    return None
