"""What `-o` may be: a free name, or somebody's folder, an input, a parent that is a file, a name that is too long."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from .stock import Box, put_foreign


@dataclass
class Output:
    """Where the output goes.

    Attributes
    ----------
    text : str
        What stands for ``{out}`` in the command line; an ending follows where the command wants a file.
    label : str
        For the report.
    prepare : callable or None
        Puts something at the final path.
    """

    text: str
    label: str = ""
    prepare: Callable[[Path], None] | None = field(default=None, repr=False)


def _folder(path: Path) -> None:
    path.mkdir(parents=True)
    put_foreign(path)


def _file(path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"years of work\n")


def drawn(draw: random.Random, box: Box, bad: Path, bare: bool) -> Output:
    """Return an output, an ordinary one in three of four cases.

    Parameters
    ----------
    draw : random.Random
    box : Box
    bad : Path
        The damaged input.
    bare : bool
        Whether ``{out}`` stands alone, for a folder.
    """
    usual = str(box.known["out"])
    if draw.random() < 0.72:
        return Output(usual)
    place = box.place
    choices = [
        Output(usual, "-o names a folder of somebody else", _folder),
        Output(usual, "-o names a folder of somebody else", _folder),
        Output(usual, "-o names a file of somebody else", _file),
        Output(str(place / "plain.txt" / "out"), "-o below a file", lambda p: _file(place / "plain.txt")),
        Output(str(place / ("n" * 300)), "-o too long"),
        Output(str(place / ("n" * 245)), "-o nearly too long"),
        Output(str(place / ("\N{GREEK SMALL LETTER MU}" * 122)), "-o nearly too long, in two bytes a letter"),
        Output(str(place / "x" / "y" / "out"), "-o in folders that are not there yet"),
        Output(
            usual, "-o is a link to a folder of somebody else", lambda p: p.symlink_to(box.root / "neighbour")
        ),
        Output(usual, "-o is a link to nowhere", lambda p: p.symlink_to(place / "nowhere")),
        Output(usual, "-o is a link to an input", lambda p: p.symlink_to(box.root / "points.csv")),
        Output(str(place / "a name with spaces, \N{SNOWMAN} and 'quotes'"), "-o with an odd name"),
        Output(str(bad.with_suffix("")) if not bare else str(bad), "-o names the input"),
    ]
    if bare:
        choices += [
            Output(".", "-o names the folder it runs in"),
            Output("..", "-o names the folder above"),
            Output("", "-o is empty"),
            Output(usual + "/", "-o with a slash"),
            Output(str(box.root / "data"), "-o names a data set"),
            Output(str(box.root / "linear"), "-o names a model"),
            Output(str(box.root / "more/run"), "-o names a run"),
            Output(str(box.root / "neighbour"), "-o names a folder of somebody else", None),
            Output(str(box.root), "-o names a folder with everything in it"),
        ]
    return draw.choice(choices)
