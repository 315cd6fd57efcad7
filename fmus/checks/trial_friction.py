"""Trial of `check` for friction FMUs: mu against ONNX Runtime, memory, derivatives, the trained domain."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES, MU, FloatArray

from ..runtime.fmu_files import UnpackedFmu
from ..runtime.running import RunningFmu

if TYPE_CHECKING:
    from friction_models.models.onnx_model import OnnxModel

    from .report import Notes

POINTS = 60
#: Points of an FMU whose size can be chosen, besides its default.
SEVERAL = 7
#: Agreement with ONNX Runtime, relative and absolute.
RELATIVE, ABSOLUTE = 1e-9, 1e-12
#: Agreement of directional derivatives with central differences where the law is smooth.
SLOPE = 1e-5


def friction(fmu: UnpackedFmu, notes: Notes) -> None:
    """Run the trials of a friction FMU; nothing happens with another one."""
    if not fmu.is_friction or fmu.raw.coSimulation is None:
        return
    model = packed_model(fmu, notes)
    default = Friction(fmu)
    notes.note("noted", f"{default.width} contact point{'s' if default.width > 1 else ''}{_choice(fmu)}")
    widths = [None] if fmu.sizing(LOAD_NAMES[0]) is None else [None, 1 if default.width > 1 else SEVERAL]
    for width in widths:
        trial = default if width is None else Friction(fmu, width)
        if model is not None:
            _reference(trial, model, notes)
            if model.states:
                _memory(trial, model, notes)
        if trial.bounds:
            _interval(trial, model, notes)
        _derivatives(trial, model, notes)
    if "in_domain" in fmu.variables and model is not None and model.domain is not None:
        _domain(default, model, notes)


def _choice(fmu: UnpackedFmu) -> str:
    sizing = fmu.sizing(LOAD_NAMES[0])
    if sizing is None:
        return ""
    lower, upper = fmu.limits(sizing)
    return f", {sizing} can be set from {max(lower, 1)}{' on' if upper is None else f' to {upper}'}"


class Friction:
    """A friction FMU at a number of contact points, where the length of its arrays can be set."""

    def __init__(self, fmu: UnpackedFmu, points: int | None = None) -> None:
        sizing = fmu.sizing(LOAD_NAMES[0])
        self.points = points
        self.fmu = fmu if points is None or sizing is None else fmu.sized({sizing: points})
        self.width = self.fmu.contact_points()
        self.bounds = [n for n in ("mu_low", "mu_high") if n in fmu.arrays]
        self.label = "" if points is None else f" with {sizing} = {points}"

    def set(self, fmu: RunningFmu, loads: FloatArray) -> None:
        """Set the loads, shape (width, 5)."""
        fmu.set_real(LOAD_NAMES, loads.T)


def random_loads(rng: np.random.Generator, count: int) -> FloatArray:
    """Return loads between slow, cold, light and fast, hot, heavy contact, shape (count, 5).

    Examples
    --------
    >>> loads = random_loads(np.random.default_rng(0), 3)
    >>> loads.shape, bool((loads >= 0.0).all())
    ((3, 5), True)
    """
    lower, upper = [0.0, 20.0, 100.0, 0.0, 0.8], [600.0, 500.0, 3000.0, 80.0, 25.0]
    return rng.uniform(lower, upper, size=(count, 5))


def packed_model(fmu: UnpackedFmu, notes: Notes) -> OnnxModel | None:
    """Return the model in resources/, None with a note where there is none that ONNX Runtime runs.

    Our FMUs are made from it: there it must be, and be one. FMUs of others may carry what they like by that name.
    """
    folder = fmu.folder / "resources"
    packed = folder / "model.onnx"
    # A user's graph without a translation is run in Python as it is.
    as_it_is = (folder / "original.onnx").is_file() and (folder / "interface.json").is_file()
    ours = str(fmu.raw.generationTool).startswith("tribofmu")
    outcome = "failed" if ours else "skipped"
    if not packed.is_file():
        outcome = "skipped" if as_it_is else outcome
        notes.note(outcome, "mu against ONNX Runtime: the FMU carries no resources/model.onnx")
        return None
    from friction_models.models.onnx_model import OnnxModel

    try:
        return OnnxModel(packed)
    except InputError as error:
        reason = str(error).replace(str(packed), "resources/model.onnx")
        notes.note(
            outcome,
            f"mu against ONNX Runtime: {reason}{'; it is not the model that was packed' if ours else ''}",
        )
        return None


def inside(model: OnnxModel, loads: FloatArray) -> FloatArray:
    """Return loads moved into the trained domain of a model, if it has one."""
    return loads if model.domain is None else np.asarray(model.domain.clamp(loads))


def _reference(trial: Friction, model: OnnxModel, notes: Notes) -> None:
    """Compare mu with ONNX Runtime at random points and at the corners of the domain."""
    rng = np.random.default_rng(5)
    count = trial.width * -(-POINTS // trial.width)
    points = random_loads(rng, count)
    if model.domain is not None:
        points[: count // 2] = model.domain.clamp(points[: count // 2])
        points[0], points[-1] = model.domain.lower, model.domain.upper
    expected = model.predict(inside(model, points))
    mu = np.empty(count)
    with RunningFmu(trial.fmu, "reference") as fmu:
        for i in range(0, count, trial.width):
            trial.set(fmu, points[i : i + trial.width])
            mu[i : i + trial.width] = fmu.get_real([MU.name])
    worst = np.abs(mu - expected).max()
    agrees = (np.abs(mu - expected) <= ABSOLUTE + RELATIVE * np.abs(expected)).all()
    notes.add(
        bool(agrees and (mu >= 0.0).all()),
        f"mu against ONNX Runtime at {count} points{trial.label}: largest difference {worst:.1e}",
    )


def _interval(trial: Friction, model: OnnxModel | None, notes: Notes) -> None:
    """Look at the bounds of mu: around it, never negative, and those of ONNX Runtime, which widens them outside."""
    if len(trial.bounds) != 2:
        notes.add(False, "mu_low and mu_high belong together: one of them is missing")
        return
    rng = np.random.default_rng(8)
    worst, around, expected = 0.0, True, None
    with RunningFmu(trial.fmu, "interval") as fmu:
        for k in range(4):
            points = random_loads(rng, trial.width)
            if k % 2 == 0 and model is not None and model.domain is not None:
                points = model.domain.clamp(points)
            trial.set(fmu, points)
            mu, low, high = (fmu.get_real([n]) for n in (MU.name, *trial.bounds))
            around &= bool(((low >= 0.0) & (low <= mu) & (mu <= high) & np.isfinite(high)).all())
            if model is not None and model.has_interval:
                expected = model.margin(points)
                error = np.abs(np.r_[low - np.maximum(mu - expected, 0.0), high - mu - expected])
                worst = max(worst, float((error / (1.0 + np.r_[expected, expected])).max()))
    notes.add(around, f"mu_low and mu_high lie around mu, never below 0{trial.label}")
    if expected is not None:
        notes.add(
            worst <= RELATIVE,
            f"mu_low and mu_high against ONNX Runtime{trial.label}: largest difference {worst:.1e}",
        )


def _memory(trial: Friction, model: OnnxModel, notes: Notes) -> None:
    """Compare a stepped run with memory."""
    rng = np.random.default_rng(6)
    state = model.start_state(trial.width)
    worst = 0.0
    with RunningFmu(trial.fmu, "memory") as fmu:
        for k in range(10):
            points = random_loads(rng, trial.width)
            trial.set(fmu, points)
            fmu.step(0.01 * k, 0.01)
            _, state = model.step(points, state, 0.01)
            expected = model.predict(inside(model, points), state)
            worst = max(worst, float(np.abs(fmu.get_real([MU.name]) - expected).max()))
    notes.add(
        worst <= 1e-9,
        f"memory over 10 steps against ONNX Runtime{trial.label}: largest difference {worst:.1e}",
    )


def _derivatives(trial: Friction, model: OnnxModel | None, notes: Notes) -> None:
    """Compare directional and adjoint derivatives with central differences where mu is smooth."""
    if not trial.fmu.claims("providesDirectionalDerivative"):
        if trial.points is None:
            notes.note("skipped", "directional derivatives: not claimed")
        return
    rng = np.random.default_rng(7)
    compared, worst = 0, 0.0
    with RunningFmu(trial.fmu, "derivatives") as fmu:
        for _ in range(4):
            points = _middle(rng, trial.width, model)
            scale = np.maximum(np.abs(points), 1.0)
            direction = rng.uniform(-1.0, 1.0, size=points.shape) * scale
            coarse, fine = (_slope(trial, fmu, points, direction, h) for h in (2e-5, 1e-5))
            trial.set(fmu, points)
            mu = fmu.get_real([MU.name])
            got = fmu.derivative([MU.name], LOAD_NAMES, direction.T.ravel())
            # Both differences agree: no kink of the law (a tree, a ReLU, the edge of the domain) lies between.
            smooth = np.abs(coarse - fine) <= 1e-5 * np.abs(fine) + 1e-9
            error = np.abs(got - fine) / (np.abs(fine) + 1e-3 * np.abs(mu) + 1e-6)
            compared += int(smooth.sum())
            worst = max(worst, float(error[smooth].max(initial=0.0)))
        notes.add(
            worst <= SLOPE,
            f"directional derivatives against central differences, {compared} of {4 * trial.width} values"
            f"{trial.label}: largest difference {worst:.1e}",
        )
        if trial.fmu.claims("providesAdjointDerivatives"):
            weights = rng.uniform(-1.0, 1.0, size=trial.width)
            adjoint = fmu.adjoint([MU.name], LOAD_NAMES, weights)
            left, right = float(adjoint @ direction.T.ravel()), float(weights @ got)
            notes.add(
                bool(abs(left - right) <= 1e-10 * (np.abs(weights) @ np.abs(got) + 1e-12)),
                f"adjoint derivatives fit the directional ones{trial.label}",
            )


def _middle(rng: np.random.Generator, count: int, model: OnnxModel | None) -> FloatArray:
    """Return points in the middle of the trained domain, or of usual loads, shape (count, 5)."""
    lower, upper = np.array([20.0, 50.0, 600.0, 5.0, 1.5]), np.array([300.0, 250.0, 2000.0, 40.0, 8.0])
    if model is not None and model.domain is not None:
        box = np.array([model.domain.lower, model.domain.upper])
        lower, upper = box[0] + 0.1 * (box[1] - box[0]), box[1] - 0.1 * (box[1] - box[0])
    return np.asarray(rng.uniform(lower, upper, size=(count, 5)))


def _slope(
    trial: Friction, fmu: RunningFmu, points: FloatArray, direction: FloatArray, h: float
) -> FloatArray:
    values = []
    for side in (h, -h):
        trial.set(fmu, points + side * direction)
        values.append(fmu.get_real([MU.name]))
    return (values[0] - values[1]) / (2.0 * h)


def _domain(trial: Friction, model: OnnxModel, notes: Notes) -> None:
    """Look at `in_domain` inside the trained domain and beyond each load that was measured; the others change nothing."""
    assert model.domain is not None
    domain = model.domain
    centre = np.tile(domain.centre, (trial.width, 1))
    expected, seen = [True], []
    with RunningFmu(trial.fmu, "domain") as fmu:
        trial.set(fmu, centre)
        fmu.step(0.0, 0.01)
        seen.append(fmu.get_boolean("in_domain"))
        for k, name in enumerate(LOAD_NAMES):
            points = centre.copy()
            points[-1, k] = domain.upper[k] + max(domain.upper[k] - domain.lower[k], 1.0)
            trial.set(fmu, points)
            fmu.step(0.01 * (k + 1), 0.01)
            seen.append(fmu.get_boolean("in_domain"))
            expected.append(name in domain.absent)
    notes.add(seen == expected, "in_domain is true inside the trained domain and false outside")
