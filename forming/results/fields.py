"""The snapshots of a forming run: ranges over all of them, files for Python and for ParaView."""

from __future__ import annotations

import math
import os
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError, atomic_path, unknown_name
from friction_models.common.files import DAMAGED

from ..fe.mesh.shape import FloatArray
from .snapshot import ARRAYS, FIELDS, Snapshot, checked
from .vtu import write_collection

#: Most snapshots of one run.
MOST = 1000
#: Largest file of snapshots that is read, unpacked [bytes].
_LARGEST = 2_000_000_000


@dataclass(frozen=True)
class FieldHistory:
    """The snapshots of a run, in order of their strokes.

    >>> from friction_models import InputError
    >>> empty = FieldHistory(())
    >>> len(empty)
    0
    >>> try:
    ...     empty.at(5.0)
    ... except InputError as error:
    ...     print(error)
    forming: no snapshots were kept; run with snapshots=20, for example
    """

    snapshots: tuple[Snapshot, ...]

    def __len__(self) -> int:
        return len(self.snapshots)

    @property
    def strokes(self) -> FloatArray:
        """Strokes of the snapshots [mm]."""
        return np.array([s.stroke for s in self.snapshots])

    def at(self, stroke: float | None = None) -> Snapshot:
        """Return the snapshot nearest to `stroke` [mm], the last one for None.

        Raises InputError: there is none at all, or `stroke` is not a number.
        """
        if not self.snapshots:
            raise InputError("forming: no snapshots were kept; run with snapshots=20, for example")
        if stroke is None:
            return self.snapshots[-1]
        if not math.isfinite(stroke):
            raise InputError(f"forming: stroke = {stroke!r} mm; allowed: a finite number")
        return self.snapshots[int(np.abs(self.strokes - stroke).argmin())]

    def extremes(self, name: str, share: float = 0.0) -> tuple[float, float]:
        """Return the range of a field over all snapshots without that share of the nodes at either end.

        A signed field gets a range symmetric about 0.
        """
        if name not in FIELDS:
            raise unknown_name("field", name, FIELDS, "forming")
        values = np.concatenate([s.nodal(name) for s in self.snapshots])
        low, high = (float(v) for v in np.quantile(values, [share, 1.0 - share]))
        if FIELDS[name].signed:
            high = max(abs(low), abs(high))
            low = -high
        if high - low < 1e-9 * max(abs(high), 1.0):
            high = low + max(1e-6, 1e-3 * abs(low))
        return low, high

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write all snapshots into one compressed file (NumPy .npz), read back by `load`; return its path."""
        arrays: dict[str, npt.NDArray[Any]] = {
            "strokes": self.strokes,
            "times": np.array([s.time for s in self.snapshots]),
            "tools": np.array(sorted({name for s in self.snapshots for name in s.tools}), dtype=np.str_),
        }
        for k, s in enumerate(self.snapshots):
            arrays |= {f"{k}.{name}": getattr(s, name) for name in ARRAYS}
            arrays |= {f"{k}.tool.{name}": chain for name, chain in s.tools.items()}
        with atomic_path(path) as place, place.open("wb") as stream:
            np.savez_compressed(stream, **arrays)  # type: ignore[arg-type]
        return Path(path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> FieldHistory:
        """Read what `save` wrote, or all snapshots ``0000.npz``, ``0001.npz`` ... of a folder.

        Raises InputError: not such a file, or a damaged one.
        """
        if os.path.isdir(path):
            files = sorted(Path(path).glob("[0-9][0-9][0-9][0-9].npz"))[:MOST]
            return cls(tuple(s for file in files for s in cls.load(file).snapshots))
        try:
            with zipfile.ZipFile(path) as archive:
                if sum(member.file_size for member in archive.infolist()) > _LARGEST:
                    raise ValueError(f"more than {_LARGEST} bytes unpacked")
            with np.load(path, allow_pickle=False) as data:
                strokes, times = data["strokes"], data["times"]
                tools = [str(name) for name in data["tools"]]
                if len(strokes) > MOST or len(strokes) != len(times):
                    raise ValueError(f"{len(strokes)} snapshots")
                found = []
                for k in range(len(strokes)):
                    arrays: dict[str, npt.NDArray[Any]] = {
                        name: np.asarray(data[f"{k}.{name}"], dtype=kind) for name, kind in ARRAYS.items()
                    }
                    chains = {n: data[f"{k}.tool.{n}"] for n in tools if f"{k}.tool.{n}" in data}
                    found.append(
                        checked(Snapshot(float(strokes[k]), float(times[k]), tools=chains, **arrays))
                    )
        except (KeyError, *DAMAGED) as error:
            raise InputError(
                f"{path}: the fields cannot be read ({' '.join(str(error).split())[:200]})"
            ) from None
        except Exception as error:  # zipfile and zlib have exceptions of their own
            raise InputError(f"{path}: not a file of fields ({type(error).__name__})") from None
        return cls(tuple(found))

    def write_vtu(self, folder: str | os.PathLike[str]) -> Path:
        """Write VTU files and the collection ``fields.pvd`` for ParaView; return the path of the collection."""
        return write_collection(self.snapshots, Path(folder))
