"""What was filled into the form of the page Forming, and the command line that follows from it."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass, field
from types import NoneType
from typing import TYPE_CHECKING, Any

from friction_models.common import InputError

from .. import commands
from ..commands import Command
from ..project import is_name
from .compare import CONSTANTS

if TYPE_CHECKING:
    from forming.processes.parameters import Parameter

#: What differs from level to level, and by that has fields of its own.
LEVEL = ("speed", "T_tool")


@dataclass
class FormState:
    """What was filled in; `values` are the parameters that differ from the defaults, as they were typed."""

    process: str = "fre"
    models: list[str] = field(default_factory=list)
    constants: str = CONSTANTS[1]
    values: dict[str, float | str] = field(default_factory=dict)
    levels: dict[str, str] = field(default_factory=dict)
    stroke: float | None = None
    press: str = ""
    local_errors: bool = False
    name: str = ""

    @classmethod
    def of(cls, kept: Mapping[str, Any], known: Container[str]) -> FormState | None:
        """Return the form as it was left; None where nothing was kept, or something else than a form.

        Examples
        --------
        >>> FormState.of({"process": "fre", "stroke": 6.0}, ["fre"]).stroke
        6.0
        >>> FormState.of({"process": "fre", "stroke": "far"}, ["fre"]) is None
        True
        """
        kinds: dict[str, type | tuple[type, ...]] = {
            "process": str, "models": list, "constants": str, "values": dict, "levels": dict,
            "stroke": (int, float, NoneType), "press": str, "local_errors": bool, "name": str,
        }  # fmt: skip
        if kept.get("process") not in known or not all(
            n in kinds and isinstance(v, kinds[n]) for n, v in kept.items()
        ):
            return None
        texts = [*kept.get("models", []), *kept.get("levels", {}).values()]
        values = kept.get("values", {}).values()
        numbers = [kept.get("stroke") or 0.0, *(v for v in values if not isinstance(v, str))]
        if not all(isinstance(v, int | float) and abs(v) < 1e300 for v in numbers):
            return None
        # What a file names goes into command lines.
        plain = all(is_name(v) for v in values if isinstance(v, str))
        if not plain or not all(isinstance(t, str) for t in texts):
            return None
        return cls(**kept)

    def given(self) -> dict[str, float | str]:
        """Return the parameters that were filled in."""
        return {n: v for n, v in self.values.items() if v != ""}

    def declared(self) -> dict[str, Parameter]:
        """Return the parameters that the process declares; raises InputError for a value that it refuses."""
        from forming.processes.parameters import declared

        return {n: p for n, p in declared(self.process, self.given()).items() if p.kind != "ejection"}

    def command(self) -> Command:
        """Return the command line of the form; raises InputError for what the process or the command would refuse."""
        from ...comparison.in_process import FormingPlan

        levels = [_numbers(self.levels[n], n) if n in self.levels else [] for n in LEVEL]
        known = self.declared()
        speeds, temperatures = (
            found or [float(known[name].default or 0.0)] for found, name in zip(levels, LEVEL, strict=True)
        )
        constants = constants_of(self.constants)
        models = [*self.models, *constants]
        if not models:
            raise InputError(
                "Choose at least one friction model, or give a constant coefficient of friction."
            )
        pairs = [{"speed": s, "T_tool": t} for s in speeds for t in temperatures]
        plan = FormingPlan(self.process, self.given(), pairs, self.stroke)
        for pair in pairs:
            plan.longest(pair)
        if self.press and len(pairs) > 1:
            raise InputError("A press curve is that of one level: give one speed and one tool temperature.")
        values = {n: _written(v) for n, v in self.given().items()}
        return commands.forming.form(
            self.process,
            models,
            values,
            speeds,
            temperatures,
            self.stroke,
            self.press,
            self.local_errors,
            self.name,
        )


def _written(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else f"{value:g}" if isinstance(value, float) else str(value)  # fmt: skip


def _numbers(text: str, name: str) -> list[float]:
    """Return numbers that stand between commas."""
    found = []
    for part in text.replace(";", ",").split(","):
        if not part.strip():
            continue
        try:
            found.append(float(part))
        except ValueError:
            raise InputError(f"{name}: {part.strip()[:40]!r}; allowed: numbers, several by commas") from None
    return found


def constants_of(text: str) -> list[str]:
    """Return constant coefficients of friction that stand between commas."""
    found = _numbers(text, "constant mu")
    for value in found:
        if not 0.0 <= value <= 1.0:
            raise InputError(f"constant mu = {value:g}; allowed: 0 to 1")
    return [f"{value:g}" for value in dict.fromkeys(found)]
