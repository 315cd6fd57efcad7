"""Renaming sets of measurement files and putting them aside: a folder is moved inside of the project, and never deleted."""

from __future__ import annotations

import os
import shlex

from friction_models.common import InputError

from ..project import HISTORY, Project, history, is_name
from .files import RAW, free_name, set_name

#: Where sets are kept that no page shows as measurements any more.
ASIDE = "aside"


def aside(project: Project, name: str) -> str:
    """Return where a set would be put aside: not in place of another that was called so.

    Examples
    --------
    >>> from pathlib import Path
    >>> aside(Project(Path("/nowhere"), ""), "oil")
    'aside/oil'
    """
    return f"{ASIDE}/{free_name(project, ASIDE, name)}"


def own_set(project: Project, file: str) -> str:
    """Move a file of a set into a set of its own, write it into the history, and return the name of the set.

    Raises InputError: no such file.
    """
    path = project.inside(file)
    if not path.is_file() or path.parent.parent != project.root / RAW:
        raise InputError(f"{file}: no such file of measurements in the project")
    name = free_name(project, RAW, set_name(path.name))
    folder, target = f"{RAW}/{name}", f"{RAW}/{name}/{path.name}"
    project.inside(folder).mkdir()
    path.rename(project.inside(target))
    # What one types in the project folder to do the same.
    command = f"{shlex.join(['mkdir', folder])} && {shlex.join(['mv', file, target])}"
    history.add(project.root / HISTORY, history.MOVED, command=command)
    return name


def moved_to(project: Project, place: str) -> str:
    """Return where a set of files is now that was moved from a place; empty where the history knows of none."""
    now = place
    for entry in history.read(project.root / HISTORY):
        try:
            words = shlex.split(str(entry.get("command", ""))) if entry["event"] == history.MOVED else []
        except ValueError:
            continue
        if words[:1] == ["mv"] and len(words) == 3 and words[1] == now:
            now = words[2]
    top, _, name = now.partition("/")
    known = now != place and top in {RAW, ASIDE} and is_name(name) and (project.root / now).is_dir()
    return now if known else ""


def move(project: Project, source: str, target: str) -> None:
    """Move a set of files, and write it into the history.

    Raises InputError: no such set; a name that is none, or is taken.
    """
    folder, new = project.inside(source), project.inside(target)
    if not folder.is_dir():
        raise InputError(f"{source}: no such folder in the project")
    if target.split("/")[0] not in {RAW, ASIDE} or not is_name(new.name):
        raise InputError(
            f"{new.name!r}: no name for a set of files; allowed: letters, digits, dot, dash and underscore"
        )
    if os.path.lexists(new):
        raise InputError(f"{target}: is there already; allowed: another name")
    new.parent.mkdir(exist_ok=True)
    folder.rename(new)
    history.add(project.root / HISTORY, history.MOVED, command=shlex.join(["mv", source, target]))
