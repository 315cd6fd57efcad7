"""Solver FMUs for every simulator: a native front that starts the Python solver as a process of its own."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Sequence
from pathlib import Path

from friction_models.common import InputError

from ..archive.content import content_guid
from ..interface.description import Description, to_xml
from ..slaves.core import SolverConfig
from ..slaves.protocol import package_version

MAIN = "front_fmi2.c"
#: Files of the front, `MAIN` first.
SOURCES = (MAIN, "front.h", "front_child.h", "front_posix.h", "front_win32.h", "front_more.h")


def process_fmu_files(
    description: Description,
    solver: str,
    config: SolverConfig,
    platforms: Sequence[str] | None = None,
    python: str | None = None,
) -> dict[str, bytes]:
    """Return the files of a solver FMU with the native front, by their path in the archive.

    The GUID of the description is filled with a hash of the content. `solver` is a name that `fmus.slaves.server` knows,
    `python` the interpreter that the FMU starts when TRIBOFMU_PYTHON is not set; ``python3`` or ``python`` on PATH by
    default, which keeps the FMU free of this machine's folders.
    Raises InputError: `python` is not one line; unknown platform; no compiler.
    """
    from ..native.compile import build, fmi_headers

    folder = Path(__file__).parents[1] / "native"
    texts = {name: (folder / name).read_text(encoding="utf-8") for name in SOURCES}
    description = dataclasses.replace(description, sources=[MAIN])
    model = front_model(solver, config)
    content = {n: t.encode() for n, t in texts.items()} | {"front_model.h": model.encode()}
    files: dict[str, bytes] = {}
    if python is not None:
        if not python or not python.isprintable() or len(python.encode()) > 4000:
            raise InputError(
                f"python = {python!r}, allowed: path or name of an interpreter, one line of at most 4000 bytes"
            )
        files["resources/python.txt"] = f"{python}\n".encode()
    guid = content_guid(content | {"modelDescription.xml": to_xml(description)})
    texts["front_model.h"] = f'#define TF_GUID "{guid}"\n{model}'
    texts |= fmi_headers()
    binaries = build(texts, MAIN, description.identifier, platforms)
    files |= {f"sources/{n}": t.encode() for n, t in texts.items()}
    files |= {f"binaries/{n}": b for n, b in binaries.items()}
    files["modelDescription.xml"] = to_xml(dataclasses.replace(description, guid=guid))
    return files


def front_model(solver: str, config: SolverConfig) -> str:
    """Return `front_model.h`: variables, start values and what the solver process is told.

    Examples
    --------
    >>> config = {"names": ["mu", "speed"], "start": [0.1, 20.0], "first_input": 0, "first_parameter": 1, "further": 0,
    ...           "flags": 0}
    >>> "#define TF_REALS 2" in front_model("forming", config)
    True
    """
    names = config["names"]
    # The process needs the names of the parameters only; the front has all of them.
    told = config | {"names": [""] * config["first_parameter"] + names[config["first_parameter"] :]}
    content = json.dumps(told, separators=(",", ":"), sort_keys=True).encode()
    packed_by = package_version() or "of unknown version"
    lines = [
        "/* What one solver FMU is; generated. */",
        f"#define TF_REALS {len(names)}",
        f"#define TF_FIRST_INPUT {config['first_input']}",
        f"#define TF_FIRST_PARAMETER {config['first_parameter']}",
        f"#define TF_FLAGS {config['flags']}",
        f"#define TF_FURTHER {config['further']}",
        f'#define TF_SOLVER "{solver}"',
        f'#define TF_PACKED_BY "{packed_by}"',
        "static const char *const tf_names[TF_REALS] = {",
        *(f"    {json.dumps(name)}," for name in names),
        "};",
        "static const double tf_start[TF_REALS] = {",
        *(f"    {float(value).hex()}," for value in config["start"]),
        "};",
        f"static const unsigned char tf_config[{len(content)}] = {{",
        *("    " + "".join(f"{b}," for b in content[i : i + 30]) for i in range(0, len(content), 30)),
        "};",
    ]
    return "\n".join(lines) + "\n"
