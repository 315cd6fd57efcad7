"""Files that the options of a command name. A command never overwrites what it reads, and keeps what it replaces."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

import typer

from .given_once import GivenOnce

F = TypeVar("F", bound=Callable[..., Any])


@dataclass(frozen=True)
class Reads:
    """Annotates an option whose texts may name input files, also as ``name=PATH``. Options of type `Path` need no mark."""


@dataclass(frozen=True)
class Writes:
    """Annotates an option that names an output."""

    #: Name of a kind of folder in `friction_models.common.folders`; ``FILE``; ``PAGE``, a file that a page can be written
    #: to; or ``EITHER``, which is checked when it is known what is written.
    kind: str = "FILE"


class Commands(typer.Typer):
    """Commands whose outputs are checked against their inputs before anything is done."""

    def command(self, name: str | None = None, **named: Any) -> Callable[[F], F]:
        """Register a command as Typer does."""
        register = super().command(name, **{"cls": GivenOnce, **named})

        def registered(function: F) -> F:
            register(_checked(function))
            return function

        return registered


def _checked(function: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(function)
    def command(**values: Any) -> Any:
        from friction_models.common.replaced_outputs import keeping_earlier

        from .console import note

        with keeping_earlier(_check(function, values)) as moved:
            try:
                return function(**values)
            finally:
                for name, now in moved:
                    note(f"{name}: what was there before is kept as {now}")

    return command


def _check(function: Callable[..., Any], values: dict[str, Any]) -> list[Path]:
    """Check inputs and outputs; return the outputs that are written anew as a whole."""
    from friction_models.common import check_file, check_folder, check_outputs, folders

    anew: list[Path] = []
    outputs: list[tuple[Path, Writes]] = []
    inputs: list[Path] = []
    hints = get_type_hints(function, include_extras=True)
    for name, value in values.items():
        marks = [m for m in getattr(hints[name], "__metadata__", ()) if isinstance(m, Reads | Writes)]
        writes = [m for m in marks if isinstance(m, Writes)]
        if not writes:
            inputs += _named(value, bool(marks))
        elif value is not None:
            paths = value if isinstance(value, list) else [value]
            outputs += [(path, mark) for path in paths for mark in writes]
    # What is wrong with the pair is told before what is wrong with the output alone.
    check_outputs([path for path, _ in outputs], inputs)
    for path, mark in outputs:
        if mark.kind == "PAGE":
            from ...report.writing import check_page_file

            check_page_file(path)
        kind = getattr(folders, mark.kind, None)
        if mark.kind in {"FILE", "PAGE"}:
            check_file(path)
        elif kind is None:
            folders.check_parents(path)
        else:
            check_folder(path, kind)
        if not isinstance(kind, folders.GrowingKind):
            anew.append(path)
        elif kind is folders.STUDY and path.is_dir():
            # Its jobs are continued; what was made of them is written anew.
            anew += [file for file in path.iterdir() if file.is_file() and file.name != "failed.json"]
    return anew


def _named(value: Any, texts: bool) -> Iterator[Path]:
    """Yield the files and folders that a value names and that are there."""
    if isinstance(value, list | tuple):
        for item in value:
            yield from _named(item, texts)
    elif isinstance(value, Path):
        yield from _there(value)
    elif isinstance(value, str) and texts:
        for text in (value, value.partition("=")[2]):
            yield from _there(Path(text)) if text else ()


def _there(path: Path) -> Iterator[Path]:
    with contextlib.suppress(OSError, ValueError):  # no name at all is a matter of who reads it
        if path.exists():
            yield path
