"""``python -m tests.interop -o docs/interoperability.md``: run every case and write what came out."""

from __future__ import annotations

import argparse
import math
import os
import platform
import tempfile
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

from friction_models.common import write_text

from .cases import CASES
from .comparing import Case, Result
from .forming import INCREMENTS, MARKERS, compare_forming
from .machines import MACHINES
from .masters import compare_masters
from .programs import PROGRAMS
from .rows_before import of_case, of_machine, rows_before
from .running import missing, version
from .subjects import POINTS, STEP, STEPS, Subjects

_HEADS = ("client", "version", "FMI", "kind", "shape", "model", "result", "largest deviation of mu", "remark")


def row(case: Case, result: Result) -> tuple[str, ...]:
    """Return a row of the table."""
    outcome = {"agrees": "agrees", "differs": "other values", "refused": "not supported by the client"}
    text = outcome[result.outcome]
    if case.supported and result.outcome == "refused":
        text = "FAILED"
    elif not case.supported and result.outcome == "differs":
        text = "not supported by the client"
    deviation = "" if math.isnan(result.deviation) else f"{result.deviation:.1e}"
    seen = result.seen.replace("|", "/")
    return case.client, str(case.version), case.fmi, case.form, case.shape, case.model, text, deviation, seen


def table(heads: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> list[str]:
    """Return a markdown table."""
    lines = ["| " + " | ".join(heads) + " |", "|" + " --- |" * len(heads)]
    return [*lines, *("| " + " | ".join(line) + " |" for line in rows)]


def main() -> None:
    """Run everything and write the page."""
    parser = argparse.ArgumentParser(prog="python -m tests.interop", description=__doc__)
    parser.add_argument("-o", "--out", type=Path, default=Path("docs/interoperability.md"))
    chosen = parser.parse_args()
    rows = []
    absent: set[str] = set()
    before = rows_before(chosen.out)
    with tempfile.TemporaryDirectory(prefix="tribofmu-") as place:
        folder = Path(place)
        (folder / "subjects").mkdir()
        subjects = Subjects(folder / "subjects")
        for k, case in enumerate(CASES):
            if case.version is None:
                absent.update(missing(name) for name in case.needs if version(name) is None)
                known = of_case(before, case)
                rows += [known] if known is not None else []
                continue
            print(case.label, flush=True)
            rows.append(row(case, case.run(case, subjects, folder / f"case-{k}")))
        machines = []
        for machine in MACHINES:
            print(machine.label, flush=True)
            found = machine.row(subjects, folder / machine.name)
            known = of_machine(before, found) if found[3].startswith("not run") else None
            if known is not None:
                absent.add(f"{found[0]} ({found[3].removeprefix('not run: ')})")
            machines.append(known or found)
        masters = compare_masters(subjects, folder / "masters")
        masters += compare_forming(subjects, folder / "forming")
    lines = [
        "# Interoperability",
        "",
        "Written by `python -m tests.interop -o docs/interoperability.md` from what it ran; nothing here is typed by hand.",
        "",
        f"Each client runs friction FMUs of two models (one without and one with memory; a map is the first as a table of parameters) over {STEPS} steps of {STEP} s with changing "
        f"loads; N and n are {POINTS} contact points with different loads. mu after each step is compared with the model's own "
        "NumPy `predict` on the same loads (of a map: with SciPy's interpolation in it), in which neither ONNX nor generated C takes part; the deviation is "
        "relative to mu. Every FMU holds metadata after SSP Traceability, a map also the manifest of FMI-LS-STRUCT. SSP: loads from a source FMU, friction, and an FMU that takes mu, written by "
        "`System.export`; OMSimulator asks friction again when new loads have arrived, so mu is that of the loads of the same moment. "
        "An FMU alone in OMSimulator keeps its start values. The ecos command line is a program without Python, in an environment without Python; its results are "
        "printed with six decimals, so that the FMU behind friction gives mu times 1e9.",
        "",
        "The distributions come with the extra `[interop]`. fmusim and OMSimulator are not among them: the runs look for them on PATH, or "
        f"where the variables {' and '.join(f'`{p.variable}`' for p in PROGRAMS.values())} say. Where they "
        "are missing or have another version, the rows of the page before stay, and a line below names them. "
        + " ".join(f"{p.name} {p.wanted}: {p.source}." for p in PROGRAMS.values()),
        "",
        f"Run on: {platform.system()} {platform.machine()}, Python {platform.python_version()}.",
        "",
        *table(_HEADS, rows),
        "",
        "## Binaries for other machines",
        "",
        "A small C host, built for the machine in question, loads the library out of the FMU, plays the same loads and prints mu. "
        "The macOS libraries are built and inspected, but nothing here can run them.",
        "",
        *table(("machine", "run by", "model", "result", "largest deviation of mu"), machines),
        "",
        "## Masters",
        "",
        "A sliding contact and a friction FMU with memory, coupled both ways, fixed step. libcosim and ecos exchange values "
        "like the mode `jacobi`: connected inputs are initialized along the connections, then in every step all FMUs advance with what "
        "the step before gave them. libcosim shows values as they are after the step; ecos after they were passed on, so that an "
        "output that follows its inputs at once already shows the next ones (its `friction::mu` is ahead by one exchange; what the "
        "other FMU receives is the same). fmpy.ssp is a Jacobi master, too, but starts connected inputs at zero.",
        "",
        f"The extrusion has {MARKERS} markers and runs for {INCREMENTS} increments of 0.1 mm, from one SSP whose forming FMU starts the solver as a "
        "process of its own, so that the ecos command line can run it, too.",
        "",
        *table(("compared", "largest relative difference"), masters),
        "",
    ]
    if absent:
        lines += [
            f"Not here, so not run: {'; '.join(sorted(absent))}. Their rows, where there are any, are those of the page before.",
            "",
        ]
    write_text(chosen.out, "\n".join(lines))
    print("\n".join(lines))


if __name__ == "__main__":
    main()
