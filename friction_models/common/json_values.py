"""Objects read from JSON, and results as JSON holds them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

#: An object as it was read from JSON: what is in it, whoever takes it has to check.
JsonObject: TypeAlias = Mapping[str, Any]


def plain(value: Any) -> Any:
    """Return `value` as JSON holds it: numbers of NumPy become Python's, NaN and infinity become null.

    Examples
    --------
    >>> import numpy as np
    >>> plain({"mu": np.array([0.1, np.nan]), "n": np.int64(3), 1: (True, None)})
    {'mu': [0.1, None], 'n': 3, '1': [True, None]}
    """
    import numpy as np

    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple | set):
        return [plain(v) for v in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Path):
        return value.as_posix()
    return value
