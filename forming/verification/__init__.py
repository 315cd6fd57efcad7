"""Verification of the forming simulation against closed forms, bounds and CalculiX."""

from __future__ import annotations

from . import bounds, contact_heating, extrusion, heat, local_loads, ring, upsetting
from .case import VERDICTS, Case, CaseResult, Outcome, Row, Unfinished, Verdict

#: All cases of this package.
CASES: tuple[Case, ...] = (
    *upsetting.CASES,
    *ring.CASES,
    *extrusion.CASES,
    *bounds.CASES,
    *heat.CASES,
    *contact_heating.CASES,
    *local_loads.CASES,
)

__all__ = ["CASES", "VERDICTS", "Case", "CaseResult", "Outcome", "Row", "Unfinished", "Verdict"]
