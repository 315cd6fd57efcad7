"""Bounds of the forces: their formulas against integrals, and forces beyond them are found."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from forming.verification import bounds


@pytest.mark.parametrize("angle", [5.0, 30.0, 60.0])
def test_avitzur_is_the_power_of_the_spherical_field(angle):
    """Cone between two spheres: v = -v1 (r1 / r)^2 cos(theta); strain rates and the jump at both spheres, integrated here."""
    D, d, a = 20.0, 14.0, math.radians(angle)
    outer, inner = 0.5 * D / math.sin(a), 0.5 * d / math.sin(a)

    def rate(r, theta):
        v = math.cos(theta) / r**3
        along, shear = 2.0 * v, 0.5 * math.sin(theta) / r**3
        # e_rr = -2 e_tt = -2 e_pp, and e_rt from the change of v over the angle.
        return math.sqrt(2.0 / 3.0 * (1.5 * along**2 + 2.0 * shear**2))

    inside = quad(
        lambda t: quad(lambda r: rate(r, t) * 2.0 * math.pi * r * r * math.sin(t), inner, outer)[0], 0.0, a
    )[0]
    # On each sphere the velocity turns by v sin(theta); k = 1 / sqrt 3.
    jump = quad(lambda t: 2.0 * math.pi * math.sin(t) ** 2, 0.0, a)[0] * 2.0 / math.sqrt(3.0)
    flow = quad(lambda t: 2.0 * math.pi * math.cos(t) * math.sin(t), 0.0, a)[0]
    expected = (inside + jump) / flow * 0.25 * math.pi * D * D
    assert bounds.avitzur(D, d, angle) == pytest.approx(expected, rel=1e-5)
    assert bounds.avitzur(D, d, angle) > bounds.ideal_work(D, d)


def test_the_bound_of_a_disc_is_the_power_of_even_stretching():
    """Y v A, and m k v r / (2 h) over both faces."""
    D, h, m = 30.0, 5.0, 0.3
    r = np.linspace(0.0, 0.5 * D, 2001)
    faces = 2.0 * np.trapezoid(m / math.sqrt(3.0) * r / (2.0 * h) * 2.0 * math.pi * r, r)
    assert bounds.disc(D, h, m) == pytest.approx(0.25 * math.pi * D * D + faces, rel=1e-6)


@pytest.mark.nightly
def test_forces_beyond_a_bound_are_found(monkeypatch):
    """Discs lie in the upper half between their bounds; a tenth more or less flow stress leaves them."""
    monkeypatch.setattr(bounds, "DISCS", bounds.DISCS[:1])
    assert [row.verdict for row in bounds.discs_between_bounds()] == ["pass"]
    honest = bounds.perfectly_plastic
    for share in (1.1, 0.9):
        monkeypatch.setattr(bounds, "perfectly_plastic", lambda stress, share=share: honest(share * stress))
        assert [row.verdict for row in bounds.discs_between_bounds()] == ["fail"]
