"""Generated models called directly, without an FMU around them: one small library of many models."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from fmus.interface.friction_source import FrictionSource, parse_source
from fmus.native import compile as compiling
from fmus.native.generate import generate

Array = npt.NDArray[np.float64]
NATIVE = Path(compiling.__file__).parent

#: Functions of one model; rows of points in, values out, so that no loop is needed in Python.
_MODEL = """\
#include "model_@.h"
#include <stdlib.h>
#define SHOWN __attribute__((visibility("default")))
SHOWN void mu_@(int n, const double *L, const double *S, const double *P, double *out, int build) {
    for (int i = 0; i < n; ++i) {
        const double *l = L + 5 * i, *s = S + TF_STATES * i;
        if (build == 0) tf_model_mu(l, s, P, out + i);
        else if (build == 1) tf_model_mu_plain(l, s, P, out + i);
        else tf_model_mu_wide(l, s, P, out + i);
    }
}
/* Blocks of `filled` points from `first` on; the rest of a block repeats the last point. */
SHOWN void block_@(int n, const double *L, const double *S, const double *P, double *out, int build, int first) {
    double l[5 * TF_BLOCK], s[(TF_STATES + 1) * TF_BLOCK], mu[TF_BLOCK];
    for (int start = -first; start < n; start += TF_BLOCK) {
        for (int i = 0; i < TF_BLOCK; ++i) {
            const int point = start + i < 0 ? 0 : start + i < n ? start + i : n - 1;
            for (int k = 0; k < 5; ++k) l[k * TF_BLOCK + i] = L[5 * point + k];
            for (int k = 0; k < TF_STATES; ++k) s[k * TF_BLOCK + i] = S[TF_STATES * point + k];
        }
        if (build == 0) tf_model_mu_block(l, s, P, mu);
        else if (build == 1) tf_model_mu_block_plain(l, s, P, mu);
        else tf_model_mu_block_wide(l, s, P, mu);
        for (int i = 0; i < TF_BLOCK; ++i)
            if (start + i >= 0 && start + i < n) out[start + i] = mu[i];
    }
}
SHOWN void mu_d_@(int n, const double *L, const double *S, const double *P, const double *dL, const double *dS,
                  const double *dP, double *out, double *dout) {
    for (int i = 0; i < n; ++i)
        tf_model_mu_d(L + 5 * i, S + TF_STATES * i, P, dL + 5 * i, dS + TF_STATES * i, dP, out + i, dout + i);
}
#if TF_STATES
SHOWN void step_@(int n, const double *L, const double *S, const double *P, double dt, double *out) {
    for (int i = 0; i < n; ++i) tf_model_step(L + 5 * i, S + TF_STATES * i, P, dt, out + TF_STATES * i);
}
#endif
#if TF_ODE
SHOWN void der_@(int n, const double *L, const double *S, const double *P, double *out) {
    for (int i = 0; i < n; ++i) tf_model_der(L + 5 * i, S + TF_STATES * i, P, out + TF_STATES * i);
}
SHOWN void der_d_@(int n, const double *L, const double *S, const double *P, const double *dL, const double *dS,
                   const double *dP, double *out, double *dout) {
    for (int i = 0; i < n; ++i)
        tf_model_der_d(L + 5 * i, S + TF_STATES * i, P, dL + 5 * i, dS + TF_STATES * i, dP, out + TF_STATES * i,
                       dout + TF_STATES * i);
}
#endif
"""
_MATH = """\
#include "lanes.h"
#include "lanes_math.h"
#define SHOWN __attribute__((visibility("default")))
SHOWN int has_wide(void) { return tf_wide(); }
#define BOTH(name) \\
    SHOWN void name##_many(double *x, int n, int build) { if (build == 1) name##_plain_n(x, n); else name##_wide_n(x, n); } \\
    SHOWN double name##_one(double x, int build) { return build == 1 ? name##_plain(x) : name##_wide(x); }
BOTH(tf_exp) BOTH(tf_log) BOTH(tf_tanh) BOTH(tf_sigmoid)
"""
BUILDS = {"chosen": 0, "plain": 1, "wide": 2}


def compiler() -> list[str] | None:
    """Return the compiler of the FMUs for this machine, None where there is none."""
    zig = compiling.zig_command()
    # Without a target Zig would use all that this processor can do.
    return [*zig, "-target", compiling.host_platform().target] if zig else compiling.system_command()


def compile_library(sources: Mapping[str, str], folder: Path, *more: str) -> ctypes.CDLL:
    """Compile C files with the flags of the FMUs, and load the library."""
    command = compiler()
    if command is None:
        pytest.skip("no C compiler: neither Zig (extra [cross]) nor cc, gcc or clang is installed")
    for name, text in sources.items():
        (folder / name).write_text(text, encoding="utf-8")
    files = [n for n in sources if n.endswith(".c")]
    flags = [*compiling._FLAGS, "-Wall", "-Wextra", "-Wshadow", "-Werror", "-shared", "-fPIC", *more]
    done = subprocess.run(
        [*command, *flags, *files, "-o", "models.so", "-lm"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return ctypes.CDLL(str(folder / "models.so"))


def kernel_sources() -> dict[str, str]:
    """Return the C files of the mathematical functions."""
    names = ("lanes.h", "lanes_math.h")
    return {n: (NATIVE / n).read_text(encoding="utf-8") for n in names} | {"math.c": _MATH}


class Compiled:
    """Many models in one library.

    Parameters
    ----------
    models : mapping of str to bytes
        Name to ONNX file.
    folder : Path
        Empty folder for the build.
    *flags : str
        More options of the compiler.
    """

    def __init__(self, models: Mapping[str, bytes], folder: Path, *flags: str) -> None:
        self.sources: dict[str, FrictionSource] = {n: parse_source(c, n) for n, c in models.items()}
        self._number = {name: k for k, name in enumerate(models)}
        texts = kernel_sources()
        for name, source in self.sources.items():
            k = self._number[name]
            texts[f"model_{k}.h"] = generate(source, source.interface(1))
            texts[f"model_{k}.c"] = _MODEL.replace("@", str(k))
        self.library = compile_library(texts, folder, *flags)
        self.has_wide = bool(self.library.has_wide())

    def builds(self) -> Sequence[str]:
        """Return the builds that this processor can run."""
        return ("chosen", "plain", "wide") if self.has_wide else ("chosen", "plain")

    def _call(
        self, function: str, name: str, points: int, arrays: Sequence[Array | float], *more: int
    ) -> None:
        values = [
            ctypes.c_double(a) if isinstance(a, float) else a.ctypes.data_as(ctypes.c_void_p) for a in arrays
        ]
        getattr(self.library, f"{function}_{self._number[name]}")(points, *values, *more)

    def _point(self, name: str, loads: Array, state: Array | None, system: Array | None) -> list[Any]:
        source = self.sources[name]
        if state is None:
            state = np.tile([s.start for s in source.states], (len(loads), 1))
        if system is None:
            system = np.array([p.start for p in source.system])
        return [np.ascontiguousarray(a, dtype=np.float64) for a in (loads, state, system)]

    def mu(
        self,
        name: str,
        loads: Array,
        state: Array | None = None,
        system: Array | None = None,
        build: str = "chosen",
        first: int | None = None,
    ) -> Array:
        """Return mu, shape (n,): point by point, or in blocks of which the first starts at place `first`."""
        out = np.full(len(loads), np.nan)
        arrays = [*self._point(name, loads, state, system), out]
        if first is None:
            self._call("mu", name, len(loads), arrays, BUILDS[build])
        else:
            self._call("block", name, len(loads), arrays, BUILDS[build], first)
        return out

    def step(
        self, name: str, loads: Array, state: Array | None, dt: float, system: Array | None = None
    ) -> Array:
        """Return the states after `dt` seconds, shape (n, k)."""
        arrays = self._point(name, loads, state, system)
        out = np.full_like(arrays[1], np.nan)
        self._call("step", name, len(loads), [*arrays, float(dt), out])
        return out

    def rate(self, name: str, loads: Array, state: Array | None, system: Array | None = None) -> Array:
        """Return the time derivatives of the states, shape (n, k)."""
        arrays = self._point(name, loads, state, system)
        out = np.full_like(arrays[1], np.nan)
        self._call("der", name, len(loads), [*arrays, out])
        return out

    def derivative(
        self,
        what: str,
        name: str,
        point: Sequence[Array | None],
        along: Sequence[Array],
    ) -> tuple[Array, Array]:
        """Return value and derivative of ``mu`` (n,) or of the rates ``der`` (n, k).

        `point` and `along` are loads, states and system variables and the direction in them.
        """
        loads = point[0]
        assert loads is not None
        arrays = self._point(name, loads, point[1], point[2])
        seeds = [np.ascontiguousarray(a, dtype=np.float64) for a in along]
        shape = (len(loads),) if what == "mu" else arrays[1].shape
        out, change = np.full(shape, np.nan), np.full(shape, np.nan)
        self._call(f"{what}_d", name, len(loads), [*arrays, *seeds, out, change])
        return out, change
