"""What every export shares: names, templates, reference values, the documents and the folder."""

from __future__ import annotations

import json
import math
import os
import re
import tempfile
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from friction_models.common import InputError, atomic_folder, unknown_name
from friction_models.common.folders import EXPORT
from friction_models.loads import LOADS, FloatArray

from ..interface.description import c_identifier
from ..interface.friction_source import FrictionSource
from ..interface.quantities import USUAL
from ..pages.documentation import card_json

#: A folder with this file in it was written by an export and may be replaced by one.
MARK = "export.json"
#: The C and Fortran names stay inside Fortran's 63 characters and a fixed-form line.
MAX_NAME = 24
#: Files of an export by their path in its folder.
Files = dict[str, str | bytes]
_T = TypeVar("_T")
_TEMPLATES = Path(__file__).parent / "templates"


def template(name: str, values: Mapping[str, str]) -> str:
    """Return a template with ``@KEY@`` replaced; a key without a value is a mistake in this package."""
    text = (_TEMPLATES / name).read_text(encoding="utf-8")
    return re.sub(r"@([A-Z_0-9]+)@", lambda found: values[found[1]], text)


def checked_options(target: str, options: Mapping[str, _T], allowed: Collection[str]) -> dict[str, _T]:
    """Return the options that are not None, refusing names that the target does not know.

    Examples
    --------
    >>> checked_options("c", {"name": "law"}, ("name",))
    {'name': 'law'}
    >>> checked_options("c", {"nam": "law"}, ("name",))
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: unknown option of the target 'c' 'nam'; allowed: name; did you mean 'name'?
    """
    for name in options:
        if name not in allowed:
            raise unknown_name(f"option of the target {target!r}", name, allowed)
    return {k: v for k, v in options.items() if v is not None}


def c_prefix(source: FrictionSource, name: str | None) -> str:
    """Return the first part of all public C names and of the file names.

    Raises InputError: `name` is not a C identifier of at most 24 characters.

    Examples
    --------
    >>> from fmus.source.reading import read_source
    >>> from friction_models import ConstantFriction
    >>> c_prefix(read_source(ConstantFriction(mu=0.1)), "law_7")
    'law_7_friction'
    """
    if name is None:
        clean = c_identifier(source.name)
        base = (clean if len(clean) <= MAX_NAME else c_identifier(source.family))[:MAX_NAME].rstrip("_")
    elif isinstance(name, str) and re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) and len(name) <= MAX_NAME:
        base = name
    else:
        raise InputError(
            f"name = {name!r}, allowed: at most {MAX_NAME} letters, digits and underscores, a letter first"
        )
    return base if base.endswith("friction") else f"{base}_friction"


def domain_limits(source: FrictionSource) -> tuple[FloatArray, FloatArray]:
    """Return lower and upper loads, shape (5,), of the trained domain; infinite where none is recorded."""
    limits = [source.domain.get(q.name, (-math.inf, math.inf)) for q in LOADS]
    return np.array([a for a, _ in limits]), np.array([b for _, b in limits])


def test_box(source: FrictionSource) -> tuple[FloatArray, FloatArray]:
    """Return the loads between which an export is tried: the domain, or the plan's range without one."""
    limits = [source.domain.get(q.name, USUAL[q.name]) for q in LOADS]
    return np.array([a for a, _ in limits]), np.array([b for _, b in limits])


class Reference:
    """mu as the FMU gives it - limits, domain, never negative - computed by ONNX Runtime.

    Examples
    --------
    >>> from fmus.source.reading import read_source
    >>> from friction_models import ConstantFriction
    >>> Reference(read_source(ConstantFriction(mu=0.1))).mu(np.array([[20.0, 80.0, 600.0, 0.0, 1.0]]))
    array([0.1])
    """

    def __init__(self, source: FrictionSource) -> None:
        from friction_models.models.onnx_model import OnnxModel

        with tempfile.TemporaryDirectory(prefix="tribofmu-") as folder:
            path = Path(folder) / "model.onnx"
            path.write_bytes(source.onnx)
            self.model = OnnxModel(path)
        self.where = source.where
        self.limits = np.array([q.lower for q in LOADS]), np.array([q.upper for q in LOADS])
        self.domain = domain_limits(source)

    def mu(
        self, loads: FloatArray, state: FloatArray | None = None, clamp: bool = True, system: Any = None
    ) -> FloatArray:
        """Return mu, shape (n,), at loads of shape (n, 5)."""
        points = np.clip(loads, *self.limits)
        points = np.clip(points, *self.domain) if clamp else points
        mu = self.model.predict(points, state, system)
        if not np.isfinite(mu).all():
            bad = points[int(np.argmin(np.isfinite(mu)))].tolist()
            raise InputError(f"{self.where}: mu is not a finite number at the loads {bad}, allowed: finite")
        return np.maximum(mu, 0.0)

    def step(self, loads: FloatArray, state: FloatArray, dt: float, system: Any = None) -> FloatArray:
        """Return the states, shape (n, k), after `dt` seconds; a point without contact keeps its own.

        A model without memory has none (k = 0) before and after.
        """
        if not self.model.states:
            return state
        points = np.clip(loads, *self.limits)
        following = self.model.step(points, state, dt, system)[1]
        return np.where(points[:, 2:3] > 0.0, following, state)

    def distance(self, loads: FloatArray) -> FloatArray:
        """Return the domain distance, shape (n,)."""
        lower, upper = self.domain
        scale = np.where(upper > lower, upper - lower, np.maximum(np.abs(upper), 1.0))
        outside = np.maximum(np.maximum(lower - loads, loads - upper), 0.0)
        with np.errstate(invalid="ignore"):
            return np.where(outside > 0.0, outside / scale, 0.0).max(axis=1)


def licence() -> str:
    """Return the licence text of the installed package, for the parts of an export that are not the model."""
    from importlib.metadata import PackageNotFoundError, files

    try:
        for file in files("tribofmu") or []:
            if file.name == "LICENSE":
                return file.read_text()
    except (PackageNotFoundError, OSError):
        pass
    beside = Path(__file__).resolve().parents[2] / "LICENSE"
    return beside.read_text(encoding="utf-8") if beside.is_file() else "MIT License, the tribofmu authors\n"


def rows(entries: Sequence[str]) -> str:
    """Return a list as the texts of an export show it, one entry a line."""
    return "\n".join(f"  {e}" for e in entries) or "  none"


def description(source: FrictionSource) -> dict[str, str]:
    """Return the texts about the model that the templates share."""
    from friction_models.models.model_card import package_version

    loads = []
    for q in LOADS:
        trained = source.domain.get(q.name)
        unknown = "not measured, no influence" if q.name in source.absent else "trained range not recorded"
        shown = f"trained on {trained[0]:g} to {trained[1]:g}" if trained else unknown
        loads.append(f"{q.name:8} {q.unit:5} {q.meaning}; {shown}")
    system = []
    for p in source.system:  # a text variable says what its numbers stand for
        labels = "".join(f"; {i} = {label}" for i, label in enumerate(p.labels))
        system.append(one_line(f"{p.name} [{p.unit}], start {p.start:g}{labels}"))
    return {
        "TITLE": one_line(f"Friction model {source.name} ({source.family}){source.origin}"),
        "SHORT_TITLE": one_line(f"Friction model {source.name}")[: 66 - len(source.origin)] + source.origin,
        "FORMULA": one_line(source.formula or source.name),
        "VERSION": package_version("tribofmu") or "0",
        "LOAD_ROWS": rows(loads),
        "STATE_ROWS": rows([one_line(f"{s.name} [{s.unit}], start {s.start:g}") for s in source.states]),
        "SYSTEM_ROWS": rows(system),
    }


def one_line(text: str) -> str:
    """Return printable ASCII on one line, safe inside a C or Fortran comment.

    Examples
    --------
    >>> one_line("a law */ of two   words")
    'a law * / of two words'
    """
    plain = "".join(c if 32 <= ord(c) < 127 else "?" for c in " ".join(text.split()))
    return plain.replace("*/", "* /").replace("/*", "/ *").replace("\\", "/").replace("??", "? ?")[:400]


def documents(source: FrictionSource) -> Files:
    """Return the files about the model that every export carries."""
    files: Files = {"model.onnx": source.onnx, "LICENSE.txt": licence()}
    if source.original is not None:
        files["original.onnx"] = source.original
    if source.card:
        files["card.json"] = card_json(source.card)
    return files


def write_folder(path: str | os.PathLike[str], target: str, files: Mapping[str, str | bytes]) -> Path:
    """Write an export in one go; see `export` for what is refused."""
    final = Path(path)
    mark = json.dumps({"target": target, "files": sorted(files)}, indent=2) + "\n"
    with atomic_folder(final, EXPORT) as folder:
        for name, content in {**files, MARK: mark}.items():
            place = folder / name
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(content.encode() if isinstance(content, str) else content)
    return final
