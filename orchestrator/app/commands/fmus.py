"""The command lines of the page FMU."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from friction_models.common.errors import shown

from ..project.history import ENDED
from .command import Command, short

#: Most contact points of a friction FMU that a page offers.
MOST_NODES = 100_000
TARGETS = {"native": "C code, needs nothing else", "python": "Python with ONNX Runtime"}
#: What a command ends with that was cancelled.
CANCELLED = 130
_IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,59}")
#: Switches of `pack`, by the option.
SWITCHES = {
    "interval": "Also give mu_low and mu_high, the model's prediction interval",
    "arrays": "FMI 3.0: arrays whose length the simulator sets, also with one contact point",
    "ssp": "An SSP archive around the FMU, for simulators of systems",
}


@dataclass(frozen=True)
class PackOptions:
    """How a model is packed; see ``tribofmu pack --help``."""

    fmi: str = "2.0"
    nodes: int = 1
    target: str = "native"
    platforms: tuple[str, ...] = ()
    interval: bool = False
    arrays: bool = False
    ssp: bool = False
    name: str = ""

    def problem(self) -> str:
        """Return in a sentence which options do not go together; empty where they do.

        Examples
        --------
        >>> PackOptions(arrays=True).problem()
        'Arrays of any length are part of FMI 3.0: choose that version, or leave them out.'
        """
        if self.arrays and self.fmi != "3.0":
            return "Arrays of any length are part of FMI 3.0: choose that version, or leave them out."
        if self.name and not _IDENTIFIER.fullmatch(self.name):
            return "A name inside the FMU is one as in C: letters, digits and underscores, no digit first, at most 60."
        if self.platforms and self.target != "native":
            return "Platforms are chosen for C code only: Python runs wherever the simulator's Python does."
        return ""

    @property
    def arguments(self) -> tuple[str, ...]:
        """Options of the command line; those that are the default are left out."""
        options = (
            ("--target", self.target, "native"),
            ("--fmi", self.fmi, "2.0"),
            ("--nodes", str(self.nodes), "1"),
            ("--platforms", ",".join(self.platforms), ""),
            ("--name", self.name, ""),
        )
        given = [word for option, value, default in options if value != default for word in (option, value)]
        return (*given, *(f"--{name}" for name in SWITCHES if getattr(self, name)))

    @property
    def suffix(self) -> str:
        """What tells the file from others of the same model.

        Examples
        --------
        >>> PackOptions().suffix, PackOptions("3.0", 80, "python", interval=True).suffix
        ('', '-fmi3-80-python-interval')
        """
        parts = [
            "" if self.fmi == "2.0" else f"fmi{self.fmi[0]}",
            "" if self.nodes == 1 else str(self.nodes),
            "" if self.target == "native" else self.target,
            *self.platforms,
            *(name for name in SWITCHES if name != "ssp" and getattr(self, name)),
            self.name,
        ]
        return "".join(f"-{part}" for part in parts if part)


def pack(model: str, options: PackOptions) -> Command:
    """Pack a model as an FMU.

    Examples
    --------
    >>> pack("models/linear", PackOptions("3.0", 80)).line
    'tribofmu pack models/linear --fmi 3.0 --nodes 80 -o fmus/linear-fmi3-80.fmu'
    """
    file = f"fmus/{short(model)}{options.suffix}.{'ssp' if options.ssp else 'fmu'}"
    return Command(f"Pack {short(model)} as an FMU", ("pack", model, *options.arguments, "-o", file))


def last_check(lines: Sequence[Mapping[str, object]], fmu: str) -> tuple[str, str]:
    """Return how the last check of an FMU ended by the history, and when (UTC); two empty texts where there was none.

    Examples
    --------
    >>> line = {"event": "ended", "command": "tribofmu check fmus/a.fmu", "code": 0, "time": "2026-11-20T10:00:07+00:00"}
    >>> last_check([line], "fmus/a.fmu"), last_check([line], "fmus/b.fmu")
    (('passed', '2026-11-20 10:00'), ('', ''))
    """
    asked = check(fmu).line
    checks = [line for line in lines if line["event"] == ENDED and line.get("command") == asked]
    # Who cancels a check learns nothing of the FMU.
    ended = [line for line in checks if line.get("code") != CANCELLED]
    if not ended:
        return "", ""
    when = shown(ended[-1].get("time", ""), 40)[:16].replace("T", " ")
    return "passed" if ended[-1].get("code") == 0 else "failed", when


def check(fmu: str) -> Command:
    """Check an FMU."""
    return Command(f"Check {short(fmu)}", ("check", fmu))
