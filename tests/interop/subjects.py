"""What all clients run: friction FMUs, a series of loads, FMUs that give loads and take mu, and ONNX Runtime's answers."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from fmus import pack
from friction_models import LinearFriction, PolynomialFriction, effects
from friction_models.loads import LOAD_NAMES, LOADS, FloatArray
from friction_models.onnx_model import OnnxModel
from tests.friction_models.made_up import campaign
from tests.orchestrator.native_fmus import Real, native_fmu

STEP, STEPS = 0.01, 40
#: Points of the FMUs with many.
POINTS = 12
KINDS = ("no memory", "memory")
#: Start, slope and curvature of each load over time; all stay inside what the models were trained on.
_COURSE = {
    "v_rel": (40.0, 300.0, 500.0),
    "T": (60.0, 350.0, -100.0),
    "sigma_n": (800.0, 3000.0, -2000.0),
    "sd": (2.0, 60.0, 100.0),
    "psi": (1.2, 20.0, 40.0),
}
#: Factor on mu in the results of clients that print six decimals.
SCALE = 1e9


def names(quantity: str, points: int) -> list[str]:
    """Return FMI 2.0 names of a quantity."""
    return [quantity] if points == 1 else [f"{quantity}[{k + 1}]" for k in range(points)]


def inputs(points: int) -> list[str]:
    """Return the names of all loads, quantity by quantity."""
    return [name for quantity in LOAD_NAMES for name in names(quantity, points)]


def series(points: int = 1, steps: int = STEPS, first: int = 0) -> FloatArray:
    """Return the loads at the beginning of each step, shape (steps, 5 * points), as `inputs` orders them."""
    t = STEP * np.arange(first, first + steps)
    return np.column_stack([a * f + b * f * t + c * f * t * t for a, b, c, f in _courses(points)])


def _courses(points: int) -> list[tuple[float, float, float, float]]:
    return [(*_COURSE[q], 1.0 / (1.0 + 0.02 * k)) for q in LOAD_NAMES for k in range(points)]


@dataclass
class Subjects:
    """The FMUs, made when they are first asked for.

    Parameters
    ----------
    folder : Path
        Where they are written.
    """

    folder: Path
    _made: dict[str, Path] = field(default_factory=dict)

    @cached_property
    def models(self) -> dict[str, Any]:
        """Friction models without and with memory, trained on made-up tests."""
        points = campaign(tests=8, points=20)
        worn = points.assign(mu=points["mu"] + 0.03 * (1.0 - np.exp(-points["sd"] / 3.0)))
        return {
            "no memory": PolynomialFriction(degree=2).fit_frame(points),
            "memory": (LinearFriction() + effects.WorkExhaustion(W_c=0.4, n=1.0)).fit_frame(worn),
        }

    @cached_property
    def references(self) -> dict[str, OnnxModel]:
        """The models' ONNX graphs in ONNX Runtime."""
        return {
            kind: OnnxModel(model.to_onnx(self.folder / f"{kind.replace(' ', '-')}.onnx"))
            for kind, model in self.models.items()
        }

    def friction(self, kind: str, fmi: str = "2.0", points: int = 1, **options: Any) -> Path:
        """Return a friction FMU; FMI 3.0 ones have arrays of open length."""
        key = f"{kind.replace(' ', '-')}-{fmi}-{points}-{'-'.join(map(str, options.values()))}"
        if key not in self._made:
            nodes = points if fmi == "2.0" else 1
            path = self.folder / key / "friction.fmu"
            path.parent.mkdir(parents=True)
            self._made[key] = pack(self.models[kind], path, nodes=nodes, fmi=fmi, **options)
        return self._made[key]

    def source(self, points: int = 1) -> Path:
        """Return an FMU whose outputs are the series of loads."""
        return self._native("source", points, _source)

    def meter(self, points: int = 1) -> Path:
        """Return an FMU that gives back the mu of the step before, times `SCALE`."""
        return self._native("meter", points, _meter)

    def slider(self) -> Path:
        """Return a sliding contact: mu makes heat, work and sliding distance, which are loads."""
        return self._native("slider", 1, _slider)

    def _native(self, name: str, points: int, make: Any) -> Path:
        key = f"{name}-{points}"
        if key not in self._made:
            folder = self.folder / key
            folder.mkdir()
            self._made[key] = make(folder / f"{name}.fmu", points)
        return self._made[key]

    def expected(self, kind: str, loads: FloatArray, step: float = STEP) -> FloatArray:
        """Return mu after each step by ONNX Runtime, shape (steps, points).

        Parameters
        ----------
        kind : str
            Of the model.
        loads : ndarray, shape (steps, 5 * points)
            What the FMU has in each step.
        step : float
            Length of the steps [s].
        """
        model = self.references[kind]
        points = loads.shape[1] // len(LOADS)
        state = model.start_state(points) if model.states else None
        rows: list[FloatArray] = []
        for row in loads:
            now = row.reshape(len(LOADS), points).T
            inside = now if model.domain is None else model.domain.clamp(now)
            if state is None:
                rows.append(model.predict(inside))
                continue
            if (now[:, 2] > 0.0).any():  # points without contact keep their memory; here all or none
                _, state = model.step(now, state, step)
            rows.append(model.predict(inside, state))
        if state is not None:
            # Without this a client could forget all about memory and nobody would see it.
            fresh = model.predict(inside, model.start_state(points))
            assert (np.abs(rows[-1] - fresh) > 1e-3).all()
        return np.array(rows)

    def start_value(self, kind: str, loads: FloatArray) -> FloatArray:
        """Return mu of one point before the first step, shape (1, 1)."""
        model = self.references[kind]
        assert model.domain is not None
        return np.array([model.predict(model.domain.clamp(loads), model.start_state(1))])

    def exact(self, kind: str, loads: FloatArray) -> FloatArray:
        """Return mu of one point with memory at the ends of steps, in very small parts, as an integrator sees it."""
        model, parts = self.references[kind], 500
        state = model.start_state(1)
        rows = []
        for row in loads:
            for _ in range(parts):
                _, state = model.step(row[None], state, STEP / parts)
            assert model.domain is not None
            rows.append(model.predict(model.domain.clamp(row[None]), state))
        return np.array(rows)

    def slopes(self, kind: str, loads: FloatArray) -> FloatArray:
        """Return d mu / d loads by central differences of ONNX Runtime, shape (steps, 5)."""
        model = self.references[kind]
        columns = []
        for k in range(len(LOADS)):
            h = 1e-4 * np.maximum(np.abs(loads[:, k]), 1.0)
            shift = np.zeros_like(loads)
            shift[:, k] = h
            columns.append((model.predict(loads + shift) - model.predict(loads - shift)) / (2.0 * h))
        return np.column_stack(columns)


def _source(path: Path, points: int) -> Path:
    variables = [Real(n, "output", unit=q.unit) for q in LOADS for n in names(q.name, points)]
    code = [
        f"V({v.symbol}) = {a!r} * {f!r} + {b!r} * {f!r} * t + {c!r} * {f!r} * t * t;"
        for v, (a, b, c, f) in zip(variables, _courses(points))
    ]
    return native_fmu(path, variables, "\n".join(code))


def _meter(path: Path, points: int) -> Path:
    variables = [Real(n, "input", 0.0) for n in names("mu", points)]
    results = [Real(n, "output") for n in names("scaled", points)]
    code = [f"V({r.symbol}) = {SCALE!r} * V({v.symbol});" for v, r in zip(variables, results)]
    return native_fmu(path, [*variables, *results], "\n".join(code))


def _slider(path: Path, _points: int) -> Path:
    units = {q.name: q.unit for q in LOADS}
    variables = [
        Real("mu", "input", 0.03),
        *(Real(name, "output", unit=units[name]) for name in LOAD_NAMES),
        Real("work", "output"),
        Real("heat", "parameter", 0.05),
    ]
    outputs = """
        V(v_rel) = 150.0 - 0.02 * V(work);
        V(T) = 60.0 + V(heat) * V(work);
        V(sigma_n) = 900.0 + 600.0 * t;
        V(psi) = 1.2 + 0.05 * V(sd);
    """
    step = """
        V(work) += 0.01 * V(mu) * V(sigma_n) * V(v_rel) * h;
        V(sd) += V(v_rel) * h;
    """
    return native_fmu(path, variables, outputs, step)
