"""netCDF files of runs and results: xarray reads the data set that was written, and the bytes are always the same."""

from __future__ import annotations

import re
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray

from friction_models.common import InputError
from friction_models.common.netcdf_files import Dataset, NetcdfVariable, read_numbers, write_dataset

UNIT = {"units": "1"}
RUN = Dataset(
    {
        "friction.mu": NetcdfVariable(("time", "point_2"), np.array([[0.08, np.nan], [1e-300, -0.0]]), UNIT),
        "forming.active": NetcdfVariable(("time",), np.array([0, 1], dtype=np.int8), UNIT),
    },
    {
        "time": NetcdfVariable(("time",), np.array([0.0, 0.1]), {"units": "s"}),
        "point_2": NetcdfVariable(("point_2",), np.array([1, 2]), {}),
        "stroke": NetcdfVariable(("time",), np.array([0.0, 5.0]), {"units": "mm"}),
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
    found = read_numbers(tmp_path / "old.nc", ["time"])
    assert set(found.values) == {*RUN.variables, *RUN.coordinates}
    for name, variable in {**RUN.variables, **RUN.coordinates}.items():
        np.testing.assert_array_equal(found.values[name], variable.values)
        assert found.units[name] == variable.attributes.get("units", "")
    assert found.attributes["name"] == "fre µ" and found.scales == {"time", "point_2"}


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
    with pytest.raises(InputError, match=rf"variable 'friction.mu' has the attribute '{next(iter(packed))}'"):
        read_numbers(tmp_path / "packed.nc")


def test_what_cannot_be_read_is_refused_in_one_sentence_that_names_the_file(tmp_path: Path) -> None:
    file = tmp_path / "results.nc"

    def refused(pattern: str, **limits: float) -> None:
        with pytest.raises(InputError, match=rf"^{re.escape(str(file))}: {pattern}$"):
            read_numbers(file, ["time"], **limits)

    write_dataset(RUN, file)
    whole = file.read_bytes()
    refused("12 numbers; allowed: at most 5", most=5)
    for damaged in (whole[:-100], whole[:100], whole[:48] + bytes(1000) + whole[1048:]):
        file.write_bytes(damaged)
        refused(rf"damaged or cut short \({len(damaged)} bytes\); allowed: the file as it was written")
    file.write_bytes(b"time,mu")
    refused(r"not a netCDF-4 file \(7 bytes\); allowed: the file as it was written")
    write_dataset(RUN._replace(coordinates={}), file)
    refused(r"unknown variable 'time'; allowed: forming\.active, friction\.mu")
    with h5py.File(file, "w") as foreign:
        foreign["time"] = np.arange(3.0)
    refused("variable 'time' has no dimensions with a name; allowed: netCDF dimension scales")
    with h5py.File(file, "w") as foreign:
        foreign["time"] = ["now", "then"]
    refused("variable 'time' holds object; allowed: numbers")
