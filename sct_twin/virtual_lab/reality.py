"""What `campaign.json` of a virtual campaign says of units and of what differs between the laboratory and the twin."""

from __future__ import annotations

from dataclasses import asdict

from ..twin.contact_temperature import ThermalSettings
from .rig.instruments import Instruments
from .rig.specimen import Rig

#: Units of the columns of the test table.
UNITS = {
    "sigma_set": "MPa",
    "v_set": "mm/s",
    "T_tool": "degC",
    "T_specimen": "degC",
    "Ra": "um",
    "t_wait": "s",
    "sd_set": "mm",
    "bore": "mm",
    "tip": "mm",
    "F_set": "N",
    "specimen_diameter": "mm",
    "specimen_height": "mm",
    "contact_diameter": "mm",
    "sigma_end": "MPa",
    "sigma_levels": "MPa",
    "v_levels": "mm/s",
    "hold_at": "mm",
    "hold": "s",
    "zero_reading": "s",
}


def perturbations(rig: Rig, instruments: Instruments) -> dict[str, object]:
    """Return what is otherwise in the laboratory: mesh, material, upsetting, heat, scatter, sensors.

    The truth is computed with these, never with the settings of the twin; friction is not among them.
    """
    material, here, usual = rig.material, asdict(rig.thermal), asdict(ThermalSettings())
    return {
        "note": "the truth is computed with these instead of the settings of the twin",
        "upsetting_mesh_mm": rig.mesh_size,
        "flow_stress_factor": rig.flow_stress,
        "flow_stress_exponent_factor": rig.flow_exponent,
        "flow_stress_scatter": rig.flow_stress_scatter,
        "specimen_scatter_mm": {"diameter": rig.diameter_scatter, "height": rig.height_scatter},
        "material": material.name,
        "ram_speed_mm_s": rig.ram_speed,
        "compliance_mm_per_N": rig.compliance,
        "thermal": {name: {"laboratory": here[name], "twin": usual[name]} for name in here},
        "sensors": asdict(instruments),
    }
