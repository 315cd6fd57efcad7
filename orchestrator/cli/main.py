"""Entry point: one place where errors become one sentence and an exit code.

Exit codes: 0 done; 1 something failed; 2 bad input (a file, a name, a value, an option); 130 interrupted.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from .app import app
from .console import Interrupted

#: Options that take several values: ``--models A B`` is read as ``--models A --models B``.
MANY = ("--models", "--add", "--only", "--platforms", "--column", "--rig", "--causes", "--system")


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and leave with its exit code."""
    sys.exit(run(sys.argv[1:] if arguments is None else list(arguments)))


def run(arguments: Sequence[str]) -> int:
    """Run the command line and return its exit code; prints one sentence for an error.

    The environment variable ``TRIBOFMU_TRACEBACK`` lets unexpected failures through with their traceback.
    """
    from typer._click.exceptions import ClickException

    try:
        result = app(spread(arguments), prog_name="tribofmu", standalone_mode=False)
    except ClickException as error:
        error.show()
        return int(error.exit_code)
    except Interrupted as error:
        return _say(str(error), 130)
    except KeyboardInterrupt:
        return _say("interrupted; nothing was written", 130)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except Exception as error:
        return _failure(error)
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
    from friction_models.loads import InputError

    if isinstance(error, InputError):
        return _say(str(error), 2)
    if os.environ.get("TRIBOFMU_TRACEBACK"):
        raise error
    if isinstance(error, FileExistsError | NotADirectoryError | IsADirectoryError | PermissionError):
        return _say(f"{error.filename}: {error.strerror}", 2)
    text = " ".join(str(error).split()) or type(error).__name__
    named = text if type(error).__name__ == "SimulationError" else f"{type(error).__name__}: {text}"
    return _say(named, 1)


def _say(sentence: str, code: int) -> int:
    label = "interrupted" if code == 130 else "error"
    text = sentence if sentence.startswith(label) else f"{label}: {sentence}"
    print(f"tribofmu: {text}", file=sys.stderr)
    return code
