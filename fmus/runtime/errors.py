"""Errors of a running co-simulation, and sentences for several problems at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from friction_models.common import InputError


class SimulationError(RuntimeError):
    """A component failed while the system ran; the message names component, time and cause."""


class SimulationEnded(Exception):
    """A component ended the simulation in the middle of a step; the message names component and time."""


@contextmanager
def of_this_version(place: Path, allowed: str) -> Iterator[None]:
    """Call what is missing in the files of a folder, or is of another type, by its name; `allowed` says what helps."""
    try:
        yield
    except InputError:
        raise
    except (
        KeyError,
        TypeError,
        ValueError,
        IndexError,
        AttributeError,
        OverflowError,
        StopIteration,
    ) as error:
        said = " ".join(f"{type(error).__name__}: {error}".split())[:150]
        raise InputError(
            f"{place}: its files are damaged or of another version ({said}); allowed: {allowed}"
        ) from error


def collected(where: str, problems: Sequence[str]) -> InputError:
    """Join the problems found in one place into one error, so that all of them are seen at once.

    Examples
    --------
    >>> print(collected("system.yaml", ["no component 'friction'", "stop_time is missing"]))
    system.yaml: 2 problems:
      1. no component 'friction'
      2. stop_time is missing
    """
    if len(problems) == 1:
        return InputError(f"{where}: {problems[0]}")
    listed = "".join(f"\n  {k}. {text}" for k, text in enumerate(problems, 1))
    return InputError(f"{where}: {len(problems)} problems:{listed}")
