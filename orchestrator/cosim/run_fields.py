"""Fields (stress, strain, temperature of the workpiece) of a co-simulated run.

FMI has no variables for fields. A forming FMU writes them to files when environment variables of the simulator tell it where.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from fmus.runtime.errors import SimulationError
from forming.results.field_recorder import FIELDS_EVERY, FIELDS_FOLDER, checked_spacing
from forming.results.fields import FieldHistory
from friction_models.common.processes.child_processes import environment

from .master import Master
from .run_folders import Run


@contextmanager
def asked_for_fields(every: float) -> Iterator[Path]:
    """Let forming FMUs that start in this block write their fields, a snapshot `every` mm of stroke; yield the folder."""
    checked_spacing(every, f"fields every {every:g} mm of stroke")
    folder = Path(tempfile.mkdtemp(prefix="tribofmu-fields-"))
    try:
        with environment(**{FIELDS_FOLDER: str(folder), FIELDS_EVERY: repr(float(every))}):
            yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def keep_fields(source: Path, run: Path) -> int:
    """Put the fields found in `source` into ``fields/`` of a run folder, as VTU, too; return how many snapshots."""
    count = 0
    for place in sorted(p for p in source.iterdir() if p.is_dir()):
        history = FieldHistory.load(place)
        if len(history):
            history.write_vtu(run / "fields" / place.name)
            history.save(run / "fields" / place.name / "fields.npz")
            count += len(history)
    return count


def run_with_fields(
    master: Master, out: Path, every: float, progress: Callable[[float], None], csv: bool
) -> tuple[Run, int]:
    """Run a system into a folder and keep its fields; return the run and the number of snapshots.

    `every` is the stroke between two snapshots [mm]. Where the steps of a run that breaks off are kept, its fields are,
    too.
    """
    with asked_for_fields(every) as folder:
        try:
            run = master.run(out, progress=progress, csv=csv)
        except (SimulationError, KeyboardInterrupt):
            if (out / "manifest.json").is_file():
                keep_fields(folder, out)
            raise
        return run, keep_fields(folder, out)


def fields_of(run: Path) -> dict[str, FieldHistory]:
    """Return the fields that a run folder holds, by the name of their folder."""
    return {p.parent.name: FieldHistory.load(p) for p in sorted((run / "fields").glob("*/fields.npz"))}
