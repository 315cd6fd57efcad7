"""Upsetting in the virtual laboratory: finer mesh, another material and friction than the twin assumes.

The contact is computed once for each specimen shape at two tool temperatures and interpolated over
force and temperature; results are kept in a cache folder, keyed by everything that they depend on.
"""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

import forming
from forming.material import HenselSpittel, steel_16MnCr5
from forming.upsetting import PunchGeometry, UpsettingResult
from friction_models.loads import FloatArray, atomic_path

from ..contact_temperature import ThermalBody, ThermalSettings
from ..upsetting import ContactState, robust_upset

#: Thermal grid and material data that hold in the laboratory.
FINE = ThermalSettings(
    cells=36,
    surface_layer=0.035,
    growth=1.2,
    depth=14.0,
    heat_transfer=33.0,
    plate=ThermalBody(20.4, 3.50),
    specimen=ThermalBody(41.2, 3.72),
)


@dataclass(frozen=True)
class Rig:
    """The laboratory's reality, unknown to the twin.

    Attributes
    ----------
    mesh_size : float
        Elements of the upsetting run [mm].
    flow_stress : float
        True flow stress over the one in the tables.
    flow_stress_scatter : float
        Standard deviation between specimens.
    upsetting_mu : float
        Friction while upsetting.
    ram_speed : float
        Punch speed [mm/s].
    compliance : float
        Elastic give of the machine [mm/N].
    thermal : ThermalSettings
        Finer grid, other conductivities, capacities and interface heat transfer.
    """

    mesh_size: float = 0.45
    flow_stress: float = 1.015
    flow_stress_scatter: float = 0.006
    upsetting_mu: float = 0.07
    ram_speed: float = 10.0
    compliance: float = 1.2e-6
    thermal: ThermalSettings = field(default_factory=lambda: FINE)

    @property
    def material(self) -> HenselSpittel:
        """True workpiece material."""
        nominal = steel_16MnCr5()
        return replace(nominal, A=nominal.A * self.flow_stress, m2=nominal.m2 * 1.01, name="16MnCr5, virtual")


#: Tool temperatures at which upsetting is computed [degC].
TEMPERATURES = (20.0, 300.0)


@dataclass(frozen=True, eq=False)
class SpecimenTable:
    """Upsetting of one specimen shape, at the two tool temperatures of `TEMPERATURES`."""

    runs: tuple[UpsettingResult, UpsettingResult]
    m1: float

    def _parts(self, T_tool: float, flow_stress: float) -> list[tuple[UpsettingResult, float, float, float]]:
        """Return (run, its temperature, its weight, force scale): both are read where they are loaded equally.

        The flow stress goes with exp(m1 T) and with the specimen's own factor.
        """
        low, high = TEMPERATURES
        upper = float(np.clip((T_tool - low) / (high - low), 0.0, 1.0))
        return [
            (run, level, weight, float(np.exp(self.m1 * (level - T_tool))) / flow_stress)
            for run, level, weight in zip(self.runs, TEMPERATURES, (1.0 - upper, upper))
        ]

    def stroke(self, force: FloatArray, T_tool: float, flow_stress: float) -> FloatArray:
        """Return the loss of height [mm] at forces [N]."""
        total = np.zeros(len(force))
        for run, _, weight, scale in self._parts(T_tool, flow_stress):
            known = np.maximum.accumulate(run.force)
            total += weight * np.interp(force * scale, known, run.height[0] - run.height)
        return np.asarray(np.maximum.accumulate(total))

    def state(self, force: float, T_tool: float, flow_stress: float) -> ContactState:
        """Return the contact at the end of upsetting to a force [N]."""
        parts = [
            (ContactState.from_result(run, min(force * scale, float(run.force.max())), level), level, weight)
            for run, level, weight, scale in self._parts(T_tool, flow_stress)
        ]

        def blend(name: str) -> Any:
            return sum(weight * getattr(state, name) for state, _, weight in parts)

        area = float(blend("area"))
        return ContactState(
            force=force,
            area=area,
            radius=float(np.sqrt(area / np.pi)),
            height=float(blend("height")),
            psi=float(blend("psi")),
            T_specimen=T_tool + sum(weight * (state.T_specimen - level) for state, level, weight in parts),
            radius_fraction=parts[0][0].radius_fraction,
            pressure=blend("pressure"),
        )


def compute_run(
    punch: PunchGeometry, T_tool: float, force: float, rig: Rig, cache: str | None
) -> UpsettingResult:
    """Return one upsetting run up to `force` [N], from the cache where it is known."""
    arguments: dict[str, Any] = {
        "material": rig.material,
        "mu": rig.upsetting_mu,
        "T0": T_tool,
        "T_tool": T_tool,
        "speed": rig.ram_speed,
    }
    folder = Path(cache) if cache else cache_folder()
    key = hashlib.sha256(
        (repr((punch, force, rig.mesh_size, sorted(arguments.items()))) + solver_fingerprint()).encode()
    ).hexdigest()[:24]
    file = folder / f"upsetting-{key}.npz"
    names = [f.name for f in fields(UpsettingResult)]
    if file.is_file():
        try:
            with np.load(file, allow_pickle=False) as stored:
                values: dict[str, Any] = {name: stored[name] for name in names}
            values |= {name: str(values[name]) for name in ("status", "message")}
            return UpsettingResult(**values)
        except (OSError, ValueError, KeyError):
            file.unlink(missing_ok=True)
    run = robust_upset(punch, force, rig.mesh_size, "virtual laboratory", **arguments)
    try:
        with atomic_path(file) as temporary, temporary.open("wb") as stream:
            np.savez(stream, **{n: np.asarray(getattr(run, n)) for n in names})  # type: ignore[arg-type]
    except OSError:
        return run  # a read-only home folder costs time, nothing else
    return run


def cache_folder() -> Path:
    """Return the user's cache folder of the project."""
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "tribofmu"


def solver_fingerprint() -> str:
    """Return a fingerprint of the solver: its results are only as good as its code was."""
    digest = hashlib.sha256()
    for file in sorted(Path(str(forming.__file__)).parent.rglob("*.py")):
        if file.name not in {"fre.py", "press.py", "__init__.py"}:
            digest.update(file.read_bytes())
    return digest.hexdigest()
