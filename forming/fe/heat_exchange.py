"""Heat of an increment: plastic work and friction, conduction, exchange with tools and environment."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .body import Body, WorkpieceMaterial
from .contact import FACING, GAP, PRESSURE, SHEAR, SLIP
from .heat.properties import integral
from .heat.surface_layer import Exchange, SurfaceLayer
from .mesh.shape import N_GAUSS, FloatArray, gauss_volumes
from .state import Energy
from .surface_loads import LEAST_SHARE, facing_of_edges
from .tooling import Tool

#: Stefan-Boltzmann constant [N/(mm s K4)]; 0 degC [K].
STEFAN_BOLTZMANN, ZERO = 5.670374419e-11, 273.15

#: Corrections of the temperatures after a remeshing; step of its slope, and largest share of the local differences.
KEEPING, SMALL, MOST = 4, 1e-3, 0.2


@dataclass(frozen=True)
class Environment:
    """Surroundings of free workpiece surfaces: still air and walls of one temperature."""

    #: Temperature [degC].
    T: float = 20.0
    #: Heat transfer coefficient of convection [N/(mm s K)]; 0.01 is 10 W/(m2 K), still air.
    h: float = 0.01
    #: Whether the surface radiates, with the emissivity of the material.
    radiation: bool = True
    #: A free surface closer to a tool than this exchanges nothing: the gap shelters it [mm].
    shelter: float = 2.0


@dataclass(frozen=True)
class HeatExchange:
    """Transfer between workpiece, tools and environment."""

    #: Heat transfer coefficient of the contact [N/(mm s K)], the number in kW/(m2 K).
    htc: float = 35.0
    #: Share of the frictional power that enters the workpiece.
    friction_share: float = 0.5
    #: None: free surfaces are insulated.
    environment: Environment | None = field(default_factory=Environment)


def exchange_heat(
    body: Body,
    tools: list[Tool],
    tables: list[FloatArray],
    weights: FloatArray,
    source: FloatArray,
    material: WorkpieceMaterial,
    heat: HeatExchange,
    dt: float,
    account: Energy | None = None,
    rubbing: float = 1.0,
) -> FloatArray:
    """Advance the tools' fields and the workpiece's boundary layer by `dt` [s]; return its temperatures, shape (n,).

    The workpiece sees the tool surfaces as they were before the increment, the tools see the workpiece as
    it is after it: each half is implicit, so the exchange is stable at any increment. Radiation is linear
    in the temperature after the increment, with the slope of before. Only that part of a node's area which faces a
    tool exchanges heat with it.

    - `tables`, shape (n_s, 7): contact tables of the tools.
    - `weights`, shape (n_s,): surface area per radian of the surface nodes [mm2].
    - `source`, shape (n_e, 4): heat released per volume in the increment [N/mm2].
    - `account`: its heat is brought up to date.
    - `rubbing`: friction heat of the increment over that with friction stress and slip velocity of its end.
    """
    surface, layer = body.surface, body.layer or SurfaceLayer.below(body.x, body.quads, body.chain)
    powers = [rubbing * np.abs(table[:, SHEAR] * table[:, SLIP]) for table in tables]
    shares = [np.maximum(table[:, FACING], LEAST_SHARE) for table in tables]
    to_tools, held, warming, through = np.zeros((4, len(surface)))
    for table, tool, frictional, share in zip(tables, tools, powers, shares):
        conductance = np.where(table[:, PRESSURE] > 0.0, share * weights * heat.htc, 0.0)
        to_tools += conductance
        through += np.where(conductance > 0.0, share, 0.0)
        held += conductance * tool.surface_temperature(surface)
        warming += np.where(conductance > 0.0, heat.friction_share * frictional * weights, 0.0)
    to_air, T_air = np.zeros(len(surface)), 0.0
    if heat.environment is not None:
        T_air = heat.environment.T
        film = film_coefficient(layer.surface(body.T), heat.environment, material.emissivity)
        to_air = np.where(exposed(tables, tools, heat.environment.shelter), weights * film, 0.0)
    body.layer, T = layer.step(
        body.x,
        body.quads,
        body.T,
        source,
        material.heat_capacity,
        material.conductivity,
        dt,
        Exchange(
            to_tools + to_air,
            held + to_air * T_air,
            warming,
            np.where(through > 0.0, np.minimum(through, 1.0), 1.0),
        ),
    )
    surface_T = body.layer.surface(T)
    if account is not None:
        turn = 2.0 * np.pi * dt
        volumes = gauss_volumes(body.x, body.quads)
        if account.heat_reference is None:
            account.heat_reference = float(body.T.mean())
            account.heat_start = _content(body, body.T, volumes, material, account.heat_reference)
        account.heat_generated += float((source * volumes).sum() + turn * warming.sum())
        account.heat_to_tools += turn * float((to_tools * surface_T - held).sum())
        account.heat_to_environment += turn * float((to_air * (surface_T - T_air)).sum())
        account.heat_content = _content(body, T, volumes, material, account.heat_reference)
    for table, tool, frictional, share in zip(tables, tools, powers, shares):
        if tool.heat_field is not None:
            into_tool = (1.0 - heat.friction_share) * frictional / share
            points = surface - tool.offset
            touching, facing = table[:, PRESSURE] > 0.0, facing_of_edges(surface, table)
            tool.heat_field.step(dt, points, touching, facing, surface_T, into_tool, heat.htc)
    return T


def exposed(tables: list[FloatArray], tools: list[Tool], shelter: float) -> np.ndarray:
    """Return which surface nodes face no tool: neither in contact nor within `shelter` [mm] of one."""
    free = np.ones(len(tables[0]), dtype=bool)
    for table, tool in zip(tables, tools):
        free &= (table[:, PRESSURE] <= 0.0) & ((table[:, GAP] > shelter) | (table[:, GAP] <= -tool.reach))
    return free


def film_coefficient(T: FloatArray, environment: Environment, emissivity: float) -> FloatArray:
    """Return heat flux over temperature difference at a surface of temperature `T` [N/(mm s K)]."""
    film = np.full(len(T), environment.h)
    if environment.radiation:
        hot, cold = T + ZERO, environment.T + ZERO
        film += emissivity * STEFAN_BOLTZMANN * (hot**2 + cold**2) * (hot + cold)
    return film


def _content(
    body: Body, T: FloatArray, volumes: FloatArray, material: WorkpieceMaterial, reference: float
) -> float:
    """Return the heat in the body above `reference` [N mm]."""
    capacity = material.heat_capacity
    density = integral(capacity, T) - integral(capacity, reference)
    return float((volumes * (density[body.quads] @ N_GAUSS.T)).sum())


def keep_heat(old: Body, new: Body, material: WorkpieceMaterial) -> FloatArray:
    """Return the temperatures of `new`, corrected so that it holds as much heat as `old`, whose shape it has.

    Interpolation on another mesh loses or gains some, where the temperature varies from node to node. There the
    difference is laid on, in proportion; a part of the body that has one temperature keeps it. Where the volumes of both
    meshes differ (remeshing keeps it to some 1e-6), the heat of the mean temperature goes with it.
    """
    mean = float(old.T.mean())
    wanted = _content(old, old.T, gauss_volumes(old.x, old.quads), material, mean)
    volumes, T = gauss_volumes(new.x, new.quads), new.T
    varies = np.zeros(len(T))
    np.maximum.at(varies, new.quads, np.ptp(T[new.quads], axis=1)[:, None])
    for _ in range(KEEPING):
        missing = wanted - _content(new, T, volumes, material, mean)
        ability = _content(new, T + SMALL * varies, volumes, material, mean)
        ability = (ability - _content(new, T, volumes, material, mean)) / SMALL
        if ability <= 0.0 or abs(missing) <= 1e-13 * ability:
            break
        T = T + min(max(missing / ability, -MOST), MOST) * varies
    return T
