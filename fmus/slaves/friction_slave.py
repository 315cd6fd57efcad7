"""Friction FMU in Python: ONNX Runtime behind FMI 2.0.

This file is copied into the FMU under a name of its own and needs numpy and onnxruntime only.
Value references run in groups of `nodes`: five loads, mu, domain_distance, states; then the system
variables, and behind all Real variables in_domain and clamp_to_domain. The behaviour is that of the native FMU.
"""

from __future__ import annotations

import contextlib
import ctypes
import functools
import json
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import onnxruntime

try:
    from pythonfmu.fmi2slave import Fmi2Slave
except ModuleNotFoundError:
    sys.path.append(str(Path(__file__).parent / "fallback"))
    from pythonfmu.fmi2slave import Fmi2Slave

# PythonFMU 0.7 runs this file again for every instance and each time gives back a reference to the
# module's dictionary that it does not own; without one more the dictionary is gone after some instances.
ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))

LOADS, SIGMA_N = 5, 2


def guarded(method: Callable[..., Any]) -> Callable[..., Any]:
    """Let an error leave a method without taking the objects behind it along.

    PythonFMU 0.7 gives back a reference to the slave, its class and its messages at every error and
    goes on using them: the next call would crash the simulator. It gets the references here.
    """

    @functools.wraps(method)
    def call(self: Any, *arguments: Any) -> Any:
        try:
            return method(self, *arguments)
        except BaseException:
            for thing in (self, type(self), self.log_queue):
                ctypes.pythonapi.Py_IncRef(ctypes.py_object(thing))
            raise

    return call


class FrictionSlave(Fmi2Slave):
    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        folder = Path(str(self.resources))
        with contextlib.suppress(ValueError):
            sys.path.remove(str(self.resources))  # PythonFMU has put it in front; everything is imported now
        config = json.loads((folder / "interface.json").read_text(encoding="utf-8"))
        #: How loads enter a user's own graph; None for ours.
        self.foreign: dict[str, Any] | None = config.get("foreign")
        model = "model.onnx" if self.foreign is None else "original.onnx"
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        self.session = onnxruntime.InferenceSession(
            (folder / model).read_bytes(), options, providers=["CPUExecutionProvider"]
        )
        self.graph_inputs = [i.name for i in self.session.get_inputs()]
        self.nodes = int(config["nodes"])
        self.names = list(config["names"])
        self.in_domain: int = config["references"]["in_domain"]
        self.clamp_to_domain: int = config["references"]["clamp_to_domain"]
        self.states, self.system = len(config["state_start"]), len(config["system_start"])
        self.lower, self.upper = (np.array(config[k]) for k in ("load_lower", "load_upper"))
        lower, upper = config["domain"]
        self.domain_lower = np.array([-math.inf if v is None else v for v in lower])
        self.domain_upper = np.array([math.inf if v is None else v for v in upper])
        self.scale = np.array(config["domain_scale"])
        n = self.nodes
        self.first_state, self.first_system = 7 * n, (7 + self.states) * n
        self.start = np.concatenate(
            [
                np.repeat(config["load_start"], n),
                np.zeros(2 * n),
                np.repeat(config["state_start"], n),
                np.array(config["system_start"], dtype=float),
            ]
        )
        self.values = self.start.copy()
        self.clamp, self.stale, self.initialized = True, True, False

    # --- evaluation ---

    def loads(self) -> Any:
        return self.values[: LOADS * self.nodes].reshape(LOADS, self.nodes).T

    def run(self, output: str, loads: Any, dt: float) -> Any:
        n, k = self.nodes, self.states
        given = {"loads": loads}
        if "state" in self.graph_inputs:
            held = self.values[self.first_state : self.first_system].reshape(k, n).T
            given["state"] = np.ascontiguousarray(held)
        if "dt" in self.graph_inputs:
            given["dt"] = np.array([dt])
        if "system" in self.graph_inputs:
            given["system"] = self.values[self.first_system :].reshape(1, -1)
        return self.session.run([output], given)[0]

    def run_foreign(self, loads: Any, foreign: dict[str, Any]) -> Any:
        """Run a user's own graph, point by point where its first dimension is not free."""
        batch = all(i["batch"] for i in foreign["inputs"])
        parts = [loads] if batch else [loads[k : k + 1] for k in range(self.nodes)]
        found = []
        for part in parts:
            given = {}
            for i in foreign["inputs"]:
                columns = part[:, i["loads"]] * np.array(i["factor"]) + np.array(i["offset"])
                shape = [len(part), *i["shape"][1:]] if i["batch"] else i["shape"]
                given[i["name"]] = np.ascontiguousarray(columns.reshape(shape).astype(i["kind"]))
            found.append(np.asarray(self.session.run([foreign["output"]], given)[0], dtype=float).reshape(-1))
        return np.concatenate(found) * foreign["multiply"] + foreign["add"]

    def evaluate(self) -> None:
        if not self.stale:
            return
        n, loads = self.nodes, self.loads()
        inside = np.minimum(np.maximum(loads, self.lower), self.upper)
        if self.clamp:
            inside = np.minimum(np.maximum(inside, self.domain_lower), self.domain_upper)
        if self.foreign is None:
            mu = self.run("mu", np.ascontiguousarray(inside), 0.0).reshape(-1)
        else:
            mu = self.run_foreign(inside, self.foreign)
        if not np.isfinite(mu).all():
            bad = int(np.argmin(np.isfinite(mu)))
            raise ValueError(f"{self.names[LOADS * n + bad]} is not a finite number at the given loads")
        self.values[LOADS * n : (LOADS + 1) * n] = np.maximum(mu, 0.0)
        self.stale = False

    def measure_distance(self) -> None:
        n, loads = self.nodes, self.loads()
        outside = np.maximum(self.domain_lower - loads, loads - self.domain_upper)
        self.values[(LOADS + 1) * n : self.first_state] = np.maximum(outside / self.scale, 0.0).max(axis=1)

    # <interval>
    def bounds(self) -> Any:
        """Return the bounds of the prediction interval: all lower ones, then all upper ones."""
        self.evaluate()
        loads = np.ascontiguousarray(np.clip(self.loads(), self.lower, self.upper))
        margin = self.run("mu_margin", loads, 0.0).reshape(-1)
        mu = self.values[LOADS * self.nodes : (LOADS + 1) * self.nodes]
        found = np.concatenate([np.maximum(mu - margin, 0.0), mu + margin])
        if not np.isfinite(found).all():
            bad = len(self.values) + int(np.argmin(np.isfinite(found)))
            raise ValueError(f"{self.names[bad]} is not a finite number at the given loads")
        return found

    # </interval>
    @guarded
    def do_step(self, current_time: float, step_size: float) -> bool:
        if not math.isfinite(step_size) or step_size < 0.0:
            raise ValueError(f"communication step {step_size!r} is negative or not a finite number")
        if step_size > 0.0 and self.states:
            # On the unclamped loads; a point without contact pressure keeps its memory.
            loads = np.ascontiguousarray(np.clip(self.loads(), self.lower, self.upper))
            following = self.run("state_next", loads, step_size)
            kept = self.values[self.first_state : self.first_system].reshape(self.states, self.nodes)
            following = np.where(loads[:, SIGMA_N] > 0.0, following.T, kept)
            if not np.isfinite(following).all():
                bad = self.first_state + int(np.argmin(np.isfinite(following)))
                raise ValueError(f"{self.names[bad]} is not a finite number after the step")
            kept[:] = following
            self.stale = True
        return True

    # --- FMI ---

    def exit_initialization_mode(self) -> None:
        self.initialized = True

    @guarded
    def get_real(self, vrs: list[int]) -> list[float]:
        index = np.array(vrs, dtype=np.int64)
        group = index // self.nodes
        if self.stale and (group == LOADS).any():
            self.evaluate()
        if (group == LOADS + 1).any():
            self.measure_distance()
        # <interval>
        if (index >= len(self.values)).any():
            return np.append(self.values, self.bounds())[index].tolist()
        # </interval>
        return self.values[index].tolist()

    @guarded
    def set_real(self, vrs: list[int], values: list[float]) -> None:
        index, given = np.array(vrs, dtype=np.int64), np.array(values)
        if not np.isfinite(given).all():
            k = int(np.argmin(np.isfinite(given)))
            raise ValueError(f"{self.names[vrs[k]]} = {values[k]} is not a finite number")
        # <interval>
        if (index >= len(self.values)).any():
            raise ValueError("mu_low and mu_high are calculated and cannot be set")
        # </interval>
        n = self.nodes
        if ((index >= LOADS * n) & (index < self.first_state)).any():
            raise ValueError("mu and domain_distance are outputs and cannot be set")
        if self.initialized and ((index >= self.first_state) & (index < self.first_system)).any():
            raise ValueError("setting the memory of a point is not allowed after initialization")
        self.values[index] = given
        self.stale = True

    @guarded
    def get_boolean(self, vrs: list[int]) -> list[bool]:
        if self.in_domain not in vrs:
            return [self.clamp for _ in vrs]
        loads = self.loads()
        outside = ((loads < self.domain_lower) | (loads > self.domain_upper)).any(axis=1)
        inside = not (outside & (loads[:, SIGMA_N] > 0.0)).any()
        return [bool(inside) if vr == self.in_domain else self.clamp for vr in vrs]

    @guarded
    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        for vr, value in zip(vrs, values):
            if vr != self.clamp_to_domain:
                raise ValueError("in_domain is an output and cannot be set")
            self.clamp, self.stale = bool(value), True

    def _get_fmu_state(self) -> dict[str, Any]:
        return {"values": self.values.tolist(), "clamp": self.clamp, "initialized": self.initialized}

    @guarded
    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        self.values[:] = state["values"]
        self.clamp, self.initialized, self.stale = state["clamp"], state["initialized"], True
