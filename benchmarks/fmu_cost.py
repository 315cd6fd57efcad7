"""Cost of one friction evaluation by target and number of nodes."""

from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path

import numpy as np

from fmus import pack
from fmus.runtime.fmu_files import describe, unpack
from fmus.runtime.instance import Instance
from fmus.runtime.ports import Port
from friction_models import OnnxModel
from friction_models.loads import LOADS

from .common import Section, Table, seconds, section
from .data import models

NODES = (1, 64, 1024)


def measure(folder: Path) -> Section:
    """Time set inputs, step, get mu with preallocated buffers; ONNX Runtime from Python for comparison."""
    table = Table(["model", "target", *(f"{n} node{'s' if n > 1 else ''} [us a node]" for n in NODES)])
    for family, model in models(folder).items():
        for target in ("native", "python"):
            cells = [f"{1e6 * _step(model, target, n) / n:.2f}" for n in NODES]
            table.rows.append((family, target, *cells))
        with tempfile.TemporaryDirectory() as place:
            session = OnnxModel(model.to_onnx(Path(place) / "model.onnx"))
            cells = []
            for n in NODES:
                loads = np.tile([q.nominal for q in LOADS], (n, 1))
                cells.append(f"{1e6 * seconds(partial(session.predict, loads), calls=200) / n:.2f}")
            table.rows.append((family, "ONNX Runtime from Python", *cells))
    return section(
        "Friction FMUs: cost of an evaluation",
        "One co-simulation step of a friction FMU through fmpy with preallocated buffers: set five loads a node, step, get mu. "
        "Median of repeated measurements, divided by the number of nodes.",
        table,
    )


def _step(model: object, target: str, nodes: int) -> float:
    with tempfile.TemporaryDirectory() as place:
        path = pack(model, Path(place) / "friction.fmu", target=target, nodes=nodes)
        description = unpack(describe(path), Path(place) / "unpacked")
        with Instance("friction", description) as instance:
            instance.initialize([], stop_time=1e6)
            inputs = Port([v for q in LOADS for v in description.resolve(q.name)])
            outputs = Port(description.resolve("mu"))
            instance.read(inputs)
            now = 0.0
            # Other loads every time: equal ones need no evaluation.
            loads = [inputs.values * factor for factor in (0.9, 1.1)]

            def once() -> None:
                nonlocal now
                inputs.values[:] = loads[0]
                loads.reverse()
                instance.step(inputs, outputs, now, 1e-3)
                now += 1e-3

            return seconds(once, calls=max(20, 2000 // nodes))
