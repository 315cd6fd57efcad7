"""An ONNX friction model run by ONNX Runtime."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import numpy.typing as npt

from ..common import InputError, check_readable
from ..common.json_values import JsonObject
from ..expressions.onnx_session import onnx_session
from ..expressions.parameters import first_line
from ..loads import LOAD_NAMES, LOADS, MU, FloatArray, TriboLoads, require_loads
from ..loads.time_steps import rests, time_steps
from .domain import Domain
from .intervals.prediction_interval import MARGIN, as_columns, bounds, check_level, check_only_level
from .variables import as_numbers

if TYPE_CHECKING:  # the trials of an FMU compare arrays with its model
    import pandas as pd

#: Larger files are refused; real models are below a few megabytes.
MAX_ONNX_BYTES = 256 * 1024**2
#: Operators that run without end, grow without bound or give other numbers at every call.
REFUSED_OPERATORS = frozenset(
    {"Bernoulli", "ConstantOfShape", "Expand", "If", "Loop", "Multinomial", "OneHot", "Pad", "RandomNormal"}
    | {"RandomNormalLike", "RandomUniform", "RandomUniformLike", "Range", "Resize", "Scan", "SequenceMap"}
    | {"Tile", "Upsample"}
)
#: Loads of shape (n, 5); and the states, shape (n, k), or system variables, shape (m,): None means their start values.
Loads: TypeAlias = TriboLoads | npt.ArrayLike
Given: TypeAlias = npt.ArrayLike | None


class OnnxModel:
    """Session of ONNX Runtime on one file, one thread.

    Parameters
    ----------
    path : path-like
        A file written by `export`, or any ONNX file with the same inputs and outputs.

    Attributes
    ----------
    metadata : dict
        The ``tribofmu.*`` entries, decoded (without the prefix).
    states, system_variables : list of dict
        Entries of `tribofmu.state` and `tribofmu.system`.
    domain : Domain or None
        Trained domain, where the file holds one.

    Raises
    ------
    InputError
        No such file, too large, not ONNX, external data, or inputs and outputs of another kind.

    Examples
    --------
    >>> import tempfile
    >>> from friction_models import ConstantFriction, OnnxModel
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     model = OnnxModel(ConstantFriction(0.08).to_onnx(Path(folder) / "model.onnx"))
    >>> model.predict([[50, 20, 500, 0, 1], [50, 80, 900, 5, 1.2]]).tolist()
    [0.08, 0.08]
    """

    family = "onnx"

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        content = read_onnx(self.path)
        try:
            self._session = onnx_session(content)
            self._check_signature()
            self.metadata = self._read_metadata()
            self.states: list[JsonObject] = self._entries("state")
            self.system_variables: list[JsonObject] = self._entries("system")
            self.domain = self._read_domain()
            self._try()
        except InputError:
            raise
        except Exception as error:  # ONNX Runtime's error classes are not public
            raise InputError(f"{self.path}: ONNX Runtime refuses the graph ({first_line(error)})") from None

    def _try(self) -> None:
        """Run two points, so that a graph that cannot run is refused here and not in the middle of a simulation."""
        feed = self._feed(np.tile([q.nominal for q in LOADS], (2, 1)), None, None)
        if "dt" in self._session_inputs:
            feed["dt"] = np.full(1, 1e-3)
        names = sorted(self._session_outputs & {"mu", "state_next", "state_der", MARGIN})
        for name, result in zip(names, self._session.run(names, feed)):
            columns = 1 if name in {"mu", MARGIN} else len(self.states)
            if result.shape != (2, columns) or not np.isfinite(result).all():
                raise InputError(
                    f"{self.path}: output {name!r} is {np.ravel(result)[:2]} of shape {result.shape} for two points at "
                    f"nominal loads; allowed: finite numbers of shape (2, {columns})"
                )

    def predict(self, loads: Loads, state: Given = None, system: Given = None) -> FloatArray:
        """Return mu, shape (n,), at loads of shape (n, 5).

        `state` of shape (n, k) is by default its start value, `system` of shape (m,) likewise.
        """
        (mu,) = self._outputs(["mu"], loads, state, system)
        return mu

    def predict_interval(
        self, loads: Loads, state: Given = None, system: Given = None
    ) -> tuple[FloatArray, FloatArray]:
        """Return the lower and upper bound of mu of a new test, each of shape (n,), at the level of the file.

        Raises
        ------
        InputError
            The file holds no prediction interval, or shapes do not fit.
        """
        mu, margin = self._outputs(["mu", MARGIN], loads, state, system)
        return bounds(mu, margin)

    @property
    def card(self) -> JsonObject:
        """The model card in the file; empty without one."""
        card = self.metadata.get("card")
        return card if isinstance(card, dict) else {}

    @property
    def needed_loads(self) -> tuple[str, ...]:
        """The loads without which the model cannot be evaluated: those it was given in training, all where it does not say."""
        identity = self.metadata.get("model")
        if isinstance(identity, dict) and identity.get("family") == "constant":
            return ()
        return LOAD_NAMES if self.domain is None else self.domain.measured

    @property
    def has_interval(self) -> bool:
        """Whether the file holds a prediction interval."""
        return MARGIN in self._session_outputs

    def margin(self, loads: Loads, state: Given = None, system: Given = None) -> FloatArray:
        """Return half the width of the prediction interval before the cut at 0, shape (n,)."""
        (margin,) = self._outputs([MARGIN], loads, state, system)
        return margin

    def _outputs(self, names: list[str], loads: Loads, state: Given, system: Given) -> list[FloatArray]:
        """Return outputs of the graph at one moment, each of shape (n,)."""
        if MARGIN in names and not self.has_interval:
            raise InputError(
                f"{self.path}: no prediction interval; allowed: a model with the output {MARGIN!r}"
            )
        feed = self._feed(loads, state, system)
        if "dt" in self._session_inputs:
            feed["dt"] = np.zeros(1)
        return [values[:, 0] for values in self._session.run(names, feed)]

    def step(
        self, loads: Loads, state: Given, dt: float, system: Given = None
    ) -> tuple[FloatArray, FloatArray]:
        """Return mu, shape (n,), before the step and the states, shape (n, k), after `dt` seconds.

        Raises
        ------
        InputError
            The model has no memory, or shapes do not fit.
        """
        if "state_next" not in self._session_outputs:
            raise InputError(f"{self.path}: the model has no memory; allowed: predict")
        feed = self._feed(loads, state, system) | {"dt": np.array([float(dt)])}
        mu, following = self._session.run(["mu", "state_next"], feed)
        return mu[:, 0], following

    def predict_frame(self, data: pd.DataFrame, tests: pd.DataFrame | None = None) -> pd.Series[float]:
        """Return mu for a table of points: its rows, its index.

        With memory the states run through every test in the order of its time: they advance over the
        time since the previous point (without `t`: over distance by speed), then mu is taken; the first
        point of a test sees the start state. System variables come from the columns of `tests` with their
        names, labels as their numbers; what is not there keeps its start value.
        """
        import pandas as pd

        (mu,) = self._along_tests(TriboLoads.from_frame(data, tests), [MU.name])
        return pd.Series(mu, index=data.index, name=MU.name)

    @property
    def interval_level(self) -> float | None:
        """Level of the prediction interval in the file, None without one."""
        interval = self.card.get("interval")
        level = interval.get("level") if self.has_interval and isinstance(interval, dict) else None
        return None if level is None else check_level(level)

    def predict_interval_frame(
        self, data: pd.DataFrame, tests: pd.DataFrame | None = None, level: float | None = None
    ) -> tuple[pd.Series[float], pd.Series[float]]:
        """Return the bounds of `predict_interval` for a table of points, as `predict_frame` reads it.

        Raises
        ------
        InputError
            The file holds no prediction interval, or another level is asked for.
        """
        check_only_level(str(self.path), "an ONNX file", self.interval_level, level)
        mu, margin = self._along_tests(TriboLoads.from_frame(data, tests), [MU.name, MARGIN])
        return as_columns(*bounds(mu, margin), data.index)

    def _along_tests(self, loads: TriboLoads, outputs: list[str]) -> list[FloatArray]:
        """Return outputs along every test, each of shape (n,)."""
        require_loads(loads, self.needed_loads, str(self.path))
        if not self.states and not self.system_variables:
            return self._outputs(outputs, loads, None, None)
        loads, order = loads.in_order(memory=bool(self.states))
        parts = [part for part in loads.segments() if part.stop > part.start]
        dt = time_steps(loads, [part.start for part in parts])
        pause = rests(loads, dt)
        found, matrix, system = np.empty((len(outputs), len(loads))), loads.as_array(), self._system_of(loads)
        for part in parts:
            own, constant = matrix[part], system[part.start]
            states = self._history(own, dt[part], pause[part], constant)
            found[:, order[part]] = self._outputs(outputs, own, states, constant)
        return list(found)

    def _history(
        self, loads: FloatArray, dt: FloatArray, pause: FloatArray, system: FloatArray
    ) -> FloatArray | None:
        """Return the states at each point of one test, shape (n, k); None without memory.

        Of the time `dt` before a point the contact stood still for `pause`, then it slid.
        """
        if not self.states:
            return None
        states = self.start_state(len(loads))
        feed = {"system": system[None, :]} if self.system_variables else {}
        still = loads * np.array([float(name != "v_rel") for name in LOAD_NAMES])
        for i in range(1, len(loads)):
            held = states[i - 1 : i]
            if pause[i] > 0.0:
                feed |= {"loads": still[i : i + 1], "state": held, "dt": pause[i : i + 1]}
                held = self._session.run(["state_next"], feed)[0]
            feed |= {"loads": loads[i : i + 1], "state": held, "dt": dt[i : i + 1] - pause[i]}
            states[i] = self._session.run(["state_next"], feed)[0][0]
        return states

    def _system_of(self, loads: TriboLoads) -> FloatArray:
        """Return the system variables of every point, shape (n, m)."""
        start = np.array([v["start"] for v in self.system_variables], dtype=np.float64)
        values = np.tile(start, (len(loads), 1))
        for j, variable in enumerate(self.system_variables):
            column = loads.context_column(str(variable.get("name")))
            if column is not None:
                values[:, j] = as_numbers(column, variable.get("labels", ()), start[j])
        return values

    def start_state(self, points: int) -> FloatArray:
        """Return the states of fresh contact points, shape (points, k)."""
        return np.tile(np.array([s["start"] for s in self.states], dtype=np.float64), (points, 1))

    def _feed(self, loads: Loads, state: Given, system: Given) -> dict[str, FloatArray]:
        points = loads if isinstance(loads, TriboLoads) else TriboLoads.from_array(loads)
        require_loads(points, self.needed_loads, str(self.path))
        feed = {"loads": points.as_array()}
        if "state" in self._session_inputs:
            held = self.start_state(len(points)) if state is None else np.asarray(state, dtype=np.float64)
            if held.shape != (len(points), len(self.states)):
                raise InputError(
                    f"{self.path}: state has shape {held.shape}, allowed: {(len(points), len(self.states))}"
                )
            feed["state"] = held
        if "system" in self._session_inputs:
            start = [v["start"] for v in self.system_variables]
            values = np.asarray(start if system is None else system, dtype=np.float64).reshape(1, -1)
            if values.shape[1] != len(start):
                raise InputError(f"{self.path}: {values.shape[1]} system variables, allowed: {len(start)}")
            feed["system"] = values
        return feed

    def _check_signature(self) -> None:
        inputs = {i.name: i for i in self._session.get_inputs()}
        outputs = {o.name: o for o in self._session.get_outputs()}
        self._session_inputs, self._session_outputs = set(inputs), set(outputs)
        unknown = self._session_inputs - {"loads", "state", "dt", "system"}
        loads, mu = inputs.get("loads"), outputs.get("mu")
        fits = (
            loads is not None
            and mu is not None
            and not unknown
            and loads.type == mu.type == "tensor(double)"
            and len(loads.shape) == 2
            and loads.shape[1] == len(LOAD_NAMES)
            and ("state" in inputs) == ("state_next" in outputs) == ("dt" in inputs)
        )
        if not fits:
            shown = ", ".join(f"{i.name} {i.type} {i.shape}" for i in inputs.values())
            raise InputError(
                f"{self.path}: inputs {shown:.200} and outputs {sorted(outputs)!r:.100}; allowed: loads double "
                "[n, 5] (state, dt, system) to mu double [n, 1] (state_next, state_der)"
            )

    def _read_metadata(self) -> JsonObject:
        stored = self._session.get_modelmeta().custom_metadata_map
        decoded = {}
        for key, text in sorted(stored.items()):
            if key.startswith("tribofmu."):
                try:
                    decoded[key.removeprefix("tribofmu.")] = json.loads(text)
                except (ValueError, RecursionError):
                    raise InputError(f"{self.path}: metadata {key!r} is not JSON; allowed: JSON") from None
        return decoded

    def _read_domain(self) -> Domain | None:
        stored = self.metadata.get("domain")
        try:
            return None if stored is None else Domain.from_dict(stored)
        except InputError as error:
            raise InputError(f"{self.path}: metadata {error}") from None

    def _entries(self, kind: str) -> list[JsonObject]:
        entries = self.metadata.get(kind, [])
        good = isinstance(entries, list) and all(
            isinstance(e, dict)
            and isinstance(e.get("start"), (int, float))
            and isinstance(e.get("labels", []), list)
            for e in entries
        )
        if not good or bool(entries) != (kind in self._session_inputs):
            raise InputError(
                f"{self.path}: metadata 'tribofmu.{kind}' does not fit the inputs; allowed: one entry with a "
                f"start value for each column of {kind!r}"
            )
        return entries


def read_onnx(path: Path) -> bytes:
    """Return the bytes of a checked ONNX file.

    Raises InputError: no such file, too large, not valid ONNX, or weights in other files.
    """
    import onnx
    from google.protobuf.message import DecodeError

    check_readable(path, MAX_ONNX_BYTES, "an ONNX file")
    content = path.read_bytes()
    try:
        model = onnx.load_from_string(content)
        external = [t.name for t in model.graph.initializer if t.data_location == onnx.TensorProto.EXTERNAL]
        if external or b"external_data" in content:
            raise InputError(
                f"{path}: weights {', '.join(external)!r:.60} are stored in other files; allowed: one file"
            )
        onnx.checker.check_model(model)
        used = {n.op_type for n in model.graph.node} & REFUSED_OPERATORS
        if used or model.functions:
            what = f"operator {min(used)!r}" if used else "function of its own"
            raise InputError(f"{path}: the graph uses the {what}; allowed: a closed formula of the loads")
    except (DecodeError, onnx.checker.ValidationError, ValueError, TypeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path}: not a valid ONNX file ({first_line(error)})") from None
    return content
