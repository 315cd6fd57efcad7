"""The server of the workbench: opens the project, builds the pages, listens, guards, and opens the browser."""

from __future__ import annotations

import importlib.util
import os
import socket
import sys
import threading
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING

from friction_models.common import InputError
from friction_models.common.locks import locked

from ..project import WORK, Project
from ..work.worker import Worker
from .guard import LOOPBACK, Access, Guard, machine_names

if TYPE_CHECKING:
    from fastapi import FastAPI

#: The first port that is tried, and how many behind it.
PORT, PORTS = 8420, 50
PASSWORD = "TRIBOFMU_APP_PASSWORD"
SHORTEST = 12
#: A drop between two faces: film and contact.
ICON = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32"><rect width="32" height="32" rx="7" fill="#0a6f6a"/>'
    '<path d="M5 11h22M5 22h22" stroke="#fff" stroke-width="3"/><circle cx="16" cy="16.5" r="3.6" fill="#f0a35e"/></svg>'
)


def serve(
    folder: Path,
    port: int | None = None,
    host: str = "127.0.0.1",
    browser: bool = True,
    example: bool = False,
) -> None:
    """Serve the workbench of a project until it is interrupted.

    Raises InputError: NiceGUI is missing; no project folder; a port that is taken; a host beyond loopback without a password.
    """
    if importlib.util.find_spec("nicegui") is None:
        raise InputError("app: needs NiceGUI, which is not installed; pip install 'tribofmu[app]' brings it")
    password = _password(host)
    project = Project.open(folder, example)
    with locked(
        project.root / WORK / "lock",
        f"{folder}: another workbench has this project open; allowed: one at a time",
    ):
        listening = _listen(host, port)
        access = Access(
            listening.getsockname()[1], password=password, names=machine_names() if password else ()
        )
        _run(project, access, listening, host, browser)


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach a server that listens there."""
    return host in {"127.0.0.1", "localhost", "::1"}


def _password(host: str) -> str:
    if is_loopback(host):
        return ""
    found = os.environ.get(PASSWORD, "")
    if len(found) < SHORTEST:
        raise InputError(
            f"--host {host}: everybody who reaches this machine could use the workbench, run its commands and read the project, "
            f"and nothing is encrypted on the way; allowed: with a password of at least {SHORTEST} characters in the environment "
            f"variable {PASSWORD}, in a network that you trust; or 127.0.0.1"
        )
    return found


def _listen(host: str, port: int | None) -> socket.socket:
    tried = [port] if port is not None else [*range(PORT, PORT + PORTS), 0]
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    for number in tried:
        listening = socket.socket(family, socket.SOCK_STREAM)
        if sys.platform != "win32":
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listening.bind((host, number))
        except OSError as error:
            listening.close()
            if number == tried[-1]:
                raise InputError(
                    f"--host {host} --port {number}: {error.strerror}; allowed: a free port"
                ) from None
            continue
        # Who comes before the server is ready waits, and is not turned away.
        listening.listen(128)
        return listening
    raise AssertionError("the last port either is bound or raises")


def _application(project: Project, worker: Worker) -> FastAPI:
    """Return the pages and files of a project as an application, without the guard."""
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


def _run(project: Project, access: Access, listening: socket.socket, host: str, browser: bool) -> None:
    import uvicorn

    worker = Worker(project)
    guarded = Guard(_application(project, worker), access)
    name = LOOPBACK[0] if is_loopback(host) and ":" not in host else f"[{host}]" if ":" in host else host
    if name == "0.0.0.0":
        name = machine_names()[0]
    address = f"http://{name}:{access.port}/"
    shown = address if access.password else f"{address}?token={access.token}"
    print(f"workbench of {project.root}\nopen {shown}\nCtrl-C ends it", flush=True)
    if access.password:
        note = "note: others on the network reach it with the password; nothing is encrypted"
        print(note, file=sys.stderr, flush=True)
    server = uvicorn.Server(
        uvicorn.Config(
            guarded, log_level="warning", access_log=False, ws_max_size=20_000_000, timeout_graceful_shutdown=2,
            server_header=False, date_header=False, proxy_headers=False,
        )
    )  # fmt: skip
    if browser:
        threading.Timer(0.4, _open, (shown,)).start()
    try:
        server.run(sockets=[listening])
    finally:
        worker.close()


def _open(address: str) -> None:
    """Open the browser; without one the printed address is enough."""
    try:
        webbrowser.open(address)
    except (webbrowser.Error, OSError):
        print("note: no browser could be opened", file=sys.stderr)
