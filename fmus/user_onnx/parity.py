"""Compares the translated graph with the original in ONNX Runtime, so that a wrong translation is never packed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from friction_models.common import InputError
from friction_models.expressions.onnx_session import onnx_session
from friction_models.expressions.parameters import first_line
from friction_models.loads import LOADS

from .operators.nodes import Array, refuse
from .signature import Signature

POINTS = 256
#: Largest difference that counts as rounding, in units of the largest mu seen. Some kernels of
#: float64 graphs hold constants in float32.
TOLERANCE = {"float32": 1e-4, "float64": 1e-6}


class Reference:
    """The original run by the ONNX project's own NumPy implementation, where ONNX Runtime has no kernel for it."""

    name = "the ONNX reference implementation"

    def __init__(self, content: bytes) -> None:
        from onnx.reference import ReferenceEvaluator

        self._running = ReferenceEvaluator(content)

    def run(self, names: list[str], feed: dict[str, Array]) -> list[Any]:
        """Return the outputs called `names`."""
        with np.errstate(all="ignore"):
            return list(self._running.run(names, feed))


@dataclass(frozen=True)
class Agreement:
    """Largest difference of mu at random points, and the largest mu.

    Examples
    --------
    >>> print(Agreement(2e-9, 0.2, 1000, "float32"))
    largest difference to the original file in ONNX Runtime (float32) at 1000 random points: 2.0e-09 in mu, where the largest mu is 0.2
    """

    difference: float
    largest: float
    points: int
    kind: str
    runner: str = "ONNX Runtime"

    def __str__(self) -> str:
        return (
            f"largest difference to the original file in {self.runner} ({self.kind}) at {self.points} random points: "
            f"{self.difference:.1e} in mu, where the largest mu is {self.largest:.3g}"
        )


def session(content: bytes, where: str) -> Any:
    """Return a session of ONNX Runtime on one thread."""
    try:
        return onnx_session(content)
    except Exception as error:  # ONNX Runtime's error classes are not public
        raise InputError(f"{where}: ONNX Runtime refuses the graph ({first_line(error)})") from None


def original_mu(running: Any, signature: Signature, points: Array, where: str) -> Array:
    """Return what the original graph gives, shape (n,), scaled but not clipped.

    Raises InputError: the graph cannot be run, or gives other than one number a point.
    """
    parts = [points] if signature.batch else [points[k : k + 1] for k in range(len(points))]
    found = []
    for part in parts:
        try:
            result = running.run([signature.output], {f.name: f.fill(part) for f in signature.feeds})[0]
        except Exception as error:
            raise InputError(f"{where}: ONNX Runtime cannot run the graph ({first_line(error)})") from None
        values = np.ravel(np.asarray(result, dtype=np.float64)) if hasattr(result, "shape") else np.empty(0)
        if values.size != len(part):
            raise InputError(
                f"{where}: output {signature.output!r:.60} has {values.size} values for {len(part)} points, allowed: one each"
            )
        found.append(values)
    return signature.multiply * np.concatenate(found) + signature.add


def _runner(content: bytes, where: str) -> tuple[Any, str]:
    """Return what runs the original: ONNX Runtime, or the reference where that has no kernel (SVR in float64)."""
    try:
        return session(content, where), "ONNX Runtime"
    except InputError:
        try:
            return Reference(content), Reference.name
        except Exception:  # then the first refusal is the one to show
            pass
        raise


def sample(domain: dict[str, tuple[float, float]]) -> Array:
    """Return loads, shape (POINTS, 5): in the domain, in usual contact, and over many magnitudes."""
    rng = np.random.default_rng(7)
    usual = {
        "v_rel": (0.0, 600.0),
        "T": (20.0, 500.0),
        "sigma_n": (0.0, 3000.0),
        "sd": (0.0, 80.0),
        "psi": (0.5, 25.0),
    }
    boxes = [domain.get(q.name, usual[q.name]) for q in LOADS]
    boxes = [b if b != (q.lower, q.upper) else usual[q.name] for b, q in zip(boxes, LOADS)]
    low, high = np.array(boxes).T
    half = POINTS // 2
    near = rng.uniform(low, high, size=(half, len(LOADS)))
    floor = np.maximum(low, 1e-3)
    far = np.exp(
        rng.uniform(np.log(floor * 0.01 + 1e-3), np.log(np.maximum(high, floor) + 1e-2), size=near.shape)
    )
    return np.clip(np.vstack([near, far]), [q.lower for q in LOADS], [q.upper for q in LOADS])


def _before_clip(lowered: bytes, points: Array, where: str) -> Array:
    """Return mu of the redrawn graph before negative values become 0: there is more to compare."""
    import onnx
    from onnx import TensorProto, helper

    model = onnx.load_model_from_string(lowered)
    maker = {n.output[0]: n for n in model.graph.node}
    name = maker[maker["mu"].input[0]].input[0]
    model.graph.output.append(helper.make_tensor_value_info(name, TensorProto.DOUBLE, ["n", 1]))
    return np.asarray(session(model.SerializeToString(), where).run([name], {"loads": points})[0])[:, 0]


def compare(
    lowered: bytes, original: bytes, signature: Signature, domain: dict[str, tuple[float, float]], where: str
) -> Agreement:
    """Run both graphs at random points.

    Raises InputError: they differ by more than rounding, the original mixes points, or neither gives numbers.
    """
    points = sample(domain)
    running, runner = _runner(original, where)
    expected = original_mu(running, signature, points, where)
    if signature.batch:  # the points one by one must be the same function
        alone = np.concatenate([original_mu(running, signature, points[k : k + 1], where) for k in range(8)])
        spread = float(np.nanmax(np.abs(expected[np.isfinite(expected)]), initial=1e-3))
        if not np.allclose(alone, expected[:8], rtol=1e-4, atol=1e-5 * spread, equal_nan=True):
            raise InputError(
                f"{where}: mu of one point depends on the other points of a batch; allowed: one point, one mu"
            )
    mu = _before_clip(lowered, points, where)
    kind = "float32" if any(f.kind == "float32" for f in signature.feeds) else "float64"
    both = np.isfinite(mu) & np.isfinite(expected)
    if both.sum() < len(points) // 2:
        raise InputError(
            f"{where}: mu is a finite number at {int(both.sum())} of {len(points)} random points; allowed: at most of them"
        )
    largest = float(np.abs(expected[both]).max())
    difference = float(np.abs(mu - expected)[both].max())
    # float32 overflows where float64 does not; the other way round would be a wrong translation.
    lost = bool((np.isfinite(expected) & ~np.isfinite(mu)).any())
    if lost or difference > TOLERANCE[kind] * max(largest, 1e-3):
        shown = "not finite" if lost else f"off by {difference:.2e} where mu reaches {largest:.3g}"
        raise refuse(
            where,
            f"the graph in float64 is {shown} from the original in {runner}, allowed: {TOLERANCE[kind]:g} of "
            "the largest mu (float32 that cancels, or a wrong translation)",
        )
    return Agreement(difference, largest, len(points), kind, runner)
