"""The web application: NiceGUI's pages and the files of the project, without the guard."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from ..project import WORK, Project
from ..work.worker import Worker

if TYPE_CHECKING:
    from fastapi import FastAPI

#: A drop between two faces: film and contact.
ICON = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32"><rect width="32" height="32" rx="7" fill="#0a6f6a"/>'
    '<path d="M5 11h22M5 22h22" stroke="#fff" stroke-width="3"/><circle cx="16" cy="16.5" r="3.6" fill="#f0a35e"/></svg>'
)


def build(project: Project, worker: Worker) -> FastAPI:
    """Return the application of a project."""
    # NiceGUI would make a folder where the user is; nothing is stored with it.
    os.environ.setdefault("NICEGUI_STORAGE_PATH", str(project.root / WORK / "storage"))
    from fastapi import FastAPI
    from nicegui import ui

    from ..pages.frame import Workbench
    from ..serving import add_files

    app = FastAPI(openapi_url=None, docs_url=None, redoc_url=None)
    add_files(app, project)
    ui.run_with(
        app,
        root=Workbench(project, worker).root,
        title="tribofmu workbench",
        favicon=ICON,
        dark=None,
        language="en-GB",
        tailwind=False,
        show_welcome_message=False,
        reconnect_timeout=10.0,
        # Packing megabytes of scripts takes longer than sending them over the line of one machine.
        gzip_middleware_factory=None,
    )
    return app
