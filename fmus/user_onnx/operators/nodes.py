"""Nodes of a foreign graph, and what of them is not translated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy.typing as npt

from friction_models.common import InputError

Array = npt.NDArray[Any]
MAX_ELEMENTS = 1 << 24
MAX_RANK = 8
#: Element types by ONNX code; real numbers of every precision become float64, float32 is remembered.
KINDS: dict[int, str] = {
    1: "float32",
    2: "int64",
    3: "int64",
    4: "int64",
    5: "int64",
    6: "int64",
    7: "int64",
    9: "bool",
    10: "float32",
    11: "float64",
    12: "int64",
    16: "float32",
}


class NotTranslated(InputError):
    """A graph that cannot become C but that ONNX Runtime may run (`--target python`)."""


def refuse(where: str, what: str) -> NotTranslated:
    """Build the error for something that is not translated.

    Examples
    --------
    >>> print(refuse("law.onnx", "operator 'LSTM' has no translation"))
    law.onnx: operator 'LSTM' has no translation; pack it with --target python, which runs ONNX Runtime
    """
    return NotTranslated(f"{where}: {what}; pack it with --target python, which runs ONNX Runtime")


@dataclass(frozen=True)
class ForeignNode:
    """One node: operator, its domain (empty for the standard one), attributes, names in and out.

    Examples
    --------
    >>> ForeignNode("Scaler", "ai.onnx.ml", {}, ("x",), ("y",), "node 0").full
    'ai.onnx.ml.Scaler'
    """

    op: str
    domain: str
    attributes: dict[str, Any]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    label: str

    @property
    def full(self) -> str:
        """Operator with its domain, for messages."""
        return f"{self.domain}.{self.op}" if self.domain else self.op
