"""The part of `check` that loads the FMU; run as ``python -m fmus.trial FMU RESULT``, so that a crash stays outside."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

from friction_models.loads import LOADS, FloatArray, InputError

from .running import FmuError, RunningFmu, UnpackedFmu

POINTS = 60
#: Agreement with ONNX Runtime, relative and absolute.
RELATIVE, ABSOLUTE = 1e-9, 1e-12


class Trial:
    """Findings are written one by one: what was found before a crash is kept."""

    def __init__(self, path: str, result: str) -> None:
        self.fmu = UnpackedFmu(path)
        self.result = Path(result)

    def add(self, good: bool, text: str) -> None:
        """Write a finding."""
        self.note("passed" if good else "failed", text)

    def note(self, outcome: str, text: str) -> None:
        """Write a finding with its outcome."""
        with self.result.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps([outcome, text]) + "\n")

    def run(self) -> None:
        """Run all trials."""
        description = self.fmu.description
        outputs = [v.name for v in description.modelVariables if v.causality == "output" and v.type == "Real"]
        experiment = description.defaultExperiment
        step = float(experiment.stepSize) if experiment is not None and experiment.stepSize else 0.01
        names = {v.name.partition("[")[0] for v in description.modelVariables}
        friction = (
            self.fmu.friction() if {q.name for q in LOADS} | {"mu"} <= names and self._is_friction() else None
        )
        inputs = [n for q in LOADS for n in friction[q.name]] if friction else []
        nodes = len(friction["mu"]) if friction else 0
        series = self._series(nodes)
        try:
            with RunningFmu(self.fmu, "first") as first:
                self.add(True, "loads and starts in a second process")
                mine = self._play(first, inputs, outputs, series, step)
                with RunningFmu(self.fmu, "second") as second:
                    again = self._play(second, inputs, outputs, series[:3], step)
                    self.add(np.array_equal(mine[:3], again), "a second instance repeats the first exactly")
                self._state(first, inputs, outputs, series, step)
                self._refusal(first)
            if friction:
                self._reference(friction)
        except (FmuError, InputError) as error:
            self.add(False, f"trial run: {error}")

    def _is_friction(self) -> bool:
        return self.fmu.variables[self.fmu.elements("mu")[0]].causality == "output"

    def _series(self, nodes: int) -> FloatArray:
        """Return loads for some steps, shape (steps, 5 * nodes)."""
        rng = np.random.default_rng(2)
        steps = 5
        if not nodes:
            return np.empty((steps, 0))
        rows = [_random(rng, nodes).T.ravel() for _ in range(steps)]
        return np.array(rows)

    def _play(
        self,
        fmu: RunningFmu,
        inputs: list[str],
        outputs: list[str],
        series: FloatArray,
        step: float,
        first: int = 0,
    ) -> FloatArray:
        seen = []
        for k, values in enumerate(series):
            if inputs:
                fmu.set_real(inputs, values)
            fmu.step((first + k) * step, step)
            seen.append(fmu.get_real(outputs))
        return np.array(seen)

    def _state(
        self, fmu: RunningFmu, inputs: list[str], outputs: list[str], series: FloatArray, step: float
    ) -> None:
        flags = self.fmu.description.coSimulation
        if not flags.canGetAndSetFMUstate:
            self.note("skipped", "FMU state: not claimed")
            return
        at = len(series)
        state = fmu.save()
        ahead = self._play(fmu, inputs, outputs, series[:2], step, at)
        fmu.restore(state)
        self.add(
            np.array_equal(ahead, self._play(fmu, inputs, outputs, series[:2], step, at)),
            "FMU state: exact replay",
        )
        if flags.canSerializeFMUstate:
            fmu.restore(fmu.through_bytes(state))
            replay = self._play(fmu, inputs, outputs, series[:2], step, at)
            self.add(np.array_equal(ahead, replay), "FMU state: exact replay after serialization")

    def _refusal(self, fmu: RunningFmu) -> None:
        names = [
            v.name for v in self.fmu.description.modelVariables if v.causality == "input" and v.type == "Real"
        ]
        if not names:
            return
        try:
            fmu.set_real(names[-1:], np.array([np.nan]))
        except FmuError as error:
            self.add(
                names[-1] in str(error), f"NaN is refused with a message that names the variable ({error})"
            )
        else:
            self.add(False, f"NaN as {names[-1]!r} is accepted, allowed: an error")

    def _reference(self, friction: dict[str, list[str]]) -> None:
        """Compare mu with ONNX Runtime on the model in resources/, at random points and at the domain's corners."""
        packed = self.fmu.folder / "resources" / "model.onnx"
        if not packed.is_file():
            self.note("skipped", "reference: the FMU carries no model.onnx")
            return
        from friction_models.onnx_model import OnnxModel

        try:
            model = OnnxModel(packed)
        except InputError as error:
            self.note("skipped", f"reference: {str(error).replace(str(packed), 'model.onnx')}")
            return
        rng = np.random.default_rng(5)
        nodes = len(friction["mu"])
        count = nodes * -(-POINTS // nodes)
        points = _random(rng, count)
        if model.domain is not None:
            points[: count // 2] = model.domain.clamp(points[: count // 2])
            points[0], points[-1] = model.domain.lower, model.domain.upper
        expected = model.predict(points if model.domain is None else model.domain.clamp(points))
        inputs = [n for q in LOADS for n in friction[q.name]]
        mu = np.empty(count)
        with RunningFmu(self.fmu, "reference") as fmu:
            for i in range(0, count, nodes):
                fmu.set_real(inputs, points[i : i + nodes].T.ravel())
                mu[i : i + nodes] = fmu.get_real(friction["mu"])
        difference = np.abs(mu - expected) - RELATIVE * np.abs(expected)
        self.add(
            bool((difference <= ABSOLUTE).all() and (mu >= 0.0).all()),
            f"mu against ONNX Runtime at {count} points: largest difference {np.abs(mu - expected).max():.1e}",
        )
        if model.states:
            self._memory(friction, model)

    def _memory(self, friction: dict[str, list[str]], model: object) -> None:
        """Compare a stepped run with memory."""
        from friction_models.onnx_model import OnnxModel

        assert isinstance(model, OnnxModel)
        nodes, rng = len(friction["mu"]), np.random.default_rng(6)
        inputs = [n for q in LOADS for n in friction[q.name]]
        state = model.start_state(nodes)
        worst = 0.0
        with RunningFmu(self.fmu, "memory") as fmu:
            for k in range(10):
                points = _random(rng, nodes)
                fmu.set_real(inputs, points.T.ravel())
                fmu.step(0.01 * k, 0.01)
                _, state = model.step(points, state, 0.01)
                inside = points if model.domain is None else model.domain.clamp(points)
                expected = model.predict(inside, state)
                worst = max(worst, float(np.abs(fmu.get_real(friction["mu"]) - expected).max()))
        self.add(worst <= 1e-9, f"memory over 10 steps against ONNX Runtime: largest difference {worst:.1e}")


def _random(rng: np.random.Generator, count: int) -> FloatArray:
    """Return loads between slow, cold, light and fast, hot, heavy contact, shape (count, 5)."""
    lower, upper = [0.0, 20.0, 100.0, 0.0, 0.8], [600.0, 500.0, 3000.0, 80.0, 25.0]
    return rng.uniform(lower, upper, size=(count, 5))


if __name__ == "__main__":
    Trial(sys.argv[1], sys.argv[2]).run()
