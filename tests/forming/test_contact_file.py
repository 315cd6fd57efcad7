"""The netCDF file of a contact history: as the reference library writes it, and read from what that wrote."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray

from forming.results.contact_history import ContactHistory
from forming.results.files import _read_contact
from forming.results.result import FormingResult, contact_dataset
from friction_models.common import InputError
from friction_models.common.netcdf_files import Dataset, NetcdfVariable, write_dataset


def test_it_is_the_file_that_the_reference_library_would_write(tmp_path: Path) -> None:
    rng, steps, points = np.random.default_rng(3), 4, 3
    contact = ContactHistory(
        stroke=np.arange(4.0),
        loads=rng.random((steps, points, 5)),
        active=rng.random((steps, points)) > 0.5,
        mu=rng.random((steps, points)),
        position=rng.random((steps, points, 2)),
        tau_over_k=np.where(rng.random((steps, points)) > 0.5, np.nan, 0.4),
        errors=None,
    )
    ours, other = tmp_path / "ours.nc", tmp_path / "other.nc"
    write_dataset(contact_dataset(contact), ours)
    data = xarray.Dataset(*contact_dataset(contact))
    packed = {str(v): {"zlib": True, "complevel": 4} for v in data.data_vars}
    data.to_netcdf(other, engine="netcdf4", encoding=packed)
    with netCDF4.Dataset(ours) as one, netCDF4.Dataset(other) as two:
        one.set_auto_mask(False)
        two.set_auto_mask(False)
        assert list(one.variables) == list(two.variables) and len(one.variables) > 8
        for name in one.variables:
            a, b = one[name], two[name]
            assert (a.dtype, a.dimensions, a.filters()) == (b.dtype, b.dimensions, b.filters())
            assert {k: str(a.getncattr(k)) for k in a.ncattrs()} == {
                k: str(b.getncattr(k)) for k in b.ncattrs()
            }
            np.testing.assert_array_equal(a[:], b[:])
    for path in (ours, other):
        found = _read_contact(path)
        for field in ("stroke", "loads", "active", "mu", "position", "tau_over_k"):
            np.testing.assert_array_equal(getattr(found, field), getattr(contact, field))


def history(steps: int = 4, points: int = 3) -> ContactHistory:
    rng = np.random.default_rng(3)
    one = rng.random((steps, points))
    return ContactHistory(
        np.arange(float(steps)), rng.random((steps, points, 5)), one > 0.5, one, np.zeros((steps, points, 2)), one,
        errors=rng.random((steps, points, 5)),
    )  # fmt: skip


def changed(path: Path, name: str, change: Callable[[NetcdfVariable], NetcdfVariable]) -> Path:
    """Write a contact history of which one variable is another."""
    values, coordinates, about = contact_dataset(history())
    parts = {**values, **coordinates}
    parts[name] = change(parts[name])
    every = {n: v for n, v in parts.items() if n not in coordinates}
    write_dataset(Dataset(every, {n: parts[n] for n in coordinates}, about), path)
    return path


@pytest.mark.parametrize(
    ("name", "unit", "factor", "offset"),
    [
        ("sigma_n", "GPa", 1e-3, 0.0),
        ("sigma_n_error", "kN/mm2", 1e-3, 0.0),
        ("T", "K", 1.0, 273.15),
        ("T_error", "K", 1.0, 0.0),
        ("stroke", "m", 1e-3, 0.0),
        ("z", "um", 1e3, 0.0),
        ("v_rel", "", 1.0, 0.0),
    ],
)
def test_other_units_are_converted(
    tmp_path: Path, name: str, unit: str, factor: float, offset: float
) -> None:
    def other(v: NetcdfVariable) -> NetcdfVariable:
        return NetcdfVariable(v.dimensions, factor * v.values + offset, {"units": unit} if unit else {})

    found, same = _read_contact(changed(tmp_path / "contact.nc", name, other)), history()
    assert found.errors is not None and same.errors is not None
    np.testing.assert_allclose(found.loads, same.loads)
    np.testing.assert_allclose(found.errors, same.errors)
    np.testing.assert_allclose(found.stroke, same.stroke)
    np.testing.assert_allclose(found.position, same.position)


def test_a_unit_of_something_else_is_refused(tmp_path: Path) -> None:
    file = changed(tmp_path / "contact.nc", "sigma_n", lambda v: v._replace(attributes={"units": "N"}))
    with pytest.raises(
        InputError, match=r"contact\.nc: unknown unit of column 'sigma_n' 'N'; allowed: .*MPa"
    ):
        _read_contact(file)


@pytest.mark.parametrize(
    ("name", "dimensions", "shape", "words"),
    [
        ("mu", ("point", "step"), (3, 4), r"'mu' has the shape \(3, 4\); allowed: \(4, 3\)"),
        ("active", ("step", "few"), (4, 2), r"'active' has the shape \(4, 2\); allowed: \(4, 3\)"),
        ("v_rel", ("step",), (4,), r"has the shape \(4.*\); allowed: \(4"),
        ("tau_over_k", ("one", "few"), (1, 2), r"'tau_over_k' has the shape \(1, 2\); allowed: \(4, 3\)"),
        ("sigma_n_error", ("step", "few"), (4, 2), r"'sigma_n_error' has the shape \(4, 2\)"),
        ("stroke", ("short",), (2,), r"'v_rel' has the shape \(4, 3\); allowed: \(2, points\)"),
        ("stroke", ("step", "point"), (4, 3), r"steps of shape \(4, 3\)"),
    ],
)
def test_other_shapes_are_refused(
    tmp_path: Path, name: str, dimensions: tuple[str, ...], shape: tuple[int, ...], words: str
) -> None:
    file = changed(
        tmp_path / "contact.nc", name, lambda v: NetcdfVariable(dimensions, np.zeros(shape), v.attributes)
    )
    with pytest.raises(InputError, match=rf"contact\.nc: .*{words}"):
        _read_contact(file)


@pytest.mark.parametrize(
    ("name", "words"), [("T", "variable 'T' is not finite in contact"), ("stroke", "finite number a step")]
)
def test_what_is_not_finite_is_refused(tmp_path: Path, name: str, words: str) -> None:
    file = changed(tmp_path / "contact.nc", name, lambda v: v._replace(values=v.values * np.nan))
    with pytest.raises(InputError, match=rf"contact\.nc: .*{words}"):
        _read_contact(file)


def test_a_result_shows_itself_on_one_line() -> None:
    stroke = np.array([0.0, 5.0, 10.0])
    result = FormingResult(stroke, 10.0 * stroke, stroke, 0.1, 0.0, 0.0, 0.0, 2, 0, 0, history())
    assert re.fullmatch(r"FormingResult\(2 steps to 10 mm, max_force=\S+ kN, ok\)", repr(result))
