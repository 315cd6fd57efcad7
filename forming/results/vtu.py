"""Fields for ParaView: VTU files of workpiece, contact and tools, and the PVD collection over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from friction_models.common import atomic_folder
from friction_models.common.folders import FIELDS

from .snapshot import CONTACT_FIELDS, ELEMENT_FIELDS, Floats, Snapshot


def write_collection(snapshots: Sequence[Snapshot], folder: Path) -> Path:
    """Write ``fields.pvd`` and its VTU files into `folder`, which is replaced; return the collection's path.

    Each time [s] has three parts: 0 the workpiece (T, velocity at the nodes, strain, stresses in the
    elements), 1 its surface (contact), 2 the tools. x is r and y is z [mm]; names carry their units.
    """
    lines = [
        '<?xml version="1.0"?>',
        '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">',
        "  <Collection>",
    ]
    with atomic_folder(folder, FIELDS) as place:
        for k, s in enumerate(snapshots):
            for part, (kind, mesh) in enumerate(
                [("workpiece", _workpiece(s)), ("contact", _contact(s)), ("tools", _tools(s))]
            ):
                name = f"{kind}_{k:04d}.vtu"
                mesh.write(place / name, file_format="vtu", binary=True, compression="zlib")
                lines.append(
                    f'    <DataSet timestep="{s.time:.9g}" group="" part="{part}" name={quoteattr(kind)} '
                    f"file={quoteattr(name)}/>"
                )
        lines += ["  </Collection>", "</VTKFile>", ""]
        (place / "fields.pvd").write_text("\n".join(lines), encoding="utf-8")
    return folder / "fields.pvd"


def _label(name: str, unit: str) -> str:
    return name if unit == "1" else f"{name} [{unit}]"


def _points(x: Floats) -> Floats:
    return np.column_stack([x, np.zeros(len(x), dtype=x.dtype)])


def _workpiece(s: Snapshot) -> Any:
    import meshio

    elements = {_label(f.name, f.unit): [s.elements[:, j].copy()] for j, f in enumerate(ELEMENT_FIELDS)}
    elements["stroke [mm]"] = [np.full(len(s.quads), s.stroke, dtype=np.float32)]
    return meshio.Mesh(
        _points(s.x),
        [("quad", s.quads)],
        point_data={"T [degC]": s.T, "velocity [mm/s]": _points(s.velocity)},
        cell_data=elements,
    )


def _contact(s: Snapshot) -> Any:
    import meshio

    n = len(s.chain)
    lines = np.column_stack([np.arange(n - 1), np.arange(1, n)]).astype(np.int32)
    values = {_label(f.name, f.unit): s.contact[:, j].copy() for j, f in enumerate(CONTACT_FIELDS)}
    return meshio.Mesh(_points(s.x[s.chain]), [("line", lines)], point_data=values)


def _tools(s: Snapshot) -> Any:
    import meshio

    points, lines, numbers, start = [], [], [], 0
    for number, chain in enumerate(s.tools.values(), 1):
        index = np.arange(start, start + len(chain) - 1)
        points.append(chain)
        lines.append(np.column_stack([index, index + 1]))
        numbers.append(np.full(len(index), number, dtype=np.int32))
        start += len(chain)
    if not points:
        return meshio.Mesh(np.zeros((2, 3)), [("line", np.array([[0, 1]], dtype=np.int32))])
    return meshio.Mesh(
        _points(np.concatenate(points)),
        [("line", np.concatenate(lines).astype(np.int32))],
        cell_data={"tool": [np.concatenate(numbers)]},
    )
