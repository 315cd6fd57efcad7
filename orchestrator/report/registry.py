"""All pages: what each shows, how its folder is known, and the function that makes it."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from friction_models.common import unknown_name


class PageKind(NamedTuple):
    """A kind of page: what it shows, its ``"module:function"``, and the file by which a folder with such a page is known.

    The function is imported at use: charts and what they draw take a second to import. `marker` is empty where a command
    gives the content.

    Examples
    --------
    >>> PAGES["run"].shows, PAGES["run"].marker
    ('a co-simulation', 'manifest.json')
    """

    shows: str
    function: str
    marker: str = ""

    def html(self, *content: Any) -> str | None:
        """Return the page as HTML; None for a folder with the marker of this kind that is of another kind."""
        module, _, function = self.function.partition(":")
        html: str | None = getattr(import_module(f".{module}", __package__), function)(*content)
        return html


#: Folders first, in the order in which they are tried.
PAGES = {
    "demo": PageKind("the loop of a demo", "pages.demo:demo_page", "demo.json"),
    "study": PageKind("what a study found", "study_pages.saved_study:study_page", "manifest.json"),
    "run": PageKind("a co-simulation", "pages.run:run_page", "manifest.json"),
    "prediction": PageKind("predicted tests", "pages.prediction:prediction_page", "prediction.json"),
    "forming": PageKind("a forming result", "registry:forming_page", "forming.json"),
    "diagnosis": PageKind("what a model is missing", "pages.diagnosis:diagnosis_page"),
    "refinement": PageKind("a model before and after", "pages.refinement:refinement_page"),
    "comparison": PageKind("models beside each other", "pages.comparison:comparison_page"),
    "cards": PageKind("friction cards", "pages.card:card_page"),
    "story": PageKind("the story of a project", "pages.story:story_page"),
    "coverage": PageKind("loads that were never tested", "pages.coverage:coverage_page"),
    "attribution": PageKind("causes of a deviation", "pages.attribution:attribution_page"),
    "learning-curve": PageKind("tests needed", "study_pages.learning_curve:learning_curve_page"),
    "forming-error": PageKind("errors of forces", "study_pages.forming_error:forming_error_page"),
    "lag": PageKind("what one-step lag costs", "study_pages.lag:lag_page"),
    "extrapolation": PageKind("friction beyond the tests", "study_pages.extrapolation:extrapolation_page"),
}


def forming_page(folder: Path) -> str:
    """Return the page of a forming result, which `forming` makes itself."""
    from forming.results.files import load_result
    from forming.results.pictures.page import report_page

    return report_page(*load_result(folder))


def page_of(name: str, *content: Any) -> str:
    """Return the page of a kind, from the content that its function takes.

    Raises InputError: no such kind.

    Examples
    --------
    >>> page_of("runn")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: unknown page 'runn'; allowed: ...
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
