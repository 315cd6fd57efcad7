"""The netCDF file of a contact history: as the reference library writes it, and read from what that wrote."""

from __future__ import annotations

from pathlib import Path

import netCDF4
import numpy as np

from forming.results.contact_history import ContactHistory
from forming.results.files import _read_contact
from forming.results.result import contact_dataset
from friction_models.common.netcdf_files import write_dataset


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
    data = contact_dataset(contact)
    write_dataset(data, ours)
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
