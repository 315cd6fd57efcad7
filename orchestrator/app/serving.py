"""Files of the project over HTTP: downloads, and reports as pages that can do nothing here."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path
from urllib.parse import quote

from fastapi import FastAPI
from fastapi.responses import FileResponse, PlainTextResponse, Response

from friction_models.common import InputError

from .project import Project

#: A report draws its charts with its own script; sandboxed, it has no access to the workbench, its cookie or the network.
_REPORT = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data:; frame-ancestors 'none'"
)
#: The page inside an FMU needs no script at all.
_FMU_PAGE = "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src data:; frame-ancestors 'none'"
#: Where it is, and its largest size [byte].
_PAGE, _LARGEST_PAGE = "documentation/index.html", 5_000_000


def add_files(app: FastAPI, project: Project) -> None:
    """Add the addresses ``/files/PATH`` (to keep) and ``/page/PATH`` (to read) to the application."""

    @app.get("/files/{path:path}")
    def download(path: str) -> Response:
        return _file(project, path, inline=False)

    @app.get("/page/{path:path}")
    def page(path: str) -> Response:
        return _file(project, path, inline=True)

    @app.get("/fmu-page/{path:path}")
    def fmu_page(path: str) -> Response:
        try:
            content = _documentation(project.inside(path))
        except InputError as error:
            return PlainTextResponse(f"{error}\n", 404)
        if content is None:
            return PlainTextResponse("no such page in the FMU\n", 404)
        return Response(content, media_type="text/html", headers={"content-security-policy": _FMU_PAGE})


def page_address(path: str) -> str:
    """Return the address of the page inside an FMU of the project.

    Examples
    --------
    >>> page_address("fmus/linear.fmu")
    '/fmu-page/fmus/linear.fmu'
    """
    return f"/fmu-page/{quote(path)}"


def has_page(file: Path) -> bool:
    """Whether an FMU has a page that can be shown."""
    try:
        with zipfile.ZipFile(file) as archive:
            return archive.getinfo(_PAGE).file_size <= _LARGEST_PAGE
    except (OSError, KeyError, ValueError, NotImplementedError, zipfile.BadZipFile):
        return False


def _documentation(file: Path) -> bytes | None:
    """Return the page inside an FMU, which may be anybody's: bounded, whatever its archive says of its size."""
    if file.suffix != ".fmu" or not file.is_file():
        return None
    try:
        with zipfile.ZipFile(file) as archive, archive.open(_PAGE) as page:
            content = page.read(_LARGEST_PAGE + 1)
    except (OSError, KeyError, ValueError, RuntimeError, EOFError, zipfile.BadZipFile, zlib.error):
        return None
    return content if len(content) <= _LARGEST_PAGE else None


def address(path: str, read: bool = False) -> str:
    """Return the address of a file of the project, to be kept or (`read`, HTML only) to be read.

    Examples
    --------
    >>> address("fmus/linear.fmu"), address("reports/a b.html", read=True)
    ('/files/fmus/linear.fmu', '/page/reports/a%20b.html')
    """
    return f"/{'page' if read else 'files'}/{quote(path)}"


def _file(project: Project, path: str, inline: bool) -> Response:
    try:
        file = project.inside(path)
    except InputError as error:
        return PlainTextResponse(f"{error}\n", 404)
    if not file.is_file() or (inline and file.suffix != ".html"):
        return PlainTextResponse("no such file in the project\n", 404)
    if inline:
        return FileResponse(file, media_type="text/html", headers={"content-security-policy": _REPORT})
    kind = f"attachment; filename*=UTF-8''{quote(file.name)}"
    return FileResponse(
        file,
        media_type="application/octet-stream",
        headers={"content-disposition": kind, "cache-control": "no-store"},
    )
