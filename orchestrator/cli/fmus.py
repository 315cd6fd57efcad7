"""`pack`, `check`: friction models, forming processes and the twin as FMUs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .console import say
from .options import as_number, key_values


def pack(
    model: Annotated[
        str,
        typer.Argument(
            help="Model folder, .onnx file, a number for constant mu, or `forming` or `twin` for the solvers.",
            metavar="MODEL",
        ),
    ],
    out: Annotated[Path, typer.Option("-o", "--out", help="FMU (.fmu) to write; a folder for the exports.")],
    target: Annotated[
        str | None,
        typer.Option(
            help="native (C, needs nothing; default) or python (ONNX Runtime). Exports for codes without FMUs: "
            "c, ufric (Marc, Simufact), vfric (Abaqus), table. Of the solvers: python (default) or process."
        ),
    ] = None,
    fmi: Annotated[str, typer.Option(help="FMI version, 2 or 3.")] = "2.0",
    nodes: Annotated[int, typer.Option(min=1, help="Contact points of a friction FMU.")] = 1,
    platforms: Annotated[
        list[str] | None,
        typer.Option(help="Platforms of a native FMU: linux64, aarch64-linux, win64, macos, or all."),
    ] = None,
    spec: Annotated[
        Path | None, typer.Option(help="YAML file with names, units and domain of your own .onnx file.")
    ] = None,
    parameters: Annotated[
        list[str] | None,
        typer.Option(
            "--set", help="Parameter of a solver FMU or option of an export: half_angle=45, tolerance=1e-3."
        ),
    ] = None,
) -> None:
    """Pack a friction model, a forming process or the twin: as an FMU, or for codes that load none."""
    import fmus
    from friction_models.loads import InputError

    values = key_values(parameters or [])
    if model in {"forming", "twin"}:
        if spec is not None:
            raise InputError(f"--spec {spec}: allowed only for an .onnx file")
        if nodes != 1 or fmi not in {"2", "2.0"}:
            raise InputError(
                f"--nodes and --fmi are those of friction FMUs; allowed for {model!r}: --set n_points=80"
                if model == "forming"
                else f"--nodes and --fmi are those of friction FMUs; {model!r} has none"
            )
        packer = fmus.pack_forming if model == "forming" else fmus.pack_twin
        path = packer(out, target=target or "python", platforms=platforms, **values)
    else:
        path = fmus.pack(
            _source(model),
            out,
            target=target or "native",
            nodes=nodes,
            fmi=fmi,
            platforms=platforms,
            spec=spec,
            **values,
        )
    say(f"written: {path}")


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
    app.command(
        epilog="Examples: tribofmu pack models/polynomial --nodes 80 -o friction.fmu;  "
        "tribofmu pack my.onnx --spec my.yaml --fmi 3 --platforms all -o friction.fmu;  "
        "tribofmu pack models/polynomial --target ufric -o subroutine"
    )(pack)
    app.command(epilog="Example: tribofmu check friction.fmu")(check)
