"""Fields (stress, strain, temperature of the workpiece) of a co-simulated run.

FMI has no variables for fields. A forming FMU writes them to files when environment variables of the simulator tell it where.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from forming.results.field_recorder import FIELDS_EVERY, FIELDS_FOLDER, checked_spacing
from forming.results.fields import FieldHistory


@contextmanager
def asked_for_fields(every: float) -> Iterator[Path]:
    """Let forming FMUs that start in this block write their fields; yield the folder.

    Parameters
    ----------
    every : float
        Stroke between two snapshots [mm].

    Raises
    ------
    InputError
        Not between 0.01 and 100 mm.
    """
    checked_spacing(every, f"fields every {every:g} mm of stroke")
    before = {name: os.environ.get(name) for name in (FIELDS_FOLDER, FIELDS_EVERY)}
    folder = Path(tempfile.mkdtemp(prefix="tribofmu-fields-"))
    os.environ[FIELDS_FOLDER], os.environ[FIELDS_EVERY] = str(folder), repr(float(every))
    try:
        yield folder
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
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


def fields_of(run: Path) -> dict[str, FieldHistory]:
    """Return the fields that a run folder holds, by the name of their folder."""
    return {p.parent.name: FieldHistory.load(p) for p in sorted((run / "fields").glob("*/fields.npz"))}
