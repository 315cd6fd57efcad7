"""Stated uncertainties of the loads against whole evaluations with one thing changed; film temperature; every flow curve."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import solve_banded

from forming import FlowTable, Material, PowerLaw, steel_16MnCr5
from forming.fe.heat.properties import scaled
from friction_models import PolynomialFriction
from friction_models.common import InputError
from friction_models.loads import DataSet
from sct_twin import SctRecord, SctTwin
from sct_twin.twin import error_study
from sct_twin.twin.heat.contact_temperature import SlidingContact
from sct_twin.twin.heat.thermal_settings import ThermalBody, ThermalSettings
from sct_twin.twin.uncertainty import GivenUncertainty

Maker = Callable[..., SctRecord]
NAMES = ("u_sigma_n", "u_psi", "u_T")
#: A tip that has folded down in part; the area grows with the force.
OPEN = {"T_tool": 20.0, "bore": 20.0, "tip": 8.944}
#: A bore that is filled.
FILLED = {"T_tool": 20.0, "bore": 15.51}


def only(**given: float) -> GivenUncertainty:
    """Nothing is uncertain but this."""
    none = dict.fromkeys(vars(GivenUncertainty()), 0.0)
    return GivenUncertainty(**(none | given))


def record(maker: Maker, metadata: dict[str, float], force: float, v: float = 50.0) -> SctRecord:
    made = maker(v_set=v)
    return replace(made, F_n=made.F_n * force / 94e3, F_r=made.F_r * force / 94e3, metadata=metadata)


def columns(twin: SctTwin, test: SctRecord) -> dict[str, np.ndarray]:
    return dict(twin.evaluate(test).columns)


def plain(**settings: object) -> SctTwin:
    return SctTwin(mesh_size=0.9, spacing=0.5, **{"uncertainty": None} | settings)  # type: ignore[arg-type]


def test_interface_and_heat_data(record_maker: Maker) -> None:
    """One thing alone: u_T is the change of T of a whole evaluation on the full grid."""
    test = record(record_maker, FILLED, 330e3, v=200.0)
    base = columns(plain(), test)
    heat = plain().heat
    poor = columns(plain(thermal=replace(heat, heat_transfer=heat.heat_transfer * math.exp(-0.4))), test)
    stated = columns(plain(uncertainty=only(heat_transfer=0.4)), test)
    change = np.abs(poor["T"] - base["T"])
    # A poor film cools the specimen less and heats the plate less: little is left for their mean.
    assert change.max() > 1.0
    assert stated["u_T"] == pytest.approx(change, abs=0.2 * change.max())
    assert (stated["u_sigma_n"] == 0.0).all() and (stated["u_psi"] == 0.0).all()

    def times(body: ThermalBody, factor: float) -> ThermalBody:
        pairs = [
            tuple((T, factor * v) for T, v in p) if isinstance(p, tuple) else factor * p
            for p in (body.conductivity, body.capacity)
        ]
        return ThermalBody(*pairs)

    # Conductivity and capacity, 5 % each and independent, of two bodies: four changes.
    squares = 0.0
    for name in ("plate", "specimen"):
        body = getattr(heat, name)
        for changed in (
            ThermalBody(times(body, 1.05).conductivity, body.capacity),
            ThermalBody(body.conductivity, times(body, 1.05).capacity),
        ):
            other = columns(plain(thermal=replace(heat, **{name: changed})), test)
            squares = squares + (other["T"] - base["T"]) ** 2
    stated = columns(plain(uncertainty=only(heat_data=0.05)), test)
    assert stated["u_T"][5:] == pytest.approx(np.sqrt(squares)[5:], rel=0.2)


def test_capacity_of_the_specimen_from_upsetting_on(record_maker: Maker) -> None:
    """A slow test on a specimen that was upset far: how warm it starts is most of what its capacity changes."""
    test = record(record_maker, OPEN, 157e3, v=1.0)
    steel, heat = steel_16MnCr5(), plain().heat
    base = columns(plain(), test)
    assert base["T"][0] > 40.0  # 20 before upsetting
    body = heat.specimen
    more = ThermalBody(body.conductivity, scaled(body.capacity, 1.05))
    capacity = columns(
        plain(
            material=replace(steel, cp=1.05 * steel.cp),
            thermal=replace(heat, specimen=more),
        ),
        test,
    )
    better = ThermalBody(scaled(body.conductivity, 1.05), body.capacity)
    conductivity = columns(plain(thermal=replace(heat, specimen=better)), test)
    plate = [
        columns(plain(thermal=replace(heat, plate=changed)), test)
        for changed in (
            ThermalBody(scaled(heat.plate.conductivity, 1.05), heat.plate.capacity),
            ThermalBody(heat.plate.conductivity, scaled(heat.plate.capacity, 1.05)),
        )
    ]
    squares = sum((other["T"] - base["T"]) ** 2 for other in (capacity, conductivity, *plate))
    stated = columns(plain(uncertainty=only(heat_data=0.05)), test)
    assert stated["u_T"] == pytest.approx(np.sqrt(squares), rel=0.25)


def test_flow_stress_and_friction_while_upsetting(record_maker: Maker) -> None:
    test = record(record_maker, OPEN, 157e3)
    base = columns(plain(), test)
    harder = columns(plain(material=steel_16MnCr5().hardened(1.05)), test)
    stated = columns(plain(uncertainty=only(flow_stress=0.05)), test)
    for name in ("sigma_n", "psi"):
        change = np.abs(harder[name] - base[name])
        assert stated[f"u_{name}"] == pytest.approx(change, rel=0.25), name
    rough = columns(plain(upsetting_mu=0.09), test)
    stated = columns(plain(uncertainty=only(upsetting_mu=0.02)), test)
    # The change is half a percent here, and the area moves by jumps of the mesh of a tenth of that.
    for name in ("sigma_n", "psi"):
        assert stated[f"u_{name}"] == pytest.approx(np.abs(rough[name] - base[name]), rel=0.15), name


@pytest.mark.parametrize("mesh_size", [0.9, 0.5])
def test_temperature_after_another_flow_stress(record_maker: Maker, mesh_size: float) -> None:
    """What has been upset less starts colder and slides on a smaller, hotter contact: at first the two cancel."""

    def change_and_stated(metadata: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
        test, harder = record(record_maker, metadata, 157e3), steel_16MnCr5().hardened(1.05)
        twins = plain(), plain(material=harder), plain(uncertainty=only(flow_stress=0.05))
        base, other, stated = (columns(replace(twin, mesh_size=mesh_size), test) for twin in twins)
        return np.abs(other["T"] - base["T"]), stated["u_T"]

    change, stated = change_and_stated(OPEN)
    assert stated == pytest.approx(change, rel=0.3, abs=0.5)
    assert stated[15:] == pytest.approx(change[15:], rel=0.3)
    # Where the whole face touches from the start, 1.3 K less at first and half a kelvin more at the end.
    change, stated = change_and_stated({"T_tool": 20.0})
    assert stated == pytest.approx(change, abs=0.5)


def test_dimensions(record_maker: Maker) -> None:
    stated = columns(plain(uncertainty=only(diameter=0.02)), record(record_maker, FILLED, 330e3))
    # sigma_n = F / (pi / 4 bore^2), psi = (bore / diameter)^2.
    assert stated["u_sigma_n"] / stated["sigma_n"] == pytest.approx(2.0 * 0.02 / 15.51, rel=0.01)
    assert stated["u_psi"] / stated["psi"] == pytest.approx(
        2.0 * 0.02 * math.hypot(1 / 15.51, 1 / 15.0), rel=0.01
    )
    # A free contact of another specimen: a whole evaluation.
    free = {"T_tool": 20.0}
    base, wider = (
        columns(plain(), record(record_maker, free | {"specimen_diameter": d}, 157e3)) for d in (15.0, 15.5)
    )
    stated = columns(plain(uncertainty=only(diameter=0.5)), record(record_maker, free, 157e3))
    for name in ("sigma_n", "psi"):
        change = np.abs(wider[name] - base[name])
        assert stated[f"u_{name}"] == pytest.approx(change, rel=0.25), name


def test_a_measured_contact_is_known_better(record_maker: Maker) -> None:
    test = record(record_maker, OPEN, 157e3)
    twin = SctTwin(mesh_size=0.9, spacing=0.5)
    without = twin.evaluate(test)
    diameter = 2.0 * math.sqrt(float(without.summary["contact_area"]) / math.pi)
    measured = twin.evaluate(replace(test, metadata=OPEN | {"contact_diameter": diameter}))
    assert measured.summary["contact_diameter_use"] == "force and area"
    share = measured.columns["u_sigma_n"] / measured.columns["sigma_n"]
    assert share == pytest.approx(math.hypot(2.0 * 0.05 / diameter, 0.008), rel=0.1)
    assert (share < 0.6 * without.columns["u_sigma_n"] / without.columns["sigma_n"]).all()


def test_all_together_and_by_squares(record_maker: Maker) -> None:
    test = record(record_maker, FILLED, 330e3)
    whole = columns(plain(uncertainty=GivenUncertainty()), test)
    squares = dict.fromkeys(NAMES, 0.0)
    for name, value in vars(GivenUncertainty()).items():
        alone = columns(plain(uncertainty=only(**{name: value})), test)
        squares = {n: squares[n] + alone[n] ** 2 for n in NAMES}
    for name in NAMES:
        assert whole[name] == pytest.approx(np.sqrt(squares[name]), rel=1e-6), name
    assert (whole["u_T"] > 0.0).all()
    # With and without: the loads are the same.
    base = columns(plain(), test)
    assert not set(NAMES) & set(base)
    assert all(np.array_equal(base[name], whole[name]) for name in base)
    with pytest.raises(InputError, match=r"uncertainty of flow_stress = -0.1; allowed: 0 to 1"):
        GivenUncertainty(flow_stress=-0.1)


def test_models_mind_the_columns_only_where_they_are_asked_to(twinned: tuple[object, Path]) -> None:
    _, folder = twinned
    data = DataSet.load(folder)
    assert set(NAMES) | {"T_film"} <= set(data.points.columns)
    assert data.info["extra_units"]["u_T"] == "K" and data.info["extra_units"]["T_film"] == "degC"
    assert (data.points[list(NAMES)] > 0.0).all(axis=None)
    frames = [data.points, data.points.drop(columns=[*NAMES, "T_film"])]
    known, plain = (
        PolynomialFriction(degree=2).fit_frame(f, load_uncertainty=False).predict_frame(data.points)
        for f in frames
    )
    assert np.array_equal(known, plain)
    weighed = PolynomialFriction(degree=2).fit_frame(data.points).predict_frame(data.points)
    assert weighed.to_numpy() == pytest.approx(plain.to_numpy(), abs=2e-3)
    averages = DataSet.load(folder / "averages")
    # What all points of a test share does not average out.
    mean = data.points.groupby("test_id", sort=False)["u_sigma_n"].mean().to_numpy()
    assert averages.points["u_sigma_n"].to_numpy() == pytest.approx(mean)


TABLE = FlowTable(strains=(0.0, 1.0), rates=(1.0,), temperatures=(20.0,), stresses=(((400.0, 900.0),),))


@pytest.mark.parametrize("steel", [steel_16MnCr5(), PowerLaw(yield_stress=300.0, K=400.0, n=0.3), TABLE])
def test_every_flow_curve_is_checked(steel: Material) -> None:
    harder = error_study.variants(SctTwin(material=steel))["flow stress x 1.02"]
    strains = np.linspace(0.0, 1.2, 13)
    assert isinstance(harder.material, Material)
    assert harder.material.flow_stress(strains) == pytest.approx(1.02 * steel.flow_stress(strains), rel=1e-12)
    # The heat data are those of the twin.
    assert harder.heat == SctTwin(material=steel).heat


def test_a_tool_material_has_no_flow_stress_to_change() -> None:
    with pytest.raises(InputError, match="has no flow curve"):
        Material().hardened(1.02)


@pytest.mark.parametrize("share", [0.5, 0.2])
def test_film_temperature_is_that_of_a_meshed_film(share: float) -> None:
    """One dimension, heat within a film of 0.02 mm with the conductance h: a grid of the test's own."""
    h, k_p, k_s, c, q = 20.0, 20.0, 40.0, 3.6, 3000.0
    steps = np.diff(np.linspace(0.0, 1.0, 201) ** 2 * 0.05)
    grid = ThermalSettings(cells=4, surface_layer=0.01, growth=1.15, depth=25.0, heat_transfer=h)
    settings = replace(grid, plate=ThermalBody(k_p, c), specimen=ThermalBody(k_s, c))
    settings = replace(settings, friction_heat_share=share)
    cold = {"plate_temperature": 0.0, "specimen_temperature": 0.0, "punch_temperature": 0.0}
    contact = SlidingContact(9.0, 25.0, settings=settings, band=True, margin=0.0, **cold)
    for dt in steps:
        contact.advance(float(dt), 0.0, q * contact.area)
    # Cells of 0.005 mm to a depth of 4 mm in both bodies, the film in 41 cells of hardly any heat capacity.
    n, m, solid = 800, 41, 0.005

    def cells(plate: float, film: float, specimen: float) -> np.ndarray:
        return np.repeat([plate, film, specimen], [n, m, n])

    half = 0.5 * cells(solid, 0.02 / m, solid) / cells(k_p, h * 0.02, k_s)
    room = cells(c * solid, 1e-4 * 0.02 / m, c * solid)
    between = 1.0 / (half[1:] + half[:-1])
    source = np.zeros(len(room))
    source[n + int(share * m)] = q
    T = np.zeros(len(room))
    for dt in steps:
        diagonal = room / dt + np.append(between, 0.0) + np.append(0.0, between)
        band = np.stack([np.append(0.0, -between), diagonal, np.append(-between, 0.0)])
        T = solve_banded((1, 1), band, room / dt * T + source)
    plate = T[n - 1] + (T[n] - T[n - 1]) * between[n - 1] * half[n - 1]
    specimen = T[n + m] + (T[n + m - 1] - T[n + m]) * between[n + m - 1] * half[n + m]
    seen = contact.contact
    assert seen.mean == pytest.approx(0.5 * (plate + specimen), rel=0.01)
    # The heat is released within a cell of the film, not at its edge or middle: up to 1 / 41 less.
    assert seen.film - seen.mean == pytest.approx(T[n + int(share * m)] - 0.5 * (plate + specimen), rel=0.03)
    if share == 0.5:
        assert seen.film - seen.mean == pytest.approx(q / (4.0 * h))
    contact.advance(1e-9, 0.0, 0.0)
    without = contact.contact
    assert without.film == pytest.approx((1.0 - share) * without.plate + share * without.specimen, abs=1e-9)


def test_film_temperature_of_a_test(record_maker: Maker) -> None:
    """Heat per area is friction force times speed over the area of the contact, to the grid's 1 %."""
    c = columns(plain(), record(record_maker, FILLED, 330e3, v=200.0))
    q = c["F_r"] * c["v_rel"] / (np.pi / 4.0 * 15.51**2)
    assert (c["T_film"] - c["T"])[10:] == pytest.approx(q[10:] / (4.0 * 35.0), rel=0.02)
    assert (c["T_film"] - c["T"])[-1] > 100.0
