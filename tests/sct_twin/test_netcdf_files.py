"""netCDF files of the twin: readers of others see what was written, and files of earlier versions are read."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import netCDF4
import numpy as np
import pytest

from sct_twin.twin import test_result as results
from sct_twin.twin.test_result import read_netcdf, write_netcdf

COLUMNS = {"t": np.array([0.0, 0.1, 0.25]), "T": np.array([20.0, np.nan, 1e-300]), "mu": np.full(3, 0.1)}
RESULT = results.TestResult("sct 7 µm", COLUMNS, {"area": 78.5, "zero": None, "note": 'a "b"'})


@pytest.fixture
def file(tmp_path: Path) -> Path:
    write_netcdf(RESULT, tmp_path / "one.nc", {"synthetic": "true", "seed": "7"})
    return tmp_path / "one.nc"


def test_the_reference_library_reads_dimension_variables_units_and_attributes(file: Path) -> None:
    with netCDF4.Dataset(file) as data:
        assert (data.data_model, {n: len(d) for n, d in data.dimensions.items()}) == (
            "NETCDF4",
            {"point": 3},
        )
        assert not data.dimensions["point"].isunlimited()
        assert list(data.variables) == list(COLUMNS)
        for name, values in COLUMNS.items():
            found = data[name]
            assert (found.dimensions, found.dtype, found.ncattrs()) == (("point",), np.float64, ["units"])
            assert found.filters()["zlib"] and found.filters()["shuffle"]
            np.testing.assert_array_equal(np.asarray(found[:]), values)
        assert [data[n].units for n in COLUMNS] == ["s", "degC", "1"]
        assert (data.test_id, data.synthetic, data.seed) == ("sct 7 µm", "true", "7")
    if shutil.which("ncdump"):
        said = subprocess.run(["ncdump", "-h", str(file)], capture_output=True, text=True, check=True).stdout
        assert 'T:units = "degC"' in said


def test_what_was_written_comes_back_and_the_bytes_are_always_the_same(file: Path, tmp_path: Path) -> None:
    found = read_netcdf(file)
    assert found is not None and (found.test_id, found.summary) == (RESULT.test_id, RESULT.summary)
    for name, values in COLUMNS.items():
        np.testing.assert_array_equal(found.columns[name], values)
    write_netcdf(RESULT, tmp_path / "two.nc", {"synthetic": "true", "seed": "7"})
    assert (tmp_path / "two.nc").read_bytes() == file.read_bytes()


def test_files_of_the_reference_library_are_read(tmp_path: Path) -> None:
    with netCDF4.Dataset(tmp_path / "old.nc", "w", format="NETCDF4") as data:
        data.createDimension("point", 3)
        for name, values in COLUMNS.items():
            variable = data.createVariable(name, "f8", ("point",), zlib=True, complevel=1, shuffle=True)
            variable.units = "1"
            variable[:] = values
        data.test_id, data.assumptions, data.summary = "old", "none", '{"area": 78.5}'
    found = read_netcdf(tmp_path / "old.nc")
    assert found is not None and (found.test_id, found.summary) == ("old", {"area": 78.5})
    for name, values in COLUMNS.items():
        np.testing.assert_array_equal(found.columns[name], values)


@pytest.mark.parametrize("kept", [0, 1, 7, 100, 2000])
def test_a_file_that_was_cut_is_none(kept: int, file: Path) -> None:
    content = file.read_bytes()
    assert kept < len(content)
    file.write_bytes(content[:kept])
    assert read_netcdf(file) is None
    assert read_netcdf(file.with_name("missing.nc")) is None


def test_a_damaged_byte_gives_a_result_or_none_but_no_other_error(file: Path) -> None:
    content = file.read_bytes()
    for place in np.random.default_rng(1).integers(0, len(content), 60):
        damaged = bytearray(content)
        damaged[place] ^= 0xFF
        file.write_bytes(damaged)
        read_netcdf(file)
