"""Forces between bounds and beside estimates of the theory of plasticity, over twelve geometries.

Without friction and hardening a force lies between the ideal work of deformation and the upper bound of a velocity
field that can be: Avitzur's spheres in a conical die, the even stretching of a flat disc (whose upper bound is the slab
method's mean pressure). Siebel's formula for a rod with friction is an estimate.
"""

from __future__ import annotations

import math

from ..processes.upsetting import Upsetting
from .case import Case, Row, case, finished, published_flow_stress
from .extrusion import IsothermalRod
from .ring_closed_form import perfectly_plastic

GROUP = "Extrusion"
#: Flow stress of the material that does not harden [MPa], and constant friction far above any limit: tau = m k.
YIELD, STICKING = 500.0, 10.0
#: Rods without friction: exit diameter from 20 mm, half of the die's angle [degrees].
RODS = ((14.14, 30.0), (14.14, 45.0), (14.14, 60.0), (16.0, 30.0), (12.0, 45.0))
#: Rods of 16MnCr5 at mu 0.08, and how far Siebel's estimate may be off [%].
SIEBEL, ESTIMATE = ((14.14, 30.0), (14.14, 45.0), (16.0, 30.0)), 20.0
#: Discs: diameter and height [mm], m; the height that they lose, as a share.
DISCS, LOSS = ((20.0, 10.0, 0.2), (20.0, 5.0, 0.2), (30.0, 5.0, 0.3), (30.0, 5.0, 0.1)), 0.1
#: Stroke after which the rods have left the die, and how far on the mean of the force is taken [mm].
OUT, LENGTH = 7.0, 2.0
CASES: list[Case] = []


def ideal_work(D: float, d: float) -> float:
    """Return the force of an even reduction over the yield stress, A ln(A / a) [mm2]."""
    return 0.25 * math.pi * D * D * 2.0 * math.log(D / d)


def avitzur(D: float, d: float, half_angle: float) -> float:
    """Return the upper bound of the force of a frictionless extrusion over the yield stress [mm2].

    Spherical velocity field between two shear surfaces; Avitzur, Metal Forming: Processes and Analysis, 1968.
    """
    a = math.radians(half_angle)
    sine, cosine, c = math.sin(a), math.cos(a), 11.0 / 12.0
    root = math.sqrt(1.0 - c * sine * sine)
    logarithm = math.log((1.0 + math.sqrt(c)) / (math.sqrt(c) * cosine + root))
    f = (1.0 - cosine * root + logarithm / math.sqrt(132.0)) / (sine * sine)
    shear = 2.0 / math.sqrt(3.0) * (a / (sine * sine) - cosine / sine)
    return 0.25 * math.pi * D * D * (2.0 * f * math.log(D / d) + shear)


def siebel(D: float, d: float, half_angle: float, mu: float, container: float) -> float:
    """Return Siebel's force of a forward extrusion [kN], flow stresses at 20 degC and 10/s.

    F = A kfm phi (1 + 2 a / (3 phi) + 2 mu / sin 2a) + pi D L mu kf0; Lange, Umformtechnik 2. kfm is the mean over the
    strain, kf0 that at phi 0.02, and L = `container` the contact with the container [mm].
    """
    a, phi = math.radians(half_angle), 2.0 * math.log(D / d)
    mean = float(published_flow_stress([(k + 0.5) / 50.0 * phi for k in range(50)], 20.0, 10.0).mean())
    first = float(published_flow_stress(0.02, 20.0, 10.0))
    die = 0.25 * math.pi * D * D * mean * (phi + 2.0 / 3.0 * a + 2.0 * mu * phi / math.sin(2.0 * a))
    return 1e-3 * (die + math.pi * D * container * mu * first)


def disc(D: float, height: float, m: float) -> float:
    """Return the upper bound of the force on a disc over the yield stress, A (1 + 2 m R / (3 sqrt 3 h)) [mm2]."""
    return 0.25 * math.pi * D * D * (1.0 + m * D / (3.0 * math.sqrt(3.0) * height))


def between(what: str, low: float, high: float, source: str, ours: float) -> Row:
    """Return a row that passes between two forces [kN]."""
    middle = 0.5 * (low + high)
    words = f"{what}: between {low:.1f} and {high:.1f} kN"
    return Row(words, "kN", middle, source, ours, round(0.5 * (high - low), 1), absolute=True)


@case(CASES, "bounds-rods", GROUP, fast=False)
def rods_between_bounds() -> list[Row]:
    """Five rods without friction, 500 MPa without hardening, isothermal: steady force."""
    rows = []
    for d, angle in RODS:
        process = IsothermalRod(
            exit_diameter=d,
            half_angle=angle,
            mesh_size=0.5,
            material=perfectly_plastic(YIELD),
            tool_heating=False,
        )
        result = finished(process, process.run(0.0, OUT + LENGTH))
        low, high = 1e-3 * YIELD * ideal_work(20.0, d), 1e-3 * YIELD * avitzur(20.0, d, angle)
        force = float(result.force[result.stroke > OUT].mean())
        what = f"20 to {d:g} mm, half angle {angle:g} degrees"
        rows.append(between(what, low, high, "ideal work and Avitzur's upper bound", force))
    return rows


@case(CASES, "siebel-rods", GROUP, fast=False)
def rods_beside_siebel() -> list[Row]:
    """Three rods of 16MnCr5 at mu 0.08, isothermal: force at 7 to 9 mm."""
    rows = []
    for d, angle in SIEBEL:
        process = IsothermalRod(exit_diameter=d, half_angle=angle, mesh_size=0.5, tool_heating=False)
        result = finished(process, process.run(0.08, OUT + LENGTH))
        force = float(result.force[result.stroke > OUT].mean())
        # The billet was 30 mm long; what has gone through the die is missing in the container, and so is what fills the cone.
        cone = (10.0**3 - (0.5 * d) ** 3) / (3.0 * 100.0 * math.tan(math.radians(angle)))
        length = 30.0 - OUT - 0.5 * LENGTH - cone
        expected = siebel(20.0, d, angle, 0.08, length)
        what = f"20 to {d:g} mm, half angle {angle:g} degrees, mu 0.08"
        rows.append(Row(what, "kN", expected, "Siebel's formula, an estimate", force, ESTIMATE))
    return rows


@case(CASES, "bounds-discs", "Upsetting")
def discs_between_bounds() -> list[Row]:
    """Four discs, friction m k, 500 MPa without hardening."""
    rows = []
    for D, height, m in DISCS:
        process = Upsetting(
            diameter=D,
            height=height,
            mesh_size=height / 10.0,
            material=perfectly_plastic(YIELD),
            isothermal=True,
            shear_factor=m,
        )
        result = finished(process, process.run(STICKING, LOSS * height))
        left = 1.0 - LOSS
        grown, flat = D / math.sqrt(left), left * height
        low, high = (1e-3 * YIELD * disc(grown, flat, share) for share in (0.0, m))
        what = f"disc {D:g} x {height:g} mm, m {m:g}, at {100.0 * LOSS:g} % less height"
        source = "even pressure and upper bound of even stretching"
        rows.append(between(what, low, high, source, float(result.force[-1])))
    return rows
