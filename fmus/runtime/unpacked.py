"""An unpacked FMU with its variables by name, the sizes of its arrays, and its five loads and mu."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from friction_models.common import InputError, unknown_name
from friction_models.loads import LOADS, MU

from ..archive.content import unpack
from ..interface.quantities import vector
from .c_interface.slave import library_in
from .fmu_files import read_model

#: Most values of one array variable.
MAX_LENGTH = 1_000_000


class UnpackedFmu:
    """An FMU unpacked into a temporary folder that lives as long as this object.

    Parameters
    ----------
    path : path-like
    folder : Path, optional
        Where somebody else has unpacked it already.

    Attributes
    ----------
    path, folder : Path
    version : {"2.0", "3.0"}
    description : fmpy.model_description.ModelDescription
    variables : dict of str to fmpy's ModelVariable
        By full name.
    sizing : str or None
        The structural parameter that gives the loads their length (FMI 3.0).

    Raises
    ------
    InputError
        What `read_model` refuses.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from fmus import pack
    >>> from friction_models import ConstantFriction
    >>> with TemporaryDirectory() as place:
    ...     fmu = UnpackedFmu(pack(ConstantFriction(mu=0.1), Path(place) / "law.fmu", target="python", nodes=2))
    ...     fmu.length("mu[1]"), fmu.unit("sigma_n[1]"), fmu.friction()["mu"]
    (1, 'MPa', ['mu[1]', 'mu[2]'])
    """

    def __init__(self, path: str | Path, folder: Path | None = None) -> None:
        self.path = Path(path)
        root, self.description = read_model(self.path)
        self.version = "2.0" if self.description.fmiVersion == "2.0" else "3.0"
        if folder is None:
            self._temporary = tempfile.TemporaryDirectory(prefix="tribofmu-", ignore_cleanup_errors=True)
            folder = unpack(self.path, self._temporary.name)
        self.folder = folder
        self.variables: dict[str, Any] = {v.name: v for v in self.description.modelVariables}
        # fmpy leaves out some attributes of FMI 3.0.
        interface = root.find("CoSimulation")
        self._flags = {} if interface is None else dict(interface.attrib)
        self._limits = {
            str(v.get("name")): (v.get("min"), v.get("max")) for v in root.iterfind("ModelVariables/*")
        }
        self._by_reference = {v.valueReference: v for v in self.description.modelVariables}
        self.sizing = self._sizing()

    @property
    def real(self) -> str:
        """Name of the type of floating-point variables."""
        return "Real" if self.version == "2.0" else "Float64"

    def claims(self, capability: str) -> bool:
        """Whether the co-simulation interface claims a capability, by the name of either version."""
        wanted = capability.lower().removesuffix("s")
        return any(
            name.lower().removesuffix("s") == wanted and value in {"true", "1"}
            for name, value in self._flags.items()
        )

    def limits(self, name: str) -> tuple[int, int | None]:
        """Return the smallest and the largest value of an integer variable, None without a limit."""
        lower, upper = self._limits.get(name, (None, None))
        try:
            return int(lower or 0), None if upper is None else int(upper)
        except ValueError:
            raise InputError(f"{self.path}: a limit of variable {name!r} is no whole number") from None

    def is_structural(self, name: str) -> bool:
        """Whether a variable is a structural parameter, which sizes arrays."""
        return name in self.variables and self.variables[name].causality == "structuralParameter"

    def _sizing(self) -> str | None:
        first = self.variables.get(LOADS[0].name)
        if first is None or len(first.dimensions) != 1:
            return None
        return self._parameter(first.dimensions[0])

    def _parameter(self, dimension: Any) -> str | None:
        """Return the name of the variable that a dimension refers to, None for a number."""
        if dimension.valueReference is None:
            return None
        found = self._by_reference.get(int(dimension.valueReference))
        if found is None or found.causality != "structuralParameter":
            raise InputError(
                f"{self.path}: a dimension refers to value reference {dimension.valueReference}, allowed: that of a "
                "structural parameter"
            )
        return str(found.name)

    def length(self, name: str, sizes: Mapping[str, int] | None = None) -> int:
        """Return the number of values of a variable.

        Parameters
        ----------
        name : str
        sizes : mapping of str to int, optional
            Structural parameters that differ from their start value.

        Raises
        ------
        InputError
            A size that is no number, or too large.
        """
        length = 1
        for dimension in self.variables[name].dimensions:
            parameter = self._parameter(dimension)
            try:
                if parameter is None:
                    length *= int(dimension.start)
                else:
                    length *= int((sizes or {}).get(parameter, self.variables[parameter].start))
            except (TypeError, ValueError):
                raise InputError(
                    f"{self.path}: variable {name!r} has a dimension that is no number"
                ) from None
        if not 0 <= length <= MAX_LENGTH:
            raise InputError(
                f"{self.path}: variable {name!r} has {length} values, allowed: 0 to {MAX_LENGTH}"
            )
        return length

    def elements(self, name: str) -> list[str]:
        """Return the names of the variables that make up `name`: scalars in order, or one array.

        Raises
        ------
        InputError
            No such variable; with the nearest one.
        """
        found = vector(list(self.variables), name)
        if not found:
            raise unknown_name(
                "variable", name, {n.partition("[")[0] for n in self.variables}, str(self.path)
            )
        return found

    def unit(self, name: str) -> str:
        """Return the unit of a variable, empty without one."""
        variable = self.variables[name]
        declared = variable.declaredType
        return str(variable.unit or (declared.unit if declared is not None else None) or "")

    def is_friction(self) -> bool:
        """Whether there are inputs and an output with the names of the loads and of mu."""
        names = {n.partition("[")[0] for n in self.variables}
        if not {q.name for q in (*LOADS, MU)} <= names:
            return False
        return all(
            self.variables[self.elements(q.name)[0]].causality == ("output" if q is MU else "input")
            for q in (*LOADS, MU)
        )

    def friction(self) -> dict[str, list[str]]:
        """Return the names of the variables of the five loads and of mu, checked as a friction FMU.

        Raises
        ------
        InputError
            A variable is missing, is not an input or output, has another type, unit or number of points.
        """
        found: dict[str, list[str]] = {}
        for quantity in (*LOADS, MU):
            names = self.elements(quantity.name)
            first = self.variables[names[0]]
            wanted = "output" if quantity is MU else "input"
            if first.causality != wanted:
                raise InputError(
                    f"{self.path}: variable {names[0]!r} is a {first.causality}, allowed: {wanted}"
                )
            if first.type != self.real:
                raise InputError(
                    f"{self.path}: variable {names[0]!r} is of type {first.type}, allowed: {self.real}"
                )
            unit = self.unit(names[0])
            if unit not in {quantity.unit, "", "-" if quantity.unit == "1" else ""}:
                raise InputError(
                    f"{self.path}: variable {names[0]!r} has unit {unit!r}, allowed: {quantity.unit!r}"
                )
            found[quantity.name] = names
            count, expected = self._points(names), self._points(found["v_rel"])
            if count != expected:
                raise InputError(
                    f"{self.path}: {count} points of {quantity.name!r} and {expected} of 'v_rel', "
                    "allowed: equally many"
                )
        return found

    def _points(self, names: list[str]) -> int:
        return sum(self.length(n) for n in names)

    def library(self) -> Path:
        """Return the path of the library for this machine; it may not exist."""
        return library_in(self.folder, self.description)
