"""A command line of `tribofmu`, and how one is read back from the history."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass, field
from pathlib import PurePosixPath

from friction_models.common import InputError
from friction_models.common.errors import shown

from ..project import Project


@dataclass(frozen=True)
class Command:
    """A command line of `tribofmu`; its `title` says to people what it does."""

    title: str
    #: Behind ``tribofmu``; paths are relative to the project.
    arguments: tuple[str, ...]
    #: What the history keeps with its end.
    more: dict[str, object] = field(default_factory=dict)
    #: Whether it takes a second or two, and runs beside a long one.
    quick: bool = False

    @property
    def places(self) -> set[str]:
        """Files and folders that it names, two levels deep: commands that share one do not run at once.

        Examples
        --------
        >>> sorted(Command("", ("twin", "campaigns/a", "-o", "data/a/more", "--jobs", "2")).places)
        ['campaigns/a', 'data/a']
        """
        return {"/".join(a.split("/")[:2]) for a in self.arguments if "/" in a}

    @property
    def line(self) -> str:
        """The line as one types it in the project folder."""
        return shlex.join(["tribofmu", *self.arguments])


def command_of(line: str, project: Project, title: object = None, more: object = None) -> Command | None:
    """Return the command of a line of the history; None where it is none, or names a place outside of the project.

    Examples
    --------
    >>> from pathlib import Path
    >>> project = Project(Path("/tmp"), "example")
    >>> command_of("tribofmu check fmus/a.fmu", project, "Check a").title
    'Check a'
    >>> [command_of(f"tribofmu {text}", project) for text in ("app x", "check ../a.fmu", "pack m -o/a", "-x")]
    [None, None, None, None]
    """
    try:
        words = shlex.split(line)
    except ValueError:
        return None
    if (
        len(words) < 2
        or words[0] != "tribofmu"
        or words[1] == "app"
        or not re.fullmatch(r"[a-z][a-z-]*", words[1])
    ):
        return None
    for word in words[2:]:
        if word.startswith("-") and not re.fullmatch(r"-[a-zA-Z]|--[a-z][a-z-]*", word.split("=")[0]):
            return None
        for text in (word, *word.split("=")[1:]):
            if text.startswith("~"):
                return None
            if "/" in text or "\\" in text or text.startswith("."):
                try:
                    project.inside(text)
                except InputError:
                    return None
    return Command(shown(title or line, 100), tuple(words[1:]), dict(more) if isinstance(more, dict) else {})


def effect_names(found: object) -> list[str]:
    """Return the names of effects in a list from a file: texts that the command line takes for names.

    Examples
    --------
    >>> effect_names(["stribeck", "factor:batch", "--force", 3, "a\\nb", ""])
    ['stribeck', 'factor:batch']
    """
    names = found if isinstance(found, list) else []
    return [
        n for n in names if isinstance(n, str) and n.isprintable() and n[:1] not in {"", "-"} and len(n) < 200
    ]


def short(name: str) -> str:
    """Return the name of a data set or model without its folder and suffix.

    Examples
    --------
    >>> short("data/sct"), short("data/lab.csv"), short("linear"), short("0.08"), short("data")
    ('sct', 'lab', 'linear', '0.08', 'data')
    """
    path = PurePosixPath(name)
    return path.stem if path.suffix in {".csv", ".parquet", ".fmu", ".onnx"} else path.name
