"""Tests whose upsetting and sliding lie in two files: finds the pairs and joins their channels."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from friction_models.common import InputError
from friction_models.loads import FloatArray

from ..records.cells import check_keys, is_given
from .measurement_files import LeftOut

_KEYS = ("upsetting", "sliding")
#: Without a stated waiting time the plate is taken to start so soon after the upsetting file ends [s].
_SOON = 1e-3


@dataclass(frozen=True)
class PhaseFiles:
    """How the names of the files end: ``{upsetting: _up, sliding: _slide}``; what stands before is the test.

    >>> endings = PhaseFiles("_up", "_slide")
    >>> pairs, left_out = endings.pairs([Path("sct1_up.csv"), Path("sct1_slide.csv"), Path("sct2_up.csv")])
    >>> [test for test, _, _ in pairs], len(left_out)
    (['sct1'], 1)
    """

    upsetting: str
    sliding: str

    @classmethod
    def load(cls, content: Any, where: str) -> PhaseFiles | None:
        """Read ``{files: {upsetting: ..., sliding: ...}}``; None where phases are given in another way.

        Raises InputError: unknown keys, endings that are no text, or the same.
        """
        if not isinstance(content, Mapping) or "files" not in content:
            return None
        check_keys(content, ["files"], f"{where}: phases with files")
        endings = content["files"]
        if not isinstance(endings, Mapping):
            raise InputError(f"{where}: phases: files is {endings!r}; allowed: upsetting and sliding")
        check_keys(endings, _KEYS, f"{where}: phases: files")
        values = [endings.get(key) for key in _KEYS]
        for key, value in zip(_KEYS, values):
            if not isinstance(value, str) or not value:
                raise InputError(
                    f"{where}: phases: files: {key} is {value!r}; allowed: the end of a file name, such as '_up'"
                )
        if values[0] == values[1]:
            raise InputError(f"{where}: phases: files: both end with {values[0]!r}; allowed: two endings")
        return cls(str(values[0]), str(values[1]))

    def pairs(self, files: Iterable[Path]) -> tuple[list[tuple[str, Path, Path]], list[LeftOut]]:
        """Return (test, upsetting file, sliding file) for every test, and what has no counterpart."""
        found: dict[str, dict[str, Path]] = {}
        left_out: list[LeftOut] = []
        for file in files:
            for key in _KEYS:
                ending = getattr(self, key)
                if file.stem.endswith(ending) and len(file.stem) > len(ending):
                    parts = found.setdefault(file.stem.removesuffix(ending), {})
                    if key in parts:
                        left_out.append(_said(file, f"a second {key} file of its test; allowed: one"))
                    else:
                        parts[key] = file
                    break
            else:
                left_out.append(
                    _said(file, f"its name ends with neither {self.upsetting!r} nor {self.sliding!r}")
                )
        complete = []
        for test, parts in found.items():
            if len(parts) == 2:
                complete.append((test, parts["upsetting"], parts["sliding"]))
                continue
            key, file = next(iter(parts.items()))
            other = next(k for k in _KEYS if k != key)
            left_out.append(_said(file, f"test {test!r} has no {other} file; allowed: one of each"))
        return complete, left_out


def _said(file: Path, reason: str) -> LeftOut:
    return LeftOut(str(file), f"{file}: {reason}")


def join(
    upsetting: Mapping[str, FloatArray],
    sliding: Mapping[str, FloatArray],
    upsetting_file: str,
    sliding_file: str,
    wait: Any,
) -> tuple[dict[str, FloatArray], list[str]]:
    """Return the channels of both files one after the other, and what was assumed.

    Raises InputError: a waiting time that is none, or files that overlap only in part.

    - `upsetting`, `sliding`: channels; those that the upsetting file lacks are taken to stay as the sliding
      file begins (position, temperature, friction force) or to be 0 (speed, acceleration).
    - `wait`: stated time between the files [s]; not needed when the second begins after the first on one
      clock.
    """
    notes: list[str] = []
    t_up, t_slide = upsetting["t"], sliding["t"]
    for t, file in ((t_up, upsetting_file), (t_slide, sliding_file)):
        if len(t) < 2 or not np.isfinite(t[[0, -1]]).all() or t[-1] <= t[0]:
            raise InputError(
                f"{file}: column 't' does not increase over {len(t)} rows; allowed: two at least"
            )
    shift = 0.0
    if not t_slide[0] > t_up[-1]:
        if t_slide[0] > t_up[0] and t_slide[-1] > t_up[-1] and t_slide[0] > 0.5 * (t_up[0] + t_up[-1]):
            raise InputError(
                f"{sliding_file}: begins at {float(t_slide[0]):g} s, {Path(upsetting_file).name} ends at "
                f"{float(t_up[-1]):g} s; allowed: one clock without overlap, or a clock of its own from 0 on"
            )
        pause = _SOON
        if is_given(wait):
            try:
                pause = float(wait)
            except (TypeError, ValueError):
                pause = math.nan
            if not 0.0 < pause < 1e5:
                raise InputError(f"{sliding_file}: metadata 't_wait' is {wait!r}; allowed: 0 to 1e5 s")
        else:
            notes.append("clocks of their own and no t_wait: sliding is taken to begin right after upsetting")
        shift = float(t_up[-1]) + pause - float(t_slide[0])
    joined = {"t": np.concatenate([t_up, t_slide + shift])}
    for name, values in sliding.items():
        if name == "t":
            continue
        if name in upsetting:
            before = upsetting[name]
        else:
            first = values[: max(1, min(20, len(values) // 20))]
            before = np.full(len(t_up), 0.0 if name in ("a", "v") else float(np.median(first)))
            if name not in ("a", "v", "s"):
                notes.append(f"no {name} in the upsetting file: taken to stay as at the start of sliding")
        joined[name] = np.concatenate([before, values])
    return joined, notes
