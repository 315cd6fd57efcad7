"""Material files: what is read, every form against its formula, slopes of the kernel, and bad input."""

from __future__ import annotations

import copy
import json
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from forming import BackwardCupExtrusion, ForwardRodExtrusion
from forming.fe.flow import flow_stress
from forming.materials.files import FORMS, MAX_BYTES, material_from_content
from forming.materials.materials import (
    FlowTable,
    HenselSpittel,
    Material,
    PowerLaw,
    as_material,
    load,
    material_from_dict,
    steel_16MnCr5,
)
from friction_models.common import InputError

CONTENT = {
    "name": "test steel",
    "source": "made up",
    "elasticity": {"E": 200000, "nu": 0.29},
    "density": 7800,
    "conductivity": {"T": [20, 200], "value": [40, 38.0]},
    "heat_capacity": 460,
}
STRAINS = np.array([0.0, 0.01, 0.03, 0.06, 0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.0, 3.0])
RATES = np.array([0.01, 0.1, 1.0, 10.0, 100.0])
TEMPERATURES = np.array([20.0, 100.0, 200.0, 300.0])


def curve(**law):
    return CONTENT | {"flow_curve": law}


def table_of(steel, **more):
    stresses = steel.flow_stress(STRAINS, TEMPERATURES[:, None, None], RATES[:, None])
    return FlowTable(strains=STRAINS, rates=RATES, temperatures=TEMPERATURES, stresses=stresses, **more)


def test_shipped_16MnCr5_holds_the_numbers_of_the_paper():
    steel = load("16MnCr5")
    assert isinstance(steel, HenselSpittel) and steel == steel_16MnCr5()
    law = [677.443, -0.000788968, 0.103451, 0.0253737, 8.45076e-05, 0.0]
    elastic = [210_000 / 2.6, 210_000 / 1.2, 2e-3, 1e-3]
    assert steel.vector() == pytest.approx(law + elastic, rel=1e-15)
    assert (steel.rho, steel.cp, steel.conductivity, steel.taylor_quinney) == (7850.0, 470.0, 42.0, 0.9)
    assert "paper" in steel.source


def test_shipped_1_2379_is_a_tool_without_a_flow_curve():
    steel = load("1.2379")
    assert type(steel) is Material and steel.conductivity == ((20.0, 20.0), (200.0, 21.0), (400.0, 23.0))
    assert steel.heat_capacity == pytest.approx(7700 * 460e-6)
    with pytest.raises(InputError, match=r"'1\.2379' has no flow curve; allowed as a tool"):
        steel.check_start("fre", 20.0)


def test_all_forms_meet_their_formulas(tmp_path):
    e, T, r = 0.6, 150.0, 12.0
    forms = {
        "hensel_spittel": (
            {"A": 900, "m1": -1e-3, "m2": 0.12, "m3": 0.02, "m4": -1e-3, "m5": -1e-4, "m7": -0.05, "m8": 1e-4, "m9": 0.03},
            900 * np.exp(-1e-3 * T) * T**0.03 * e**0.12 * np.exp(-1e-3 / e)
            * (1 + e) ** (-1e-4 * T) * np.exp(-0.05 * e) * r ** (0.02 + 1e-4 * T),
        ),
        "hensel_spittel_rate_temperature": (
            {"A": 700, "m1": -8e-4, "m2": 0.1, "m3": 0.025, "m4": 8e-5},
            700 * np.exp(-8e-4 * T) * e**0.1 * r ** (0.025 + 8e-5 * T),
        ),
        "hensel_spittel_gmt": (
            {"C1": 800, "C2": -9e-4, "n1": -1e-4, "n2": 0.15, "l1": -2e-5, "l2": -1e-3, "m1": 1e-4, "m2": 0.01},
            800 * np.exp(-9e-4 * T) * e ** (-1e-4 * T + 0.15) * np.exp((-2e-5 * T - 1e-3) / e)
            * r ** (1e-4 * T + 0.01),
        ),
        "constant": ({"stress": 500}, 500.0),
        "ludwik": ({"yield_stress": 300, "K": 400, "n": 0.3}, 300 + 400 * e**0.3),
        "swift": (
            {"K": 700, "n": 0.2, "prestrain": 0.01, "rate_exponent": 0.02, "reference_rate": 2.0},
            700 * (0.01 + e) ** 0.2 * (r / 2.0) ** 0.02,
        ),
    }  # fmt: skip
    for name, (law, expected) in forms.items():
        file = tmp_path / f"{name}.yaml"
        file.write_text(yaml.safe_dump(curve(form=name, **law)))
        steel = load(file)
        # The smooth floors of strain and rate change the sixth digit.
        assert float(steel.flow_stress(e, T, r)) == pytest.approx(expected, rel=1e-5), name
        assert flow_stress(e, r, T, steel.vector())[0] == pytest.approx(expected, rel=1e-5), name
        assert steel.conductivity == ((20.0, 40.0), (200.0, 38.0)) and steel.E == 200_000


@pytest.mark.parametrize("form", ["extended", "swift", "ludwik", "table"])
def test_slopes_of_the_kernel_are_the_derivatives(form):
    """What makes the tangent consistent."""
    steel = steel_16MnCr5()
    m = {
        "extended": lambda: replace(steel, m5=-1e-4, m7=-0.05, m9=0.03, n1=-1e-4, l1=-1e-6),
        "swift": lambda: PowerLaw(K=700, n=0.2, prestrain=0.01, rate_exponent=0.02),
        "ludwik": lambda: PowerLaw(yield_stress=300, K=400, n=0.4),
        "table": lambda: table_of(steel),
    }[form]().vector()
    for strain, rate, T in [(1e-3, 0.02, 20.0), (0.05, 0.3, 150.0), (1.21, 40.0, 250.0), (2.9, 90.0, 30.0)]:
        y, by_strain, by_rate = flow_stress(strain, rate, T, m)
        h = 1e-6
        up, down = flow_stress(strain * (1 + h), rate, T, m)[0], flow_stress(strain * (1 - h), rate, T, m)[0]
        assert by_strain == pytest.approx((up - down) / (2 * h * strain), rel=1e-5, abs=1e-6 * y)
        up, down = flow_stress(strain, rate * (1 + h), T, m)[0], flow_stress(strain, rate * (1 - h), T, m)[0]
        assert by_rate == pytest.approx((up - down) / (2 * h * rate), rel=1e-5, abs=1e-8 * y)


def test_a_table_gives_its_own_values_and_lies_close_to_the_law_between():
    steel, table = steel_16MnCr5(), table_of(steel_16MnCr5())
    grid = np.meshgrid(TEMPERATURES, RATES, STRAINS, indexing="ij")
    assert table.flow_stress(grid[2], grid[0], grid[1]) == pytest.approx(np.array(table.stresses), rel=1e-12)
    rng = np.random.default_rng(1)
    e, r, T = rng.uniform(0.03, 3.0, 500), 10 ** rng.uniform(-2, 2, 500), rng.uniform(20, 300, 500)
    # Rate and temperature act as powers and exponentials, which the table holds exactly; the rest is strain.
    assert table.flow_stress(e, T, r) == pytest.approx(steel.flow_stress(e, T, r), rel=2e-3)


def test_a_table_is_monotone_and_keeps_its_edge_outside():
    """A jump followed by a plateau makes an ordinary cubic overshoot."""
    table = FlowTable(
        strains=(0.0, 0.1, 0.2, 1.0), rates=(1.0,), temperatures=(20.0,), stresses=(((300, 310, 600, 601),),)
    )
    y = table.flow_stress(np.linspace(0.0, 1.5, 400), 500.0, 1e3)
    assert (np.diff(y) >= -1e-9).all() and y[0] == pytest.approx(300) and y[-1] == pytest.approx(601)
    assert np.isfinite(table.flow_stress(0.5, -200.0, 0.0))
    y, by_strain, by_rate = flow_stress(2.0, 1e5, 20.0, table.vector())
    assert (by_strain, by_rate) == (0.0, 0.0)
    assert np.isnan(flow_stress(float("nan"), 1.0, 20.0, table.vector())[0])


def test_materials_survive_json():
    """The way into an FMU and back."""
    for steel in (load("16MnCr5"), load("1.2379"), table_of(steel_16MnCr5()), PowerLaw(yield_stress=500)):
        again = material_from_dict(json.loads(json.dumps(steel.to_dict())))
        assert again == steel and type(again) is type(steel)


def test_a_material_is_given_as_object_name_or_path(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text(yaml.safe_dump(curve(form="constant", stress=400)))
    assert as_material(None) == as_material("16MnCr5") == steel_16MnCr5()
    assert as_material(file) == as_material(str(file)) == load(file)
    steel = steel_16MnCr5()
    assert as_material(steel) is steel
    with pytest.raises(InputError, match="material = 7; allowed"):
        as_material(7)
    with pytest.raises(InputError, match=r"unknown material '16MnCr4'.*did you mean '16MnCr5'"):
        as_material("16MnCr4")
    with pytest.raises(InputError, match=r"nowhere\.yaml: no such file"):
        as_material("nowhere.yaml")


def test_numbers_without_a_point_are_numbers(tmp_path):
    """YAML 1.1 reads 2e-3 as a text."""
    file = tmp_path / "mine.yaml"
    law = "{form: hensel_spittel, A: 6e2, m1: -8e-4, m2: 0.1, m3: 0.02}"
    file.write_text(
        f"name: x\nsource: y\nflow_curve: {law}\nelasticity: {{E: 2e5, nu: 0.3}}\n"
        "density: 7800\nconductivity: 42\nheat_capacity: 470\n"
    )
    assert load(file).m1 == -8e-4 and load(file).E == 2e5


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"densty": 7800}, ["unknown key 'densty'", "did you mean 'density'"]),
        ({"density": None}, ["density"]),
        ({"density": True}, ["density", "True"]),
        ({"density": -1}, ["density = -1 kg/m3", "500 to 25000"]),
        ({"density": 7.85}, ["density = 7.85 kg/m3", "500 to 25000"]),
        ({"elasticity": {"E": 210, "nu": 0.3}}, ["elasticity.E = 210 MPa", "1000 to"]),
        ({"heat_capacity": {"T": [20, 30], "value": [470, 0.5]}}, ["heat_capacity = 0.5 J/(kg K)"]),
        ({"density": float("nan")}, ["density", "nan"]),
        ({"name": 1.2379}, ["name", "1.2379", "string"]),
        ({"flow_curve": {"form": "hensel_spitel", "A": 1}}, ["'hensel_spitel'", "did you mean 'hensel_spittel'"]),
        ({"flow_curve": {"form": ["swift"]}}, ["unknown form of flow_curve"]),
        ({"flow_curve": {"form": "swift", "K": 700, "n": 0.2}}, ["flow_curve.prestrain is missing"]),
        ({"flow_curve": {"form": "swift", "K": 7, "n": 0.2, "prestrain": 0, "m6": 1}}, ["unknown key 'flow_curve.m6'"]),
        ({"flow_curve": {"form": "swift", "K": 7, "n": -0.2, "prestrain": 0}}, ["n = -0.2", ">= 0"]),
        ({"flow_curve": {"form": "constant", "stress": 0}}, ["yield_stress = K = 0"]),
        ({"flow_curve": {"form": "constant", "stress": 4e8}}, ["flow stress = 4e+08 MPa at a strain of 0.2", "1 to 10000 MPa"]),
        ({"flow_curve": {"form": "swift", "K": 0.7, "n": 0.2, "prestrain": 0}}, ["flow stress = 0.5", "1 to 10000 MPa"]),
        ({"flow_curve": 3}, ["flow_curve", "3"]),
        ({"conductivity": {"T": [20, 20], "value": [1, 2]}}, ["conductivity", "20 degC comes after 20 degC"]),
        ({"conductivity": {"T": [20, 30], "value": [1]}}, ["conductivity", "2 temperatures and 1 values"]),
        ({"heat_capacity": {"T": [20, 30], "value": [470, -2]}}, ["heat_capacity = -2"]),
        ({"heat_capacity": "much"}, ["heat_capacity", "'much'"]),
        ({"valid": {"T": [300, 20]}}, ["T_range = (300.0, 20.0)"]),
        ({"valid": {"T": [300]}}, ["valid.T"]),
        ({"elasticity": {"E": 2e5, "nu": 0.5}}, ["nu = 0.5"]),
        ({"emissivity": 1.5}, ["emissivity = 1.5", "0 to 1"]),
    ],
)  # fmt: skip
def test_impossible_files_are_refused(change, words):
    content = copy.deepcopy(CONTENT) | change
    with pytest.raises(InputError) as caught:
        material_from_content(content, "mine.yaml")
    text = str(caught.value)
    assert text.startswith("mine.yaml: ") or text.startswith("unknown") or "mine.yaml" in text
    assert all(word in text for word in words), text
    assert "\n" not in text


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"strain": [0.0, 0.0]}, ["strains", "rising"]),
        ({"rate": [0.0, 1.0]}, ["rates begins with 0"]),
        ({"stress": [[[300, 400], [310, 410]]]}, ["(1, 2, 2)", "(1, 1, 2)"]),
        ({"stress": [[[300]]]}, ["stresses", "(1, 1, 2)"]),
        ({"stress": [[[300, 0]]]}, ["stress 0.0 MPa", "strain 0.1"]),
        ({"stress": [[300, 400]]}, ["flow_curve.stress"]),
        ({"strain": list(range(201))}, ["strain", "200"]),
    ],
)
def test_impossible_tables_are_refused(change, words):
    law = {"form": "table", "strain": [0.0, 0.1], "rate": [1.0], "T": [20.0], "stress": [[[300, 400]]]}
    assert float(material_from_content(curve(**law)).flow_stress(0.1)) == pytest.approx(400.0)
    with pytest.raises(InputError) as caught:
        material_from_content(curve(**(law | change)), "mine.yaml")
    assert all(word in str(caught.value) for word in words), str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a: &x [1]\nb: *x\n", ["alias"]),
        ("[" * 40, ["nested deeper"]),
        ("a: [1", ["not YAML"]),
        ("- 1\n", ["holds a list"]),
        ("!!python/object/apply:os.getcwd []", ["not YAML"]),
        ("x" * (MAX_BYTES + 1), ["bytes", str(MAX_BYTES)]),
    ],
)
def test_hostile_files_are_refused(tmp_path, text, words):
    file = tmp_path / "mine.yaml"
    file.write_text(text)
    with pytest.raises(InputError) as caught:
        load(file)
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_limits_of_validity_are_told():
    steel = replace(steel_16MnCr5(), strain_range=(0.0, 2.0), T_range=(20.0, 300.0))
    assert steel.left_range(2.0, 1e6, 300.0) == ()
    first, second = steel.left_range(3.4, 1.0, 412.0)
    assert "strain reached 3.4" in first and "0 to 2" in first
    assert "temperature reached 412 degC" in second and "20 to 300 degC" in second
    with pytest.raises(InputError, match=r"fre: T_billet = 350 degC; allowed: 20 to 300 degC"):
        steel.check_start("fre", 350.0)
    assert table_of(steel_16MnCr5()).T_range == (20.0, 300.0)


def test_processes_take_a_material_by_name_and_refuse_what_cannot_be():
    process = ForwardRodExtrusion(material="16MnCr5", tool_material="1.2379", T_ambient=25.0)
    assert process.material == steel_16MnCr5()
    for wrong, words in (
        ({"material": "1.2379"}, "'1.2379' has no flow curve"),
        ({"material": "16MnCr"}, "did you mean '16MnCr5'"),
        (
            {"T_billet": 650.0},
            "forward rod extrusion: T_billet = 650 degC; allowed: 0 to 500 degC",
        ),
        ({"tool_material": "1.2380"}, "did you mean '1.2379'"),
        ({"h_ambient": -1.0}, "h_ambient = -1.0 W/(m2 K); allowed: 0 to"),
        ({"T_ambient": float("nan")}, "T_ambient = nan"),
        ({"htc": 0.0}, "htc = 0.0 kW/(m2 K)"),
    ):
        with pytest.raises(InputError) as caught:
            ForwardRodExtrusion(**wrong)
        assert words in str(caught.value)


@pytest.mark.slow
@pytest.mark.parametrize("process", [ForwardRodExtrusion, BackwardCupExtrusion])
def test_a_table_of_the_law_gives_the_force_of_the_law(process):
    """The same steel as a table: the tangent converges as well, and heat over temperature is iterated."""
    law = steel_16MnCr5()
    T, cp = np.array([20.0, 400.0]), np.array([470.0, 470.0])
    fine = np.unique(np.concatenate([STRAINS, np.geomspace(0.002, 5.0, 40)]))
    wide = np.array([20.0, 100.0, 200.0, 300.0, 450.0])
    rates = 10.0 ** np.arange(-3, 5)
    table = FlowTable(
        strains=fine,
        rates=rates,
        temperatures=wide,
        stresses=law.flow_stress(fine, wide[:, None, None], rates[:, None]),
        cp=tuple(zip(T, cp)),
    )
    runs = [process(material=steel, mesh_size=0.6, n_points=20).run(0.06, 1.5) for steel in (law, table)]
    assert [run.status for run in runs] == ["ok", "ok"]
    assert runs[1].force[3:] == pytest.approx(runs[0].force[3:], rel=3e-3)
    assert abs(runs[1].increments - runs[0].increments) <= 3 and runs[1].failed_increments <= 1


def test_a_snapshot_with_a_tabulated_material_continues_bit_by_bit():
    table = table_of(steel_16MnCr5(), cp=((20.0, 460.0), (300.0, 560.0)))
    process = ForwardRodExtrusion(material=table, mesh_size=0.6, n_points=20)
    process.start(0.05)
    process.advance(0.5)
    kept = process.snapshot()
    ends = []
    for _ in range(2):
        process.restore(kept)
        process.advance(0.7)
        state = process.simulation.state
        ends.append(
            (process.force, state.energy, state.body.T.tobytes(), state.tools[0].heat_field.T.tobytes())
        )
    assert ends[0] == ends[1]


def test_heat_is_accounted_for_through_remeshing():
    """What remeshing and elastic compression cost: the body's heat and what left it against what arose."""
    process = ForwardRodExtrusion(mesh_size=0.5, n_points=20, h_ambient=100.0)
    result = process.run(0.08, 4.0)
    energy = process.simulation.state.energy
    assert result.remeshes > 3 and abs(energy.heat_imbalance) < 0.01
    assert 0.0 < energy.heat_to_environment < 0.1 * energy.heat_generated
    assert energy.heat_to_tools > 0.1 * energy.heat_generated
    assert energy.heat_generated == pytest.approx(0.9 * energy.plastic + 0.5 * energy.friction, rel=2e-3)


def test_a_run_says_where_it_left_the_range_of_its_material():
    steel = replace(steel_16MnCr5(), strain_range=(0.0, 0.4), rate_range=(1e-3, 1e4), T_range=(0.0, 40.0))
    run = ForwardRodExtrusion(material=steel, mesh_size=0.6, n_points=20).run(0.06, 2.0)
    assert run.status == "ok" and len(run.warnings) == 2
    assert "strain reached" in run.warnings[0] and "0 to 0.4" in run.warnings[0]
    assert "temperature reached" in run.warnings[1]
    assert abs(run.heat_balance) < 0.01
    assert ForwardRodExtrusion(mesh_size=0.6, n_points=20).run(0.06, 0.3).warnings == ()


def test_the_file_in_the_documentation_runs(tmp_path):
    page = Path(__file__).parents[2].joinpath("docs", "materials.md").read_text(encoding="utf-8")
    file = tmp_path / "steel.yaml"
    file.write_text(page.split("```yaml\n")[1].split("```")[0], encoding="utf-8")
    steel = load(file)
    assert float(steel.flow_stress(0.7, 20.0, 0.1)) == pytest.approx(635.0)
    # Half way in ln(rate) and T: the geometric mean.
    assert float(steel.flow_stress(0.7, 110.0, 1.0)) == pytest.approx((635 * 675 * 550 * 590) ** 0.25)
    assert steel.T_range == (20.0, 200.0) and steel.strain_range == (0.0, 2.0)
    process = ForwardRodExtrusion(material=file, mesh_size=0.6, n_points=20, T_tool=200.0)
    run = process.run(0.06, 1.0)
    assert run.status == "ok" and run.max_force > 40.0 and abs(run.heat_balance) < 0.03
    for name in FORMS:
        assert f"| `{name}` |" in page, name


def test_numbers_of_steels_and_dictionaries_are_materials():
    assert as_material(1.2379) == load("1.2379")
    assert as_material(steel_16MnCr5().to_dict()) == steel_16MnCr5()
    for wrong, words in (
        ({"kind": "Steel"}, "unknown kind of material 'Steel'"),
        ({"kind": "PowerLaw", "k": 1.0}, "unknown parameter of a material 'k'"),
        ({"A": 1.0, "m1": 0.0, "m2": 0.1}, "material: m3 is missing"),
    ):
        with pytest.raises(InputError, match=words):
            as_material(wrong)


def test_a_tabulated_material_goes_into_an_fmu_and_its_state_back(tmp_path):
    """Roll back in the same instance, and continue in another one from bytes: bit by bit the same."""
    from fmus.slaves.forming_solver import FormingSolver
    from fmus.targets.solvers import pack_forming

    table = table_of(steel_16MnCr5(), cp=((20.0, 460.0), (300.0, 560.0)))
    path = pack_forming(
        tmp_path / "t.fmu", n_points=20, mesh_size=0.6, material=table, tool_material="1.2379"
    )
    with zipfile.ZipFile(path) as archive:
        name = next(n for n in archive.namelist() if n.endswith("interface.json"))
        config = json.loads(archive.read(name))
    solver = FormingSolver(config)
    solver.launch()
    assert solver.process.material == table
    solver.advance(0.0, 0.1)
    saved = solver.save()
    content = solver.to_bytes(saved, [])
    solver.advance(0.1, 0.1)
    first = solver.values.copy()
    solver.restore(saved)
    solver.advance(0.1, 0.1)
    other = FormingSolver(config)
    other.restore(other.from_bytes(content)[0])
    other.advance(0.1, 0.1)
    assert np.array_equal(solver.values, first) and np.array_equal(other.values, first)
