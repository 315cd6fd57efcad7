"""`pack`, `check`: friction models, forming processes and the twin as FMUs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .console import say
from .options import OutFile, as_number, key_values


def pack(
    model: Annotated[
        str,
        typer.Argument(
            help="Model folder, .onnx file, a number for constant mu, or `forming` or `twin` for the solvers.",
            metavar="MODEL",
        ),
    ],
    out: OutFile,
    target: Annotated[str, typer.Option(help="native (C, no Python) or python (ONNX Runtime).")] = "native",
    fmi: Annotated[str, typer.Option(help="FMI version.")] = "2.0",
    nodes: Annotated[int, typer.Option(min=1, help="Contact points of a friction FMU.")] = 1,
    platforms: Annotated[
        list[str] | None, typer.Option(help="Platforms of a native FMU, for example linux64 win64.")
    ] = None,
    parameters: Annotated[
        list[str] | None,
        typer.Option("--set", help="Parameter of the forming or twin FMU, for example half_angle=45."),
    ] = None,
) -> None:
    """Pack a friction model, the forming process or the twin as an FMU."""
    import fmus
    from friction_models.loads import InputError

    if out.suffix != ".fmu":
        raise InputError(f"{out}: suffix {out.suffix!r}, allowed: .fmu")
    values = key_values(parameters or [])
    if model in {"forming", "twin"}:
        packer = fmus.pack_forming if model == "forming" else fmus.pack_twin
        path = packer(out, **values)
    else:
        if values:
            raise InputError(f"--set {next(iter(values))}: allowed only for the FMUs 'forming' and 'twin'")
        version = "2.0" if fmi == "2" else "3.0" if fmi == "3" else fmi
        source = _source(model)
        path = fmus.pack(source, out, target=target, nodes=nodes, fmi=version, platforms=platforms)
    say(f"FMU written: {path}")


def check(
    fmu: Annotated[Path, typer.Argument(help="FMU file.")],
) -> int:
    """Check an FMU: archive, schema, units, and a reference run; exit code 1 when it fails."""
    import fmus

    report = fmus.check(fmu)
    say(str(report))
    return 0 if report.ok else 1


def _source(model: str) -> object:
    """What `fmus.pack` takes: a model for a number, otherwise the path."""
    from friction_models.loads import InputError

    number = as_number(model)
    if number is not None:
        from friction_models import ConstantFriction

        return ConstantFriction(number)
    path = Path(model)
    if not path.exists():
        raise InputError(
            f"{model}: no such model; allowed: a model folder, an .onnx file, a number, 'forming' or 'twin'"
        )
    return path


def add_commands(app: typer.Typer) -> None:
    """Register the commands of this file."""
    app.command(epilog="Example: tribofmu pack models/polynomial --nodes 80 -o friction.fmu")(pack)
    app.command(epilog="Example: tribofmu check friction.fmu")(check)
