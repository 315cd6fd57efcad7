"""Reference results inside an FMU: inputs and the outputs of ONNX Runtime, in the layout of the layered standard FMI-LS-REF.

Written in the form of version 1.0.0-alpha.1 (manifest with related files, one of them the experiment). Its own
directory in the archive holds the manifest, ``experiments.xml``, ``stimuli.csv`` and ``references.csv``.
"""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Sequence
from typing import Any

import numpy as np
from lxml import etree

from friction_models.common import InputError, shown
from friction_models.expressions.onnx_session import onnx_session
from friction_models.loads import LOADS, FloatArray
from friction_models.models.intervals.prediction_interval import MARGIN

from ..archive.content import xml_bytes
from ..interface.description import number
from ..interface.friction_source import FrictionSource
from ..interface.ls_struct import manifest_root
from ..interface.quantities import USUAL, FrictionInterface

#: Directory of the layered standard in the archive.
FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
VERSION = "1.0.0-alpha.1"
_MANIFEST_TEXT = "Layered Standard providing information on related files included in an FMU."

#: Communication points and their distance [s].
ROWS, STEP = 11, 0.1
#: Most points with stimuli: FMI 2.0 leaves the others at their start values, FMI 3.0 gets no results beyond it.
MAX_POINTS = 16
#: Digits written: those on which processors with different vector units agree.
DIGITS = 12
_PROCEDURE = (
    "At the time of each row the inputs of that row are set, then the outputs are read, then a communication step "
    "to the time of the next row is made with the inputs held. Parameters keep their start values."
)


def reference_files(source: FrictionSource, interface: FrictionInterface, fmi: str) -> dict[str, bytes]:
    """Return the files of the layered standard by their path in the archive.

    Empty for an FMI 3.0 FMU with more than `MAX_POINTS` points by default, and where a result is
    not a finite number. Values have `DIGITS` significant digits.
    Raises InputError: see `tried`.
    """
    points = min(interface.nodes, MAX_POINTS)
    if fmi == "3.0" and interface.nodes > MAX_POINTS:
        return {}
    time = np.array([float(f"{STEP * k:.6g}") for k in range(ROWS)])
    loads = stimuli(interface, points)
    results = tried(source, interface, loads)
    if not all(np.isfinite(values).all() for values in results.values()):
        return {}

    def columns(name: str) -> list[str]:
        if fmi == "3.0":
            return [name] * points
        return interface.names(name)[:points]

    inputs = {q.name: loads[:, :, j] for j, q in enumerate(LOADS)}
    texts = {
        "stimuli.csv": _csv(time, [(columns(n), v) for n, v in inputs.items()]),
        "references.csv": _csv(
            time,
            [
                (columns(n) if v.shape[1] == points and n != "in_domain" else [n], v)
                for n, v in results.items()
            ],
        ),
        "experiments.xml": _experiments(time),
    }
    texts["fmi-ls-manifest.xml"] = _manifest(texts)
    return {f"{FOLDER}/{n}": t for n, t in texts.items()} | {
        "documentation/fmi-ls-ref.txt": (
            f"Reference results in {FOLDER}.\n\n{_PROCEDURE}\n\n"
            "The references come from ONNX Runtime and resources/model.onnx; loads outside the trained domain are\n"
            "moved to its border before mu is evaluated, a point without contact keeps its memory. Expected agreement:\n"
            f"1e-9 relative and 1e-12 absolute ({DIGITS} digits are written). in_domain is written as 0 or 1.\n"
        ).encode()
    }


def tried(source: FrictionSource, interface: FrictionInterface, loads: FloatArray) -> dict[str, FloatArray]:
    """Return the values of `reference_run`.

    Raises InputError: ONNX Runtime refuses the graph, or mu is nowhere a finite number.
    """
    try:
        results = reference_run(source, interface, loads)
    except Exception as error:  # ONNX Runtime has errors of its own, which are no one family
        raise InputError(f"{source.where}: ONNX Runtime cannot run the graph ({shown(error, 200)})") from None
    if not np.isfinite(results["mu"]).any():
        raise InputError(
            f"{source.where}: mu is nowhere a finite number at random loads; allowed: finite numbers"
        )
    return results


def stimuli(interface: FrictionInterface, points: int) -> FloatArray:
    """Return loads of shape (`ROWS`, points, 5): inside the domain, one row outside of it, one without contact."""
    box = np.array([interface.domain.get(q.name, USUAL[q.name]) for q in LOADS])
    lower, upper = box[:, 0], box[:, 1]
    rng = np.random.default_rng(1)
    loads = rng.uniform(lower, upper, size=(ROWS, points, len(LOADS)))
    loads[3, :, 1] = upper[1] + 0.5 * (upper[1] - lower[1])
    loads[6, :, 2] = 0.0
    loads = np.clip(loads, [q.lower for q in LOADS], [q.upper for q in LOADS])
    return np.vectorize(lambda x: float(f"{x:.6g}"), otypes=[float])(loads)


def reference_run(
    source: FrictionSource, interface: FrictionInterface, loads: FloatArray, step: float = STEP
) -> dict[str, FloatArray]:
    """Play loads of shape (rows, points, 5), `step` seconds apart, through ONNX Runtime with the rules of the FMU.

    Return `mu` (its bounds, where the FMU has them), `domain_distance` and the states of shape (rows, points), `in_domain` of
    shape (rows, 1).
    """
    session = _session(source.onnx)
    inputs, outputs = [i.name for i in session.get_inputs()], [o.name for o in session.get_outputs()]
    loads_name = "loads" if "loads" in inputs else inputs[0]
    mu_name = "mu" if "mu" in outputs else outputs[0]
    limits = np.array([(q.lower, q.upper) for q in LOADS]).T
    box = np.array([interface.domain.get(q.name, (-np.inf, np.inf)) for q in LOADS]).T
    scale = [b - a if b > a else max(abs(b), 1.0) for a, b in box.T]
    points = loads.shape[1]
    state = np.tile([s.start for s in interface.states], (points, 1))
    fixed: dict[str, FloatArray] = {}
    if "system" in inputs:
        fixed["system"] = np.array([[p.start for p in interface.system]])

    def run(name: str, row: FloatArray, step: float) -> FloatArray:
        feed = {loads_name: row} | fixed
        if "state" in inputs:
            feed["state"] = state
        if "dt" in inputs:
            feed["dt"] = np.array([step])
        return np.asarray(session.run([name], feed)[0], dtype=float)

    bounds = [] if interface.interval is None else ["mu_low", "mu_high"]
    found: dict[str, list[FloatArray]] = {
        n: [] for n in ("mu", *bounds, "domain_distance", *(s.name for s in interface.states), "in_domain")
    }
    for k, raw in enumerate(loads):
        row = np.clip(raw, *limits)
        found["mu"].append(np.maximum(run(mu_name, np.clip(row, *box), 0.0)[:, 0], 0.0))
        if bounds:
            margin = run(MARGIN, row, 0.0)[:, 0]
            found["mu_low"].append(np.maximum(found["mu"][-1] - margin, 0.0))
            found["mu_high"].append(found["mu"][-1] + margin)
        distance = (np.maximum(np.maximum(box[0] - raw, raw - box[1]), 0.0) / scale).max(axis=1)
        found["domain_distance"].append(distance)
        for j, s in enumerate(interface.states):
            found[s.name].append(state[:, j])
        found["in_domain"].append(np.array([float(not ((distance > 0.0) & (raw[:, 2] > 0.0)).any())]))
        if interface.states and k < len(loads) - 1:
            following = run("state_next", row, float(f"{step:.6g}"))
            state = np.where(row[:, 2:3] > 0.0, following, state)
    return {n: np.array(v) for n, v in found.items()}


@functools.lru_cache(maxsize=1)  # the curves of the documentation ask for the same model
def _session(onnx: bytes) -> Any:
    return onnx_session(onnx)


def _csv(time: FloatArray, groups: Sequence[tuple[list[str], FloatArray]]) -> bytes:
    names = ["time", *(n for group, _ in groups for n in group)]
    table = np.column_stack([time, *(v for _, v in groups)])
    lines = [",".join(f'"{n}"' for n in names)]
    lines += [",".join(f"{x:.{DIGITS}g}" for x in row + 0.0) for row in table]  # + 0.0: no negative zero
    return ("\n".join(lines) + "\n").encode()


def _experiments(time: FloatArray) -> bytes:
    root = etree.Element(
        "Experiments",
        name="smoke tests",
        description="Shows that the FMU computes in another environment what its model computes.",
    )
    experiment = etree.SubElement(
        root,
        "Experiment",
        name="loads in steps",
        description=_PROCEDURE,
        startTime=number(time[0]),
        stopTime=number(time[-1]),
        stepSize=number(STEP),
    )
    etree.SubElement(experiment, "Stimuli", source="stimuli.csv")
    etree.SubElement(experiment, "References", source="references.csv")
    return xml_bytes(root)


def _manifest(files: dict[str, bytes]) -> bytes:
    root = manifest_root("fmiReferences", "org.fmi-standard.fmi-ls-ref", VERSION, _MANIFEST_TEXT)
    for name, kind, role, text in (
        ("experiments.xml", "text/xml", "experiment/smoke-test", "the experiment"),
        ("stimuli.csv", "text/csv", "other", "its inputs"),
        ("references.csv", "text/csv", "result", "its outputs by ONNX Runtime"),
        ("../../resources/model.onnx", "application/onnx", "model", "the model as an ONNX graph"),
        ("../../documentation/index.html", "text/html", "document", "model card"),
    ):
        related = etree.SubElement(root, "Related", type=kind, source=name, role=role, description=text)
        if name in files:
            related.set("checksum", hashlib.sha3_256(files[name]).hexdigest())
    return xml_bytes(root)
