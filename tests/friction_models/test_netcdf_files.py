"""netCDF files of runs and results: xarray reads the data set that was written, and the bytes are always the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray

from friction_models.common import InputError
from friction_models.common.netcdf_files import Dataset, Variable, open_dataset, write_dataset

UNIT = {"units": "1"}
RUN = Dataset(
    {
        "friction.mu": Variable(("time", "point_2"), np.array([[0.08, np.nan], [1e-300, -0.0]]), UNIT),
        "forming.active": Variable(("time",), np.array([0, 1], dtype=np.int8), UNIT),
    },
    {
        "time": Variable(("time",), np.array([0.0, 0.1]), {"units": "s"}),
        "point_2": Variable(("point_2",), np.array([1, 2]), {}),
        "stroke": Variable(("time",), np.array([0.0, 5.0]), {"units": "mm"}),
    },
    {"name": "fre µ", "synthetic": 1, "mesh_size": 0.25},
)


def test_xarray_reads_the_same_data_set(tmp_path: Path) -> None:
    write_dataset(RUN, tmp_path / "run.nc")
    with xarray.open_dataset(tmp_path / "run.nc", engine="netcdf4", decode_times=False) as found:
        xarray.testing.assert_identical(found.load(), xarray.Dataset(*RUN))
    write_dataset(RUN, tmp_path / "again.nc")
    assert (tmp_path / "again.nc").read_bytes() == (tmp_path / "run.nc").read_bytes()


def test_a_file_of_xarray_is_read(tmp_path: Path) -> None:
    xarray.Dataset(*RUN).to_netcdf(tmp_path / "old.nc", engine="h5netcdf")
    with open_dataset(tmp_path / "old.nc") as file:
        assert set(file.variables) == {*RUN.variables, *RUN.coordinates}
        for name, variable in {**RUN.variables, **RUN.coordinates}.items():
            np.testing.assert_array_equal(file.variables[name][...], variable.values)
        assert file.attrs["name"] == "fre µ" and file.attrs["mesh_size"] == 0.25


def test_a_name_with_a_slash_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"run\.nc: variable 'a/b'; allowed: names without '/'"):
        write_dataset(Dataset({"a/b": RUN.variables["forming.active"]}, {}, {}), tmp_path / "run.nc")
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize("packed", [{"scale_factor": 2.0}, {"add_offset": 1.0}, {"_FillValue": -999.0}])
def test_values_that_mean_something_else_than_their_numbers_are_refused(
    tmp_path: Path, packed: dict[str, float]
) -> None:
    data = xarray.Dataset(*RUN)
    data.to_netcdf(tmp_path / "packed.nc", engine="h5netcdf", encoding={"friction.mu": packed})
    with (
        pytest.raises(ValueError, match=rf"variable 'friction.mu' has the attribute '{next(iter(packed))}'"),
        open_dataset(tmp_path / "packed.nc"),
    ):
        pass
