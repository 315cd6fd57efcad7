"""Differences between the virtual laboratory and what the twin assumes, as written to `campaign.json`."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from ..twin.contact_temperature import ThermalSettings
from .rig.instruments import Instruments
from .rig.specimen import Rig


def perturbations(rig: Rig, instruments: Instruments) -> dict[str, Any]:
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
