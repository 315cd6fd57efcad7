"""What all clients run: friction FMUs, a series of loads, FMUs that give loads and take mu, and the models' own answers."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
import zipfile
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import RegularGridInterpolator

from fmus import pack
from friction_models import FrictionModel, LinearFriction, PolynomialFriction, effects
from friction_models.expressions.ops import LoadColumns, NumpyOps
from friction_models.loads import LOAD_NAMES, LOADS, FloatArray, TriboLoads
from tests.friction_models.made_up import campaign
from tests.orchestrator.native_fmus import Real, native_fmu

STEP, STEPS = 0.01, 40
#: Points of the FMUs with many.
POINTS = 12
KINDS = ("no memory", "memory")
#: The model without memory, packed as a map of parameters that can be calibrated.
MAP = "map"
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
    return [(*_COURSE[q], 1.0 + 0.25 * k / points) for q in LOAD_NAMES for k in range(points)]


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
    def models(self) -> dict[str, FrictionModel]:
        """Friction models without and with memory, trained on made-up tests."""
        points = campaign(tests=8, points=20)
        worn = points.assign(mu=points["mu"] + 0.03 * (1.0 - np.exp(-points["sd"] / 3.0)))
        return {
            "no memory": PolynomialFriction(degree=2).fit_frame(points),
            "memory": (LinearFriction() + effects.WorkExhaustion(W_c=0.4, n=1.0)).fit_frame(worn),
        }

    def friction(self, kind: str, fmi: str = "2.0", points: int = 1, **options: Any) -> Path:
        """Return a friction FMU; with FMI 3.0 several points are an array of open length."""
        key = f"{kind.replace(' ', '-')}-{fmi}-{points}-{'-'.join(map(str, options.values()))}"
        if key not in self._made:
            nodes = points if fmi == "2.0" else 1
            options |= {"arrays": fmi == "3.0" and points > 1}
            path = self.folder / key / "friction.fmu"
            path.parent.mkdir(parents=True)
            if kind == MAP:
                self._made[key] = pack(self.models[KINDS[0]], path, target="map")
            else:
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
        """Return mu after each step as the model itself computes it with NumPy, shape (steps, points).

        Neither ONNX nor generated C takes part in this.

        Parameters
        ----------
        kind : str
            Of the model.
        loads : ndarray, shape (steps, 5 * points)
            What the FMU has in each step.
        step : float
            Length of the steps [s].
        """
        if kind == MAP:
            return self._of_the_map(loads)
        model, steps = self.models[kind], len(loads)
        points = loads.shape[1] // len(LOADS)
        by_point = loads.reshape(steps, len(LOADS), points).transpose(2, 0, 1)
        assert (model.domain.clamp(by_point) == by_point).all(), (
            "FMUs clamp to the domain, `predict` does not"
        )
        # `predict` gives the start state to the first point of a test; an FMU first makes a step.
        rows = np.concatenate([by_point[:, :1], by_point], axis=1)
        mu = model.predict(
            TriboLoads(
                *rows.reshape(-1, len(LOADS)).T,
                t=np.tile(step * np.arange(steps + 1), points),
                test_id=np.repeat(np.arange(points).astype(str), steps + 1),
            )
        )
        found = mu.reshape(points, steps + 1)[:, 1:].T
        if model.states:
            # Without this a client could forget all about memory and nobody would see it.
            fresh = model.predict(by_point[:, -1])
            assert (np.abs(found[-1] - fresh) > 1e-3).all()
        return found

    def _of_the_map(self, loads: FloatArray) -> FloatArray:
        """Return mu of the map by SciPy, from the numbers that its model description shows to importers."""
        with zipfile.ZipFile(self.friction(MAP, "3.0")) as archive:
            root = ElementTree.fromstring(archive.read("modelDescription.xml"))
        start = {
            v.attrib["name"]: np.array(v.attrib["start"].split(), dtype=float)
            for v in root.iterfind("ModelVariables/Float64")
            if v.attrib["causality"] == "parameter"
        }
        over = [name for name in LOAD_NAMES if f"{name}_axis" in start]
        axes = [start[f"{name}_axis"] for name in over]
        values = start["mu_map"].reshape([len(axis) for axis in axes])
        at = np.column_stack([loads[:, LOAD_NAMES.index(name)] for name in over])
        at = np.clip(at, [axis[0] for axis in axes], [axis[-1] for axis in axes])
        return np.asarray(RegularGridInterpolator(axes, values)(at))[:, None]

    def at_once(self, kind: str, loads: FloatArray) -> FloatArray:
        """Return mu at the beginning of each step: the loads are new, memory is that of the steps before.

        So masters see it that ask an FMU again when its inputs have changed; shape (steps, points).
        """
        model, steps = self.models[kind], len(loads)
        points = loads.shape[1] // len(LOADS)
        rows = np.repeat(loads.reshape(steps, len(LOADS), points).transpose(2, 0, 1), 2, axis=1)
        times = np.repeat(STEP * np.arange(steps + 1), 2)[1:-1]  # no time passes before every second row
        test_id = np.repeat(np.arange(points).astype(str), 2 * steps)
        mu = model.predict(
            TriboLoads(*rows.reshape(-1, len(LOADS)).T, t=np.tile(times, points), test_id=test_id)
        )
        return np.asarray(mu.reshape(points, 2 * steps)[:, ::2].T)

    def integrated(self, kind: str, loads: FloatArray, rows: int) -> FloatArray:
        """Return mu of the model with memory under constant loads, from fresh contact on, shape (rows, points).

        The friction work obeys dW/dt = mu(W) sigma_n v_rel; the law of mu is the model's, the integrator SciPy's.

        Parameters
        ----------
        kind : str
        loads : ndarray, shape (5 * points,)
        rows : int
            A row a step, the first one at the start.
        """
        model, x = self.models[kind], NumpyOps()
        columns = LoadColumns(*(column[:, None] for column in loads.reshape(len(LOADS), -1)))

        def mu(work: FloatArray) -> FloatArray:
            return np.asarray(x.relu(model.formula(x, columns, [work[:, None]])))[:, 0]

        power = 1e-3 * columns.sigma_n[:, 0] * columns.v_rel[:, 0]  # J/mm2 a second for mu = 1
        times = STEP * np.arange(rows)
        found = solve_ivp(
            lambda _t, work: power * mu(work),
            (0.0, times[-1]),
            np.zeros(len(power)),
            "DOP853",
            times,
            rtol=1e-11,
            atol=1e-13,
        )
        return np.array([mu(work) for work in found.y.T])

    def slopes(self, kind: str, loads: FloatArray) -> FloatArray:
        """Return d mu / d loads of a model without memory by central differences, shape (steps, 5)."""
        predict = (lambda at: self._of_the_map(at)[:, 0]) if kind == MAP else self.models[kind].predict
        columns = []
        for k in range(len(LOADS)):
            h = 1e-4 * np.maximum(np.abs(loads[:, k]), 1.0)
            shift = np.zeros_like(loads)
            shift[:, k] = h
            columns.append((predict(loads + shift) - predict(loads - shift)) / (2.0 * h))
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
