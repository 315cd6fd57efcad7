"""Start of Python in child processes, safe from modules in the folder that the user is in.

Python takes modules from the current folder before its own when it starts with ``-c`` or ``-m``: a file
``json.py`` of the user would run in place of Python's. Children start without that folder. Folders of the user come
last in their path, so that functions of the user's modules are found, but hide nothing.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager

# Nothing is imported before the path is that of the parent.
_START = (
    f"import sys; sys.path[:] = sys.argv.pop(1).split({os.pathsep!r}); "
    "import importlib; importlib.import_module(sys.argv.pop(1)).main()"
)


def python_command(module: str, *arguments: str) -> list[str]:
    """Return the command that calls ``main()`` of a module in a new process; `arguments` are its ``sys.argv[1:]``."""
    return [sys.executable, "-P", "-c", _START, os.pathsep.join(safe_path()), module, *arguments]


def safe_path() -> list[str]:
    """Return where this process finds modules, with the current folder and that of the main script at the end.

    Examples
    --------
    >>> sorted(safe_path()) == sorted(os.path.normpath(os.path.join(os.getcwd(), p)) for p in sys.path)
    True
    """
    try:
        here = os.getcwd()
    except OSError:  # it was removed
        here = os.path.sep
    main = getattr(sys.modules.get("__main__"), "__file__", None)
    users = {here} | ({os.path.dirname(os.path.join(here, main))} if main else set())
    places = [os.path.normpath(os.path.join(here, place)) for place in sys.path]
    return [p for p in places if p not in users] + [p for p in places if p in users]


@contextmanager
def safe_start() -> Iterator[None]:
    """Let processes that `multiprocessing` spawns in this block start as those of `python_command` do.

    An interrupt from the keyboard reaches only this process: it ends the others itself.
    """
    path = sys.path[:]
    sys.path[:] = safe_path()
    try:
        with environment(PYTHONSAFEPATH="1"), _interrupts_held():
            yield
    finally:
        sys.path[:] = path


@contextmanager
def environment(**values: str) -> Iterator[None]:
    """Set environment variables in a block, for this process and for those that start in it.

    Examples
    --------
    >>> with environment(TRIBOFMU_EXAMPLE="on"):
    ...     os.environ["TRIBOFMU_EXAMPLE"]
    'on'
    >>> "TRIBOFMU_EXAMPLE" in os.environ
    False
    """
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Hold an interrupt back until the end of the block; what starts in it never gets one."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
