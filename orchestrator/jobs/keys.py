"""What decides the result of a job, as hashes: inputs, file contents, versions and sources."""

from __future__ import annotations

from friction_models.common.kept import code_digest, digest, path_digest

__all__ = ["DISTRIBUTIONS", "code_digest", "digest", "path_digest"]

#: Distributions whose version may change a number.
DISTRIBUTIONS = (
    "fmpy", "netCDF4", "numba", "numpy", "onnx", "onnxruntime", "pandas", "pythonfmu",
    "scikit-learn", "scipy", "torch", "xarray",
)  # fmt: skip
