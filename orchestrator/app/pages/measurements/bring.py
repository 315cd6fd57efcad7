"""Bringing files: an area to drop files or a folder on, bounded, with checked names."""

from __future__ import annotations

import asyncio
import math
from pathlib import Path

from nicegui import events, ui

from friction_models.common import InputError, atomic_path
from friction_models.common.errors import shown
from sct_twin.ingest.measurement_files import is_test_table
from sct_twin.readers import SUFFIXES

from ...project import history, is_name, name_of
from ...raw.files import MAPS, MOST_FILES, RAW, free_name, set_name
from ..elements import button, heading, say
from ..view import View

#: Largest file that is taken [byte].
LARGEST = 100_000_000
#: So long the page waits for somebody who chooses files [s].
CHOOSING = 600.0


def bring(view: View, title: str, into: str = "") -> None:
    """Show where files can be dropped; they become a new set, or more files of the set `into`."""
    suffixes = sorted({*SUFFIXES, *(MAPS if into else ())})
    target, at_work = into, 0
    with ui.element("section").props('id="bring"'):
        heading(title)
        say(
            f"Records of a data logger or tables of points: {', '.join(suffixes)}; at most {LARGEST / 1e6:.0f} MB a file. A table tests.csv beside "
            "them says what is known of each test.",
            "soft",
        )
        said = ui.element("div").props('role="status"')

        async def taken(event: events.UploadEventArguments) -> None:
            nonlocal target, at_work
            at_work += 1
            try:
                if not target:
                    target = _new_set(view, event.file.name)
                name = await _keep(view, event, target)
            except (InputError, OSError) as error:
                with said:
                    say(_why(view, error), "problem")
                _drop_empty(view, target, into)
                target = into if not (view.project.root / RAW / (target or "-")).is_dir() else target
                return
            finally:
                at_work -= 1
            with said:
                say(f"{name} is in the project.", "soft")

        async def finished() -> None:
            nonlocal target
            # The browser has sent all; a large file may still be on its way to the disk.
            while at_work:
                await asyncio.sleep(0.05)
            try:
                if target and (view.project.root / RAW / target).is_dir():
                    target = target if into else _called_after_measurements(view, target)
                    view.note(history.BROUGHT, data=f"{RAW}/{target}")
                    ui.navigate.to(f"/measurements?raw={target}")
            finally:
                view.let_go()

        def rejected() -> None:
            view.let_go()
            ui.notify("A file is too large, or of a kind that is not read.", type="negative")

        upload = ui.upload(
            multiple=True,
            on_upload=taken,
            auto_upload=True,
            max_file_size=LARGEST,
            max_files=MOST_FILES,
            on_rejected=rejected,
            label="Drop files or a folder here",
        )
        upload.on("start", lambda: view.hold(math.inf), args=[])
        upload.on("finish", finished, args=[])
        upload.on("cancel", view.let_go, args=[])
        upload.props(f'accept="{",".join(suffixes)}" flat bordered').classes("upload")
        ui.run_javascript(f"tribofmu.takeFolders(getElement({upload.id}))")
        # The button of the uploader has no name for a screen reader.
        with ui.element("div").classes("buttons"):
            choose = button("Choose files", lambda: view.hold(CHOOSING))
            choose.on("click", js_handler=f"() => getElement({upload.id}).$refs.qRef.pickFiles()")
            folder = button("Choose a folder", lambda: view.hold(CHOOSING))
            folder.on("click", js_handler=f"() => tribofmu.pickFolder({upload.id})")


def _why(view: View, error: Exception) -> str:
    if isinstance(error, OSError):
        return f"{RAW}: the file cannot be kept ({error.strerror or error}); allowed: a folder that can be written, on a disk with room"
    return view.bare(str(error))


def _check_free(path: Path) -> None:
    if path.exists():
        raise InputError(f"{path.name}: is in the set already; allowed: another name")


def _new_set(view: View, file: str) -> str:
    _check_suffix(name_of(file))
    name = free_name(view.project, RAW, set_name(file))
    view.project.inside(f"{RAW}/{name}").mkdir()
    return name


def _called_after_measurements(view: View, target: str) -> str:
    """Return the name of a new set, another one where only the test table, which came first, gave it its name."""
    folder = view.project.inside(f"{RAW}/{target}")
    files = sorted(p for p in folder.iterdir() if p.suffix.lower() in SUFFIXES)
    measured = [p for p in files if not is_test_table(p)]
    if not measured or target not in {set_name(p.name) for p in files if is_test_table(p)}:
        return target
    name = free_name(view.project, RAW, set_name(measured[0].name))
    folder.rename(folder.with_name(name))
    return name


def _drop_empty(view: View, target: str, into: str) -> None:
    """Take back a new set of which no file was kept."""
    folder = view.project.root / RAW / target
    if target and not into and folder.is_dir() and not any(folder.iterdir()):
        folder.rmdir()


def _check_suffix(name: str) -> None:
    suffix = Path(name).suffix.lower()
    if suffix not in {*SUFFIXES, *MAPS}:
        raise InputError(f"{name}: suffix {suffix!r}; allowed: {', '.join(sorted(SUFFIXES))}")


async def _keep(view: View, event: events.UploadEventArguments, target: str) -> str:
    """Put a file into a set; what is there already is not replaced."""
    file = event.file
    name = name_of(file.name)
    if not is_name(name):
        raise InputError(
            f"{shown(file.name, 60)!r}: no name for a file; allowed: letters, digits, dot, dash and underscore"
        )
    _check_suffix(name)
    if file.size() > LARGEST:
        raise InputError(f"{name}: {file.size()} byte; allowed: at most {LARGEST}")
    if not file.size():
        raise InputError(f"{name}: the file is empty; allowed: a file with measurements")
    folder = view.project.inside(f"{RAW}/{target}")
    if len(list(folder.iterdir())) >= MOST_FILES:
        raise InputError(f"{RAW}/{target}: holds {MOST_FILES} files; allowed: at most so many in one set")
    path = view.project.inside(f"{RAW}/{target}/{name}")
    _check_free(path)
    with atomic_path(path) as temporary:
        await file.save(temporary)
        # Again: another tab may have brought one meanwhile.
        _check_free(path)
    return f"{RAW}/{target}/{name}"
