"""`pack`, `check`, `export`: friction models, forming processes and the twin as FMUs, systems as SSP."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from friction_models.common import InputError, check_outputs

from ..common.console import say
from ..common.files_named import Commands, Reads, Writes
from ..common.options import Names, Swap, as_number, key_values, swapped

app = Commands(rich_markup_mode="rich")

Boundary = Annotated[
    bool,
    typer.Option(
        "--boundary", help="SSP: open inputs and outputs become those of the system (for fmucontainer)."
    ),
]


@app.command(
    epilog="Examples: tribofmu pack models/polynomial --nodes 80 -o friction.fmu;  "
    "tribofmu pack my.onnx --spec my.yaml --fmi 3 --platforms all -o friction.fmu;  "
    "tribofmu pack models/polynomial --target ufric -o subroutine"
)
def pack(
    model: Annotated[
        str,
        typer.Argument(
            help="Model folder, .onnx file, card:NAME, a number for constant mu, or `forming` or `twin` for the solvers.",
            metavar="MODEL",
        ),
        Reads(),
    ],
    out: Annotated[
        Path,
        typer.Option("-o", "--out", help="FMU (.fmu) to write; a folder for the exports."),
        Writes("EITHER"),
    ],
    target: Annotated[
        str | None,
        typer.Option(
            help="native (C, needs nothing; default), python (ONNX Runtime) or map (FMI 3: a table of mu that can be "
            "calibrated, FMI-LS-STRUCT). Exports for codes without FMUs: "
            "c, ufric (Marc, Simufact), vfric and abaqus (Abaqus: code, table), deform, lsdyna, qform, radioss, calculix, "
            "table. Of the solvers: python (default) or process."
        ),
    ] = None,
    fmi: Annotated[str | None, typer.Option(help="FMI version, 2 (default) or 3 (a map).")] = None,
    nodes: Annotated[int, typer.Option(min=1, help="Contact points of a friction FMU.")] = 1,
    arrays: Annotated[
        bool,
        typer.Option(
            "--arrays",
            help="FMI 3: arrays whose length `n` the simulator can set, also with one contact point. Without it one "
            "point is scalars, which more simulators load.",
        ),
    ] = False,
    name: Annotated[
        str | None,
        typer.Option(
            help="Name of the friction FMU as in C (modelIdentifier); else it is made of the family and a hash."
        ),
    ] = None,
    platforms: Annotated[
        list[str] | None,
        typer.Option(help="Platforms of a native FMU, by commas: linux64,aarch64-linux,win64,macos; or all."),
    ] = None,
    spec: Annotated[
        Path | None, typer.Option(help="YAML file with names, units and domain of your own .onnx file.")
    ] = None,
    ssp: Annotated[
        bool,
        typer.Option("--ssp", help="Write an SSP archive (.ssp) around the FMU, for simulators of systems."),
    ] = False,
    boundary: Boundary = False,
    interval: Annotated[
        bool,
        typer.Option(
            "--interval",
            help="Friction FMU: also the outputs mu_low and mu_high, the model's prediction interval.",
        ),
    ] = False,
    diagnosis: Annotated[
        Path | None,
        typer.Option(
            help="What `diagnose --json` wrote: its verdict is packed with the friction model.",
            metavar="FILE",
        ),
        Reads(),
    ] = None,
    parameters: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            help="Parameter of a solver FMU (process=fre, bce, upsetting or ring; half_angle=45) or option of an export or map: tolerance=1e-3, axes=v_rel,T.",
        ),
        Reads(),
    ] = None,
) -> None:
    """Pack a friction model, a forming process or the twin: as an FMU, or for codes that load none."""
    import fmus

    # The name of a steel may look like a number: 1.2379.
    values = key_values(parameters or [], ("material", "tool_material"))
    wanted = [name for text in platforms or [] for name in text.replace(",", " ").split()] or None
    if model in {"forming", "twin"}:
        if spec is not None or ssp or interval:
            raise InputError(f"--spec, --ssp and --interval: allowed for friction models, not for {model!r}")
        if arrays or name is not None or diagnosis is not None:
            raise InputError(
                f"--arrays, --name and --diagnosis: allowed for friction models, not for {model!r}"
            )
        if nodes != 1 or fmi not in {None, "2", "2.0"}:
            points = "--set n_points=80" if model == "forming" else "neither"
            raise InputError(f"--nodes and --fmi are those of friction FMUs; allowed for {model!r}: {points}")
        packer = fmus.pack_forming if model == "forming" else fmus.pack_twin
        path = packer(out, target=target or "python", platforms=wanted, **values)
        say(f"written: {path}")
        return
    from fmus.source.reading import read_source
    from fmus.targets.packing import as_map, with_diagnosis

    chosen = target or "native"
    source = read_source(_source(model), spec=spec, target=chosen)
    if chosen == "map":  # its note tells how far the map is from the model
        source, values = as_map(source, **values), {}
    if diagnosis is not None:
        source = with_diagnosis(source, diagnosis)
    options = {"target": chosen, "nodes": nodes, "fmi": fmi, "platforms": wanted, **values}
    options |= {key: value for key, value in (("interval", interval), ("arrays", arrays)) if value}
    options |= {} if name is None else {"name": name}
    if boundary and not (ssp or out.suffix == ".ssp"):
        raise InputError("--boundary: belongs to an archive; allowed: with --ssp or a file .ssp")
    if ssp or out.suffix == ".ssp":
        path = fmus.pack_ssp(source, out, boundary=boundary, **options)
    else:
        path = fmus.pack(source, out, **options)
    say(f"written: {path}")
    if source.note:
        say(source.note)
    # What a host that takes numbers cannot follow, and the error that remains.
    for report in (path / "table.json", path / "fit.json"):
        if path.is_dir() and report.is_file():
            told = json.loads(report.read_text(encoding="utf-8"))
            say("\n".join([told["summary"], *told["held"]]))


@app.command(epilog="Example: tribofmu check friction.fmu")
def check(
    fmu: Annotated[Path, typer.Argument(help="FMU file.")],
    time_limit: Annotated[
        float, typer.Option(min=1.0, help="Longest time that the trial runs may take [s].")
    ] = 600.0,
) -> int:
    """Check an FMU: archive, schema, units, and a reference run; exit code 1 when it fails."""
    import fmus

    report = fmus.check(fmu, time_limit=time_limit)
    say(str(report))
    return 0 if report.ok else 1


@app.command(epilog="Example: tribofmu export fre.yaml --swap friction=friction.fmu -o fre.ssp")
def export(
    system: Annotated[Path, typer.Argument(help="System description (YAML).")],
    out: Annotated[Path, typer.Option("-o", "--out", help="SSP archive (.ssp) to write."), Writes()],
    swap: Swap = None,
    names: Names = None,
    boundary: Boundary = False,
) -> None:
    """Write a system and its FMUs as one SSP archive, which other simulators load."""
    from ...cosim.system import System

    description = swapped(System.load(system), swap, names)
    check_outputs([out], [description.fmu_path(name) for name in description.components])
    say(f"written: {description.export(out, boundary=boundary)}")


def _source(model: str) -> object:
    """What `fmus.pack` takes: a model for a number, otherwise the path or the name of a card."""
    from friction_models.cards import is_card

    number = as_number(model)
    if number is not None:
        from friction_models import ConstantFriction

        return ConstantFriction(number)
    if is_card(model):
        return model
    path = Path(model)
    if not path.exists():
        raise InputError(
            f"{model}: no such model; allowed: a model folder, an .onnx file, card:NAME, a number, 'forming' or 'twin'"
        )
    return path
