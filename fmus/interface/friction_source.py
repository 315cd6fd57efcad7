"""What is packed: a friction model as float64 ONNX bytes, with the metadata that an FMU shows."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import Any

from friction_models.common import InputError, unknown_name
from friction_models.loads import LOAD_NAMES, LOADS, FloatArray, TriboLoads
from friction_models.models.domain import Domain
from friction_models.models.intervals.prediction_interval import MARGIN, check_level
from friction_models.models.model_card import trained_on_synthetic
from friction_models.models.variables import as_numbers

from .quantities import FrictionInterface, Parameter, State

#: Largest ONNX file that is read.
MAX_ONNX_BYTES = 64 * 1024**2


@dataclass(frozen=True)
class FrictionSource:
    """A friction model ready to be packed.

    Examples
    --------
    >>> source = FrictionSource(b"", "law.onnx", domain={"T": (20.0, 200.0)}, card={}, interval=0.9)
    >>> source.interface(nodes=2, interval=True).names("mu")
    ['mu[1]', 'mu[2]']
    >>> source.box.lower[LOAD_NAMES.index("T")], source.synthetic
    (20.0, False)
    """

    onnx: bytes  #: The serialized model.
    where: str  #: File or class it came from, for messages.
    family: str = "onnx"  #: From the model's metadata, as name and formula; ``"onnx"`` without them.
    name: str = "friction"
    formula: str = ""
    #: Load name to (lower, upper); empty when none is recorded.
    domain: dict[str, tuple[float, float]] = field(default_factory=dict)
    states: tuple[State, ...] = ()  #: Memory.
    system: tuple[Parameter, ...] = ()
    card: dict[str, object] = field(default_factory=dict)  #: The model card, empty when none is recorded.
    original: bytes | None = None  #: The user's file that `onnx` was redrawn from; None for our own models.
    #: How the loads enter `original`, for a graph that runs in Python only (`onnx` is then empty).
    foreign: dict[str, object] | None = None
    #: What packing should tell the user (how far the redrawn graph is from the original); or empty.
    note: str = ""
    interval: float | None = None  #: Level of the prediction interval, None for a model without one.
    #: Loads that were not measured in training: inputs of the FMU without influence.
    absent: tuple[str, ...] = ()

    def interface(self, nodes: int, interval: bool = False, arrays: bool = False) -> FrictionInterface:
        """Return what an FMU of this model shows at `nodes` contact points, with the bounds of `interval` or without.

        Raises InputError: the bounds are wanted, and the model has no prediction interval.
        """
        if interval and self.interval is None:
            raise InputError(
                f"{self.where}: the model has no prediction interval; allowed: a model that was trained with one"
            )
        level = self.interval if interval else None
        return FrictionInterface(
            nodes, dict(self.domain), self.states, self.system, level, arrays, self.absent
        )

    @property
    def synthetic(self) -> bool:
        """Whether the card says that the model was trained on synthetic data."""
        return trained_on_synthetic(self.card)

    @property
    def origin(self) -> str:
        """What a title or description adds on the training data: nothing, or that they are synthetic."""
        return ", trained on synthetic data" if self.synthetic else ""

    @property
    def box(self) -> Domain:
        """The trained domain; the physical limits where none is recorded."""
        limits = [self.domain.get(q.name, (q.lower, q.upper)) for q in LOADS]
        return Domain(tuple(low for low, _ in limits), tuple(high for _, high in limits), self.absent)

    def system_values(self, loads: TriboLoads) -> dict[str, FloatArray]:
        """Return the system variables that the table of tests gives, shape (n,) each; labels as numbers."""
        found = {}
        for p in self.system:
            column = loads.context_column(p.name)
            if column is not None:
                found[p.name] = as_numbers(column, p.labels, p.start)
        return found


def parse_source(content: bytes, where: str) -> FrictionSource:
    """Read the metadata of a serialized ONNX model; see `read_source`.

    Examples
    --------
    >>> parse_source(b"no model", "law.onnx")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: law.onnx: not an ONNX file (it cannot be parsed)
    """
    import onnx

    try:
        model = onnx.load_model_from_string(content)
    except Exception:
        raise InputError(f"{where}: not an ONNX file (it cannot be parsed)") from None
    if not model.graph.output:
        raise InputError(f"{where}: not an ONNX model (its graph has no output)")
    for tensor in model.graph.initializer:
        if tensor.data_location == onnx.TensorProto.EXTERNAL:
            raise InputError(
                f"{where}: tensor {tensor.name!r} is stored in another file; allowed: one self-contained file"
            )
    texts = {p.key: p.value for p in model.metadata_props}

    def part(key: str, empty: Any) -> Any:
        if f"tribofmu.{key}" not in texts:
            return empty
        try:
            value = json.loads(texts[f"tribofmu.{key}"])
        except (ValueError, RecursionError):
            value = None
        if not isinstance(value, type(empty)):
            raise InputError(f"{where}: metadata tribofmu.{key} is not a JSON {type(empty).__name__}")
        return value

    identity = part("model", {})
    try:
        # None stands for a load that was not measured: it has no domain.
        limits = {str(k): v for k, v in part("domain", {}).items()}
        domain = {k: (float(v[0]), float(v[1])) for k, v in limits.items() if v is not None}
        states = tuple(
            State(str(s["name"]), str(s.get("unit", "1")), float(s.get("start", 0.0)))
            for s in part("state", [])
        )
        system = tuple(
            Parameter(
                str(s["name"]),
                str(s.get("unit", "1")),
                float(s.get("start", 0.0)),
                None if s.get("min") is None else float(s["min"]),
                None if s.get("max") is None else float(s["max"]),
                _texts(s.get("labels", [])),
                str(s.get("meaning", "")),
            )
            for s in part("system", [])
        )
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise InputError(f"{where}: metadata of the model cannot be used ({error!r})") from None
    for load in limits:
        if load not in LOAD_NAMES:
            raise unknown_name("load in the domain", load, LOAD_NAMES, where)
    for load, (lower, upper) in domain.items():
        if not lower <= upper:
            raise InputError(
                f"{where}: domain of {load!r} is {lower!r} to {upper!r}, allowed: lower <= upper"
            )
    return FrictionSource(
        onnx=content,
        where=where,
        family=str(identity.get("family", "onnx")),
        name=str(identity.get("name", "friction")),
        formula=str(identity.get("formula", "")),
        domain=domain,
        states=states,
        system=system,
        card=part("card", {}),
        absent=tuple(n for n in LOAD_NAMES if n in limits and limits[n] is None),
        interval=_level(part("interval", {}), {o.name for o in model.graph.output}, where),
    )


def _level(content: dict[str, object], outputs: set[str], where: str) -> float | None:
    """Return the level of the prediction interval, None without one."""
    if not content or MARGIN not in outputs:
        return None
    try:
        return check_level(content.get("level"))
    except InputError as error:
        raise InputError(f"{where}: metadata tribofmu.interval: {error}") from None


def _texts(values: object) -> tuple[str, ...]:
    if not isinstance(values, list) or not all(isinstance(v, str) for v in values):
        raise ValueError(f"labels {values!r:.60}")
    return tuple(values)
