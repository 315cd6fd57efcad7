"""Files of the project over HTTP: downloads, and reports as pages that can do nothing here."""

from __future__ import annotations

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


def add_files(app: FastAPI, project: Project) -> None:
    """Add the addresses ``/files/PATH`` (to keep) and ``/page/PATH`` (to read) to the application."""

    @app.get("/files/{path:path}")
    def download(path: str) -> Response:
        return _file(project, path, inline=False)

    @app.get("/page/{path:path}")
    def page(path: str) -> Response:
        return _file(project, path, inline=True)


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
