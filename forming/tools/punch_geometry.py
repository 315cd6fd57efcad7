"""Specimen and punch of the upsetting stage of a sliding compression test."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from friction_models.common import InputError
from friction_models.common.ranges import check_range

from ..fe.mesh.shape import FloatArray


@dataclass(frozen=True)
class PunchGeometry:
    """Specimen and punch of the upsetting stage.

    With a bore the specimen stands in a cup that moves with the punch and reaches the plate, so the
    contact cannot grow beyond the bore. With a tip the specimen's lower end tapers to a first contact
    of `tip_diameter`. The geometry of the real rig is not published; these are parameters.

    Parameters
    ----------
    specimen_diameter, specimen_height : float
        Cylinder before the test [mm].
    bore_diameter : float or None
        Bore of the cup [mm]; None: a free flat punch.
    tip_diameter : float or None
        Diameter of the first contact [mm]; None: the whole end face.
    tip_height : float
        Axial length of the taper [mm].

    Raises
    ------
    InputError
        Dimensions that cannot be built.

    Examples
    --------
    A specimen whose first contact is a circle of 10 mm, 25 pi mm2:

    >>> from forming import PunchGeometry
    >>> punch = PunchGeometry(specimen_diameter=20.0, specimen_height=20.0, tip_diameter=10.0)
    >>> round(punch.first_contact_area, 3)
    78.54
    >>> punch.outline().tolist()
    [[0.0, 0.0], [5.0, 0.0], [10.0, 2.5], [10.0, 20.0], [0.0, 20.0]]
    >>> PunchGeometry(specimen_diameter=15.0, bore_diameter=14.0)
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: punch: bore_diameter = 14.0 mm; allowed: above the specimen diameter 15 mm, below 30 mm
    """

    specimen_diameter: float = 15.0
    specimen_height: float = 15.0
    bore_diameter: float | None = None
    tip_diameter: float | None = None
    tip_height: float = 2.5

    def __post_init__(self) -> None:
        for name in ("specimen_diameter", "specimen_height", "tip_height"):
            check_range("punch", name, getattr(self, name), 0.01, 1e4, "mm")
        for name in ("bore_diameter", "tip_diameter"):
            if getattr(self, name) is not None:
                check_range("punch", name, getattr(self, name), 0.0, 1e4, "mm")
        d0, bore, tip = self.specimen_diameter, self.bore_diameter, self.tip_diameter
        if bore is not None and not d0 < bore < 2.0 * d0:
            raise InputError(
                f"punch: bore_diameter = {bore!r} mm; allowed: above the specimen diameter {d0:g} mm, "
                f"below {2.0 * d0:g} mm"
            )
        if tip is not None and not 0.1 * d0 <= tip < d0:
            raise InputError(f"punch: tip_diameter = {tip!r} mm; allowed: {0.1 * d0:g} mm to below {d0:g} mm")
        # Without a tip the default has no say; another height was given, and is looked at.
        if tip is None and self.tip_height == PunchGeometry.tip_height:
            return
        if self.tip_height >= 0.5 * self.specimen_height:
            raise InputError(
                f"punch: tip_height = {self.tip_height!r} mm; allowed: below half the specimen height "
                f"{0.5 * self.specimen_height:g} mm"
            )

    @property
    def first_contact_area(self) -> float:
        """Area of the undeformed lower face [mm2]."""
        return 0.25 * math.pi * (self.tip_diameter or self.specimen_diameter) ** 2

    def outline(self) -> FloatArray:
        """Return the corners of the specimen's surface, from the lower to the upper axis point."""
        radius, height = 0.5 * self.specimen_diameter, self.specimen_height
        corners = [(0.0, 0.0)]
        if self.tip_diameter is not None:
            corners += [(0.5 * self.tip_diameter, 0.0), (radius, self.tip_height)]
        else:
            corners += [(radius, 0.0)]
        return np.array([*corners, (radius, height), (0.0, height)])
