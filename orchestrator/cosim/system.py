"""The system that a user loads, checks, runs and exports."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Self

from friction_models.common import InputError, given_path
from friction_models.common.wording import kind_of
from friction_models.common.yaml_files import read_yaml

from .setup.description import SystemDescription
from .setup.wiring import Wiring
from .ssp_export import export_ssp
from .ssp_import import read_system

_ALLOWED = "a system description (.yaml) or an SSP archive (.ssp)"


class System(SystemDescription):
    """Components, connections, step and stop time of a co-simulation: read, checked, run by `Master`, exported.

    `SystemDescription` lists the attributes.

    Examples
    --------
    >>> system = System.from_dict({
    ...     "communication_step": 0.01, "stop_time": 0.5,
    ...     "components": {"friction": {"fmu": "friction.fmu"}, "forming": {"fmu": "fre.fmu"}},
    ...     "connections": ["forming.sigma_n -> friction.sigma_n", "friction.mu -> forming.mu"],
    ... })
    >>> system.steps, system.evaluation_order()
    (50, ['friction', 'forming'])
    >>> System.from_dict({"communication_step": 0.01, "stop_tim": 0.5})
    Traceback (most recent call last):
    friction_models.common.errors.InputError: ...
    """

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Read a YAML file, whose FMU paths are relative to it, or an SSP archive (``.ssp``).

        Raises
        ------
        InputError
            No such file, not YAML, unknown or missing keys, values out of range; all problems at once.
            What `read_system` refuses in an archive.
        """
        file = given_path(path, _ALLOWED)
        if file.is_dir():
            inside = sorted(p for p in file.iterdir() if p.suffix.lower() in {".yaml", ".ssp"})
            guess = f"; did you mean '{inside[0]}'?" if inside else ""
            raise InputError(f"{file}: is a folder; allowed: {_ALLOWED}{guess}")
        if file.suffix.lower() == ".ssp":
            unpacked, content = read_system(file)
            return cls.from_dict(content, unpacked.folder, str(file)).kept_with(unpacked)
        read = read_yaml(file, allowed=_ALLOWED)
        if read is None:
            raise InputError(f"{file}: the file is empty")
        if not isinstance(read, dict):
            raise InputError(f"{file}: holds {kind_of(read)}; allowed: a mapping")
        return cls.from_dict(read, file.resolve().parent, str(file))

    def validate(self) -> None:  # type: ignore[override]
        """Open every FMU and check the whole set-up.

        Raises
        ------
        InputError
            Lists all problems at once: names, units, lengths, unconnected inputs, unreadable FMUs.
        """
        Wiring.of(self)

    def export(self, path: str | os.PathLike[str], boundary: bool = False) -> Path:
        """Write the system and its FMUs as an SSP 1.0 archive; see `export_ssp`."""
        return export_ssp(self, path, boundary)
