"""Curves along loads: splines that follow an effect whose formula is not known."""

from __future__ import annotations

import numpy as np

from ...loads import LOAD_NAMES, FloatArray
from .binned_tests import BinnedTests


def curve(values: FloatArray, knots: int) -> FloatArray:
    """Return a cubic-like basis: powers and truncated squares at quantiles, shape (m, knots + 2)."""
    z = (values - values.mean()) / max(float(values.std()), 1e-12)
    inner = np.quantile(z, np.linspace(0, 1, knots + 2)[1:-1])
    columns = [z, z**2, *(np.maximum(z - k, 0.0) ** 2 for k in np.unique(inner))]
    return np.column_stack(columns)


def products(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the products of all columns of two blocks, shape (m, columns of a times columns of b)."""
    return (a[:, :, None] * b[:, None, :]).reshape(len(a), -1)


def transformed(campaign: BinnedTests, name: str) -> FloatArray:
    """Return bin means of a load on the scale on which its curve is drawn."""
    return on_scale(name, campaign.average(campaign.path if name == "sd" else getattr(campaign.loads, name)))


def scaled_loads(campaign: BinnedTests) -> dict[str, FloatArray]:
    """Return bin means of each load on the scale of its curve; one that varies only between the points of an average says nothing."""
    scaled = {n: transformed(campaign, n) for n in LOAD_NAMES if campaign.varies(n)}
    return {n: values for n, values in scaled.items() if np.ptp(values) > 0.0}


def on_scale(name: str, values: FloatArray) -> FloatArray:
    """Return values of a load (of `sd` the path) on the scale on which its curve is drawn."""
    if name == "v_rel":
        return np.log(values + 0.02 * max(float(values.max()), 1e-12))
    if name == "sd":
        return np.sqrt(np.maximum(values, 0.0))
    if name in {"sigma_n", "psi"}:
        return np.log(np.maximum(values, 1e-9 * max(float(values.max()), 1e-12)))
    return values


def spline_columns(campaign: BinnedTests, drivers: tuple[str, ...], knots: int = 4) -> FloatArray:
    """Return curves along the named loads, shape (m, k); loads that do not vary give nothing."""
    names = [d for d in drivers if d in LOAD_NAMES and campaign.varies(d)]
    blocks = [curve_along(campaign, n, knots) for n in names]
    return np.column_stack(blocks) if blocks else np.empty((len(campaign.starts), 0))


def curve_along(campaign: BinnedTests, name: str, knots: int) -> FloatArray:
    """Return a curve along a load, shape (m, k); along the path of all tests and along each test where these go on on one track."""
    along = curve(transformed(campaign, name), knots)
    if name != "sd" or campaign.path is campaign.distance:
        return along
    return np.column_stack([along, curve(on_scale("sd", campaign.average(campaign.distance)), knots)])
