"""The page of a study whose results are kept in a folder, made again without computing anything."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import cast

from fmus.runtime.errors import of_this_version

from ...studies.saved import SavedStudy
from ..parts.page import StudyManifest


def study_page(folder: Path) -> str | None:
    """Return the HTML of the study in a folder; None where ``manifest.json`` is not that of a study.

    Raises InputError: an unknown study, files that are missing, too large, damaged or of another version.
    """
    saved = SavedStudy.read(folder)
    if saved is None:
        return None
    helps = f"what `tribofmu study {saved.name}` wrote; the same command computes only what is missing"
    with of_this_version(folder, helps):
        return _PAGES[saved.name](saved)


def _learning_curve(saved: SavedStudy) -> str:
    from ...studies.learning_curve.files import read_study
    from ...studies.learning_curve.result import LearningCurves
    from .learning_curve import learning_curve_page

    study, results = read_study(saved)
    return learning_curve_page(study, LearningCurves.of(study, results), _manifest(saved), results)


def _forming_error(saved: SavedStudy) -> str:
    from ...studies.forming_error.files import read_study
    from ...studies.forming_error.result import FormingErrors
    from .forming_error import forming_error_page

    study, results = read_study(saved)
    return forming_error_page(study, FormingErrors.of(study, results), _manifest(saved), results)


def _lag(saved: SavedStudy) -> str:
    from ...studies.lag.result import LagNumbers
    from .lag import lag_page

    return lag_page(cast(LagNumbers, saved.numbers()))


def _extrapolation(saved: SavedStudy) -> str:
    from ...studies.extrapolation.result import ExtrapolationNumbers
    from .extrapolation import extrapolation_page

    return extrapolation_page(cast(ExtrapolationNumbers, saved.numbers()))


def _manifest(saved: SavedStudy) -> StudyManifest:
    return cast(StudyManifest, saved.manifest)


_PAGES: dict[str, Callable[[SavedStudy], str]] = {
    "learning-curve": _learning_curve,
    "forming-error": _forming_error,
    "lag": _lag,
    "extrapolation": _extrapolation,
}
