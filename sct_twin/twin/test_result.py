"""Result of one test: time series of loads and friction, stored as netCDF."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from friction_models.common import InputError, atomic_path
from friction_models.common.netcdf_files import read_numbers
from friction_models.loads import POINT_UNITS, FloatArray

from ..records.cells import Cell

#: Columns beyond the contract's, with units.
EXTRA_UNITS = {
    "T_max": "degC",
    "T_plate_surface": "degC",
    "T_specimen_surface": "degC",
    "T_film": "degC",
    "F_n": "N",
    "F_r": "N",
    "mu_std": "1",
    "u_sigma_n": "MPa",
    "u_psi": "1",
    "u_T": "K",
}

#: Stated with every result. The sizes are the largest of seven tests of a virtual campaign (docs/sct-twin.md);
#: `sct_twin.twin.error_study.check` computes those of the campaign at hand.
ASSUMPTIONS = (
    "contact pressure and surface expansion keep their shape from the end of upsetting on while the specimen "
    "slides (heating evenly instead changes T by up to 1.3 % of its rise, T_max by 6 %); area and "
    "expansion belong to the highest force so far (where the force exceeds that of upsetting by more than 2 % "
    "they grow with it, the heated circle does not); shear by friction does not redistribute the pressure "
    "(column sigma_n_shear of the tests: by which share sigma_n may be lower for that, by von "
    "Mises; 0 where the bore is filled)",
    "psi is the area-weighted contact mean of the local surface expansion dA/dA0, by area as it is now, not the area "
    "ratio of the plan",
    "T is the area-weighted contact mean of the mean of both surface temperatures; the middle of the film, in which all "
    "friction heat q is taken to be released, is hotter by q / (4 h) (column T_film)",
    "u_sigma_n, u_psi and u_T are standard uncertainties by the setting `uncertainty`, nearly all of it common to the "
    "points of a test; that of the force cell is not in u_sigma_n",
    "all friction work (measured F_r times distance) becomes heat at the interface; the sides of specimen and "
    "plate lose none (at most 2 % of the work in tests of 11 s, less in faster ones)",
    "one interface heat transfer coefficient for sliding and rest; heat data of plate and specimen by the "
    "material files, with their dependence on temperature (half or twice the coefficient: up to +12 or -7 % "
    "of the rise; heat data of 20 degC: up to +3.9 %)",
    "fresh plate enters at the temperature measured before sliding; the punch stays at tool temperature",
    "the specimen starts with the heat of upsetting, evenly spread: the work of the punch less what is elastic, times the "
    "share that becomes heat; it conducts for as long as that heat has been there on average, then for the wait",
    "friction while upsetting is a parameter of the twin, as no sensor sees it (0.03 more or less: up to 3.0 % of "
    "sigma_n, 6 % of psi where the bore is not filled and the contact not measured)",
    "the flow curve is that of the material file (2 % more flow stress: up to 1.4 % of sigma_n where the bore is "
    "not filled and the contact not measured)",
    "where the diameter of the contact was measured after the test (column contact_diameter) and the bore is not "
    "filled, sigma_n is the force over that area, and what differs in flow stress and friction while upsetting is "
    "taken for a factor on the flow stress (column flow_stress_ratio); a reading 0.05 mm off changes sigma_n by up to "
    "0.7 %, psi by 0.3 %, T by 0.5 % of its rise",
)


@dataclass(frozen=True, eq=False)
class TestResult:
    """Loads and friction of one test at equal distances.

    >>> columns = {"sd": np.array([0.0, 0.1]), "mu": np.array([0.08, 0.07])}
    >>> TestResult("sct001", columns).points().values.tolist()
    [['sct001', 0.0, 0.08], ['sct001', 0.1, 0.07]]
    """

    test_id: str
    #: `t, v_rel, T, sigma_n, sd, psi, mu` and the columns of `EXTRA_UNITS`, shape (n,).
    columns: Mapping[str, FloatArray]
    #: One value a test: contact area, heights, zeros, masses, fingerprint of inputs and settings.
    summary: Mapping[str, Cell] = field(default_factory=dict)

    def points(self) -> pd.DataFrame:
        """Return one row a point, `test_id` first."""
        frame = pd.DataFrame(dict(self.columns))
        frame.insert(0, "test_id", self.test_id)
        return frame


def write_netcdf(result: TestResult, path: Path, attributes: Mapping[str, str]) -> None:
    """Write one test, atomically; numbers as float64 over the dimension `point`."""
    import h5netcdf

    units = {**POINT_UNITS, **EXTRA_UNITS}
    packed = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
    with atomic_path(path) as temporary, h5netcdf.File(temporary, "w") as file:
        file.dimensions = {"point": len(result.columns["t"])}
        for name, values in result.columns.items():
            variable = file.create_variable(
                name, ("point",), "f8", data=np.asarray(values, dtype=np.float64), **packed
            )
            variable.attrs["units"] = units.get(name, "1")
        about = {"test_id": result.test_id, "assumptions": "; ".join(ASSUMPTIONS)}
        about["summary"] = json.dumps(dict(result.summary))
        file.attrs.update(about | dict(attributes))


def read_netcdf(path: Path) -> TestResult | None:
    """Read one test; None when the file is missing or damaged."""
    if not path.is_file():
        return None
    try:
        found = read_numbers(path)
        return TestResult(found.attributes["test_id"], found.values, json.loads(found.attributes["summary"]))
    except (InputError, KeyError, ValueError):
        return None
