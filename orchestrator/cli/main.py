"""Entry point: turns every error into one sentence and an exit code.

Exit codes: 0 done; 1 something failed; 2 bad input (a file, a name, a value, an option); 130 interrupted.
"""

from __future__ import annotations

import errno
import io
import os
import signal
import sys
from collections.abc import Sequence
from typing import Any

from .common import interrupts
from .common.console import Interrupted

INTERRUPTED = 130
#: Longest sentence that is printed.
LONGEST = 1400
#: Errors of the system that are those of a name: another one helps.
_BAD_NAMES = {
    *(errno.ENOENT, errno.EEXIST, errno.ENOTDIR, errno.EISDIR, errno.EACCES, errno.EPERM),
    *(errno.ENAMETOOLONG, errno.EROFS, errno.ELOOP, errno.EINVAL),
}
#: Errors of a full disk or quota.
_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
#: Whose errors are sentences; those of others are shown with their names.
PACKAGES = ("friction_models", "sct_twin", "forming", "fmus", "orchestrator")
#: Options that take several values: ``--models A B`` is read as ``--models A --models B``.
MANY = ("--models", "--add", "--only", "--platforms", "--column", "--rig", "--causes", "--system")


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and leave with its exit code."""
    # Names of tests and people have any letters; a console or pipe that lacks one (LANG=C, code page 1252) gets its number.
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")
    code = run(sys.argv[1:] if arguments is None else list(arguments))
    # All is done and said: there is nothing left to interrupt.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.exit(code)


def run(arguments: Sequence[str]) -> int:
    """Run the command line and return its exit code; prints one sentence for an error.

    The environment variable ``TRIBOFMU_TRACEBACK`` lets unexpected failures through with their traceback.
    """
    with interrupts.watched():
        try:
            result = _called(arguments)
        except Interrupted as error:
            return _say(str(error), INTERRUPTED)
        except KeyboardInterrupt:
            result = INTERRUPTED
        except BrokenPipeError:
            from .common.console import read_no_more

            read_no_more()
            return 0
        except Exception as error:
            # Foreign code takes an interrupt for an error of its own.
            result = INTERRUPTED if interrupts.received() else _failure(error)
        # Typer keeps it to itself, and says nothing.
        if result == INTERRUPTED or interrupts.received():
            return _say("interrupted; nothing half-written is left", INTERRUPTED)
    return result


def _called(arguments: Sequence[str]) -> int:
    """Call the command. Imports happen here, because Ctrl-C may hit them too."""
    from friction_models.common.build_time import build_time

    # numpy reads it, too, while it is imported, and fails with a sentence that names nothing.
    build_time()
    import typer

    from .app import command

    try:
        result = command()(spread(arguments), prog_name="tribofmu", standalone_mode=False)
    except typer.TyperException as error:
        wrong_usage: Any = error  # it prints itself; the public base class does not declare that
        wrong_usage.show()
        return error.exit_code
    return result if isinstance(result, int) else 0


def spread(arguments: Sequence[str]) -> list[str]:
    """Repeat the name of an option before each of its values, for the options in `MANY`."""
    result: list[str] = []
    current = ""
    values = 0
    for word in arguments:
        if word.startswith("-"):
            current, values = (word if word in MANY else ""), 0
        elif current:
            values += 1
            if values > 1:
                result.append(current)
        result.append(word)
    return result


def _failure(error: Exception) -> int:
    from friction_models.common import InputError

    # The second is pathlib's way to say that a link leads to itself.
    if isinstance(error, InputError) or str(error).startswith("Symlink loop from "):
        return _say(str(error), 2)
    if os.environ.get("TRIBOFMU_TRACEBACK"):
        raise error
    if isinstance(error, OSError) and error.filename is not None:
        return _say(f"{error.filename}: {error.strerror}", 2 if error.errno in _BAD_NAMES else 1)
    if isinstance(error, OSError) and error.errno in _FULL:
        import tempfile

        # Outputs name themselves: what has no name is written beside them, most of it into temporary files.
        place = f"maybe for temporary files in {tempfile.gettempdir()}; TMPDIR chooses another folder"
        return _say(f"{error.strerror}, {place}", 1)
    text = str(error).strip() or type(error).__name__
    ours = type(error).__module__.partition(".")[0] in PACKAGES
    named = text if ours else f"{type(error).__name__}: {text}"
    return _say(named, 1)


def _say(sentence: str, code: int) -> int:
    if code != INTERRUPTED:  # which may have broken off any import
        from friction_models.common import shown

        # Files and FMUs of others say what they like: here it becomes one line of bounded length.
        sentence = f"error: {shown(sentence, LONGEST)}"
    print(f"tribofmu: {sentence}", file=sys.stderr)
    return code
