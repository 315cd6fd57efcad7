"""Self-contained HTML reports, one page a subject (see `registry`). They work offline and print well.

`pages` and `study_pages` are made of `sections`, these of `charts`, and all of `parts`; `writing` writes a page, `reading` reads one back.
"""

from __future__ import annotations

import os
from pathlib import Path

from fmus.runtime.errors import of_this_version
from friction_models.common import InputError

from .registry import page_of_folder
from .writing import check_page_file, write_page_file


def write_report(folder: str | os.PathLike[str], out: str | os.PathLike[str] | None = None) -> Path:
    """Write the report of a demo, a run, a study, predicted tests or a forming result; return its path.

    Parameters
    ----------
    folder : path-like
        A folder written by `demo` (with ``demo.json``), by `simulate` or `study` (with ``manifest.json``), by `predict-sct`
        (with ``prediction.json``) or by `forming.FormingResult.save` (with ``forming.json``).
    out : path-like, optional
        HTML, PDF or XLSX file; by default ``report.html`` in the folder.

    Raises
    ------
    InputError
        None of these, or files of it are missing; `out` cannot be written, see `writing.check_page_file`.

    Examples
    --------
    >>> write_report("no-such-run")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: no-such-run: no such folder; allowed: the folder of a run, a study, predicted tests or a demo
    """
    place = Path(folder)
    target = Path(out) if out is not None else place / "report.html"
    check_page_file(target)
    if not place.is_dir():
        what = "is a file" if place.exists() else "no such folder"
        raise InputError(f"{place}: {what}; allowed: the folder of a run, a study, predicted tests or a demo")
    with of_this_version(place, "what this version wrote; run the command that made it again"):
        page = page_of_folder(place)
    if page is not None:
        return write_page_file(target, page)
    inside = sorted(p.parent.name for p in place.glob("*/manifest.json"))
    hint = f"; inside is {place / inside[0]}" if inside else ""
    raise InputError(
        f"{place}: neither a folder of a run or a study (manifest.json) nor one of the demo (demo.json), of predicted tests "
        f"(prediction.json) or of a forming result (forming.json); allowed: one of them{hint}"
    )
