"""What fmpy's validation finds in a model description."""

from __future__ import annotations

import re
from pathlib import Path

#: Structured variable names as both versions of the standard define them.
_PART = r"(?:[A-Za-z_]\w*|'(?:[^'\\]|\\.)+')(?:\[\d+(?:,\d+)*\])?"
_NAME = re.compile(rf"{_PART}(?:\.{_PART})*|der\({_PART}(?:\.{_PART})*(?:,\d+)?\)", re.ASCII)


def problems_of(path: Path) -> list[str]:
    """Return what fmpy's validation finds; its check of names, 3 ms each, is made here."""
    from fmpy import read_model_description
    from fmpy.model_description import ValidationError

    try:
        description = read_model_description(
            str(path), validate=True, validate_variable_names=False, validate_model_structure=True
        )
    except ValidationError as error:
        return [str(problem) for problem in error.problems]
    except Exception as error:  # fmpy raises plain exceptions
        return [str(error) or type(error).__name__]
    structured = description.variableNamingConvention == "structured"
    return [
        f"variable name {v.name[:80]!r} is not allowed by the naming convention of the FMU"
        for v in description.modelVariables
        if (not _NAME.fullmatch(v.name) if structured else re.search(r"[\r\n\t]", v.name))
    ]
