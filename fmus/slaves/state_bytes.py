"""Solver states as bytes: a tree of known classes, numbers and arrays, without pickle.

The bytes are a mark, the length of a JSON tree (8 bytes), the tree, the arrays one after the other, and a SHA-256
of all that. The tree names classes; only those that the reader expects are made, without running code of
theirs. Numbers and arrays come back bit by bit; what stands at two places is one thing again.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError

MARK = b"tribofmu solver state 1\n"
_DTYPES = ("float64", "int64", "int32", "bool")
_SUM = hashlib.sha256().digest_size


def to_bytes(thing: Any, identity: str, classes: Sequence[type]) -> bytes:
    """Return `thing` as bytes: None, bool, int, float, str, lists, tuples, arrays and objects of `classes`.

    `identity` is what the reader must know to be the right one.
    Raises TypeError: something of another type in it.
    """
    writer = _Writer(classes)
    tree = writer.node(thing)
    shapes = [[a.dtype.name, list(a.shape)] for a in writer.arrays]
    head = json.dumps({"identity": identity, "tree": tree, "arrays": shapes}, separators=(",", ":")).encode()
    content = b"".join([MARK, struct.pack("<Q", len(head)), head, *(a.tobytes() for a in writer.arrays)])
    return content + hashlib.sha256(content).digest()


def from_bytes(content: bytes, identity: str, classes: Sequence[type]) -> Any:
    """Return what `to_bytes` was given.

    Raises InputError: not such bytes, damaged ones, or ones with another identity.
    """
    start = len(MARK) + 8
    if not content.startswith(MARK) or len(content) < start + _SUM:
        raise InputError("the serialized state is not one of a solver FMU")
    if hashlib.sha256(content[:-_SUM]).digest() != content[-_SUM:]:
        raise InputError("the serialized state is damaged: its check sum is wrong")
    (length,) = struct.unpack_from("<Q", content, len(MARK))
    try:
        head = json.loads(content[start : start + length])
        if head["identity"] != identity:
            raise InputError("the serialized state belongs to another FMU, or to another version of tribofmu")
        arrays, at = [], start + length
        for name, shape in head["arrays"]:
            dtype = np.dtype(_DTYPES[_DTYPES.index(name)])
            size = dtype.itemsize * int(np.prod(shape, dtype=np.int64))
            arrays.append(np.frombuffer(content[at : at + size], dtype=dtype).reshape(shape).copy())
            at += size
        if at != len(content) - _SUM:
            raise ValueError("length")
        return _Reader(classes, arrays).thing(head["tree"])
    except (KeyError, ValueError, TypeError, IndexError, AttributeError, RecursionError) as error:
        raise InputError(f"the serialized state cannot be read ({error})") from None


class _Writer:
    def __init__(self, classes: Sequence[type]) -> None:
        self.classes = classes
        self.arrays: list[npt.NDArray[Any]] = []
        self.seen: dict[int, tuple[int, Any]] = {}

    def node(self, thing: Any) -> Any:
        if thing is None or type(thing) in (bool, int, float, str):
            return thing
        if id(thing) in self.seen:
            return {"same": self.seen[id(thing)][0]}
        if isinstance(thing, np.generic):
            self.arrays.append(np.asarray(thing))
            return {"number": len(self.arrays) - 1}
        self.seen[id(thing)] = len(self.seen), thing  # kept alive: the number of an object may be used again
        if type(thing) is np.ndarray:
            if thing.dtype.name not in _DTYPES:
                raise TypeError(f"array of {thing.dtype} in a solver state")
            self.arrays.append(thing)
            return {"array": len(self.arrays) - 1}
        if type(thing) is list:
            return {"list": [self.node(t) for t in thing]}
        if type(thing) is tuple:
            return {"tuple": [self.node(t) for t in thing]}
        if type(thing) not in self.classes:
            raise TypeError(f"{type(thing).__name__} in a solver state")
        if isinstance(thing, tuple):
            return {"class": type(thing).__name__, "items": [self.node(t) for t in thing]}
        return {"class": type(thing).__name__, "has": {k: self.node(v) for k, v in vars(thing).items()}}


class _Reader:
    def __init__(self, classes: Sequence[type], arrays: Sequence[npt.NDArray[Any]]) -> None:
        self.classes = {c.__name__: c for c in classes}
        self.arrays = arrays
        self.made: list[Any] = []

    def thing(self, node: Any) -> Any:
        if not isinstance(node, dict):
            return node
        if "same" in node:
            return self.made[node["same"]]
        if "number" in node:
            return self.arrays[node["number"]][()]
        place = len(self.made)
        self.made.append(None)
        self.made[place] = made = self._make(node, place)
        return made

    def _make(self, node: Any, place: int) -> Any:
        if "array" in node:
            return self.arrays[node["array"]]
        if "list" in node:
            return [self.thing(n) for n in node["list"]]
        if "tuple" in node:
            return tuple(self.thing(n) for n in node["tuple"])
        kind = self.classes[node["class"]]
        if "items" in node:
            return kind(*(self.thing(n) for n in node["items"]))
        if dataclasses.is_dataclass(kind) and {f.name for f in dataclasses.fields(kind)} != set(node["has"]):
            raise ValueError(f"{node['class']} has other parts here")
        made: Any = object.__new__(kind)
        self.made[place] = made
        made.__dict__.update({k: self.thing(n) for k, n in node["has"].items()})
        return made
