"""The loads contract: which quantities describe a tribological contact, in which order and unit.

Every array, file, ONNX graph and FMU of the project derives names, units and limits from
`LOADS` and `MU`. Internally lengths are mm, times s, stresses MPa, temperatures degC.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Quantity:
    """One named physical quantity.

    Attributes
    ----------
    name : str
        Identifier in code, files and FMUs.
    unit : str
        Unit as written in files (``"1"`` for a number).
    meaning : str
        What it is, one phrase.
    lower, upper : float
        Physical limits (not the domain of any model).
    nominal : float
        A value inside every sensible model domain; start value of FMU inputs.

    Examples
    --------
    >>> from friction_models.loads import LOADS, MU
    >>> [f"{q.name} [{q.unit}]" for q in LOADS]
    ['v_rel [mm/s]', 'T [degC]', 'sigma_n [MPa]', 'sd [mm]', 'psi [1]']
    >>> MU.lower, MU.upper
    (0.0, 10.0)
    """

    name: str
    unit: str
    meaning: str
    lower: float
    upper: float
    nominal: float


LOADS: tuple[Quantity, ...] = (
    Quantity("v_rel", "mm/s", "relative sliding speed", 0.0, 1e5, 50.0),
    Quantity("T", "degC", "contact temperature, mean of the two surfaces", -273.15, 2000.0, 80.0),
    Quantity("sigma_n", "MPa", "contact normal pressure", 0.0, 1e5, 1000.0),
    Quantity("sd", "mm", "sliding distance of the workpiece point", 0.0, 1e9, 10.0),
    Quantity("psi", "1", "local surface expansion dA/dA0", 1e-3, 1e3, 1.2),
)
MU = Quantity("mu", "1", "coefficient of friction", 0.0, 10.0, 0.08)
#: mu as measured: an offset of the force cell of 0.01 at 2000 MPa makes 0.4 at 50 MPa, also below 0.
MEASURED_MU = replace(MU, lower=-0.4)
TIME = Quantity("t", "s", "time since the start of the test", 0.0, 1e7, 0.0)

#: Columns of a table of points that hold the standard uncertainty of a load, by the load.
UNCERTAINTY_COLUMNS: dict[str, str] = {"sigma_n": "u_sigma_n", "psi": "u_psi", "T": "u_T"}
LOAD_NAMES: tuple[str, ...] = tuple(q.name for q in LOADS)
#: Columns of a time-series data set, in file order.
POINT_COLUMNS: tuple[str, ...] = ("test_id", TIME.name, *LOAD_NAMES, MU.name)
#: The column of a table of tests that numbers them as they were run.
ORDER = "order"
#: Units of the columns of points; `test_id` has none.
POINT_UNITS: dict[str, str] = {q.name: q.unit for q in (TIME, *LOADS, MU)}
#: Units of standard uncertainties of the loads: differences, so that degC counts as K.
UNCERTAINTY_UNITS: dict[str, str] = {"u_sigma_n": "MPa", "u_psi": "1", "u_T": "K"}
#: Units of what tests are set to, in plans, test tables and tables of press levels.
SETTING_UNITS: dict[str, str] = {
    **dict.fromkeys(("T_tool", "T_specimen"), "degC"),
    **dict.fromkeys(("sigma_set", "sigma_end", "sigma_levels"), "MPa"),
    **dict.fromkeys(("v_set", "v_levels", "v_slide", "speed"), "mm/s"),
    **dict.fromkeys(
        ("sd_set", "hold_at", "bore", "tip", "tip_height", "specimen_diameter", "specimen_height"), "mm"
    ),
    **dict.fromkeys(("hold", "ramp", "t_wait", "zero_reading", "t_upsetting", "t_sliding", "t_end"), "s"),
    **dict.fromkeys(("F_set", "F_n"), "N"),
    **dict.fromkeys(("psi_set",), "1"),
}
#: What sets a load, among these.
SET_BY: dict[str, str] = {"v_rel": "v_set", "T": "T_tool", "sigma_n": "sigma_set"}
QUANTITIES: dict[str, Quantity] = {q.name: q for q in (TIME, *LOADS, MU)}


def with_unit(name: str) -> str:
    """Return the name of a load with its unit, ``v_rel [mm/s]``; other names unchanged.

    Examples
    --------
    >>> with_unit("v_rel"), with_unit("psi"), with_unit("batch")
    ('v_rel [mm/s]', 'psi', 'batch')
    """
    unit = next((q.unit for q in LOADS if q.name == name), "1")
    return name if unit == "1" else f"{name} [{unit}]"


def behind(unit: str) -> str:
    """Return a unit as it stands behind a value in a sentence; nothing for a number.

    Examples
    --------
    >>> f"12{behind('mm')}", f"0.08{behind('1')}"
    ('12 mm', '0.08')
    """
    return "" if unit == "1" else f" {unit}"
