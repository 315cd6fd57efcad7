"""What importers of others stumble over: scalars, the order of variables, value references, names, the default experiment."""

from __future__ import annotations

import re
import subprocess
import zipfile
from ctypes import c_size_t, c_uint, c_uint64
from pathlib import Path

import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu
from lxml import etree

from fmus import pack, pack_twin
from fmus.archive.content import read_description
from fmus.native.compile import fmi_headers
from fmus.runtime.running import FmuError, RunningFmu, UnpackedFmu
from friction_models import ConstantFriction
from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES, LOADS
from tests.fmus.exported import c_compiler
from tests.fmus.graphs import inside, random_loads, runtime, save
from tests.fmus.memory_models import AGE_0, D, age_at, ageing_bytes

#: The names as the standard's own header makes them.
_PREFIXED = """\
#define fmi2Paste(a, b) a##b
#define fmi2PasteB(a, b) fmi2Paste(a, b)
#define fmi2FullName(name) fmi2PasteB(FMI2_FUNCTION_PREFIX, name)
"""


@pytest.fixture(scope="module")
def ageing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return save(ageing_bytes(), tmp_path_factory.mktemp("ageing") / "ageing.onnx")


def parts(path: Path) -> list[etree._Element]:
    return list(read_description(path).find("ModelVariables"))


@pytest.mark.usefixtures("uncompiled")
def test_a_size_is_known_before_what_it_sizes(ageing: Path, tmp_path: Path) -> None:
    path = pack(ageing, tmp_path / "arrays.fmu", fmi="3.0", arrays=True)
    known: set[str] = set()
    dimensions = 0
    for variable in parts(path):  # as an importer that resolves while it reads
        for dimension in variable.iterfind("Dimension"):
            assert dimension.get("valueReference") in known, variable.get("name")
            dimensions += 1
        known.add(variable.get("valueReference"))
    assert dimensions == len(LOADS) + 4  # mu, domain_distance, the state and its derivative
    assert validate_fmu(str(path)) == []


def test_one_point_of_fmi_3_is_scalars(ageing: Path, linear_onnx: Path, tmp_path: Path) -> None:
    path = pack(linear_onnx, tmp_path / "line.fmu", fmi="3.0")
    kinds = {v.get("name"): (v.tag, v.get("causality"), len(v)) for v in parts(path)}
    assert "structuralParameter" not in {causality for _, causality, _ in kinds.values()}
    assert {children for _, _, children in kinds.values()} == {0}
    assert kinds["in_domain"][0] == "Boolean"
    assert validate_fmu(str(path)) == []
    loads = random_loads(5, seed=3)
    fmu = UnpackedFmu.of(path)
    with RunningFmu(fmu) as running:
        for row, mu in zip(loads, runtime(linear_onnx.read_bytes(), inside(loads)), strict=True):
            running.set_real(LOAD_NAMES, row)
            assert running.get_real(["mu"])[0] == pytest.approx(mu, rel=1e-12)
        reference = (c_uint * 1)(len(fmu.variables))
        for call in ("GetUInt64", "SetUInt64"):
            with pytest.raises(FmuError, match="there is no UInt64 variable"):
                running.call(call, reference, c_size_t(1), (c_uint64 * 1)(2), c_size_t(1))
    path = pack(ageing, tmp_path / "ageing.fmu", fmi="3.0")
    result = simulate_fmu(
        str(path),
        fmi_type="ModelExchange",
        stop_time=0.5,
        relative_tolerance=1e-6,
        start_values={"v_rel": 60.0},
        output=["age"],
    )
    assert AGE_0 - result["age"][-1] > 0.5
    np.testing.assert_allclose(result["age"], age_at(result["time"], 60.0), rtol=1e-4)


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_in_domain_read_as_a_number_is_0_or_1(ageing: Path, tmp_path: Path, fmi: str) -> None:
    """CasADi reads every output as a Real, and asks for its derivatives."""
    fmu = UnpackedFmu.of(pack(ageing, tmp_path / "x.fmu", fmi=fmi))
    with RunningFmu(fmu) as running:
        for temperature, expected in ((100.0, 1.0), (5000.0, 0.0)):
            running.set_real(["T"], [temperature])
            mu = running.get_real(["mu"])[0]
            assert running.get_real(["in_domain", "mu"]).tolist() == [expected, mu]
        slopes = running.derivative(["in_domain", "mu"], ["v_rel", "age"], np.array([1.0, 1.0]))
        assert slopes[0] == 0.0 and slopes[1] == pytest.approx(0.02)
        if fmi == "3.0":
            adjoint = running.adjoint(["in_domain", "mu"], ["age"], np.array([3.0, 2.0]))
            assert adjoint == pytest.approx([0.04])


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_casadi_takes_all_outputs(linear_onnx: Path, tmp_path: Path, fmi: str) -> None:
    casadi = pytest.importorskip("casadi", reason="the extra [interop] is not installed")
    path = pack(linear_onnx, tmp_path / "line.fmu", fmi=fmi)
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path / "unpacked")
    builder = casadi.DaeBuilder("friction", str(tmp_path / "unpacked"))
    assert builder.y() == ["mu", "domain_distance", "in_domain"]
    function = builder.create("friction", ["u"], ["y"])
    slopes = function.factory("slopes", ["u"], ["jac:y:u"])
    loads = {"v_rel": 100.0, "T": 120.0, "sigma_n": 1500.0, "sd": 10.0, "psi": 2.0}
    row = [loads[n] for n in builder.u()]
    assert np.array(function(row)).ravel() == pytest.approx([0.15 - 0.012 + 0.015, 0.0, 1.0])
    expected = np.zeros((3, 5))
    expected[0, builder.u().index("T")], expected[0, builder.u().index("sigma_n")] = -1e-4, 1e-5
    np.testing.assert_allclose(np.array(slopes(row)), expected, atol=1e-15)


@pytest.mark.parametrize("nodes", [1, 3])
@pytest.mark.parametrize(("target", "fmi"), [("native", "2.0"), ("native", "3.0"), ("python", "2.0")])
@pytest.mark.usefixtures("uncompiled")
def test_no_value_reference_stands_twice(
    memory_onnx: Path, tmp_path: Path, target: str, fmi: str, nodes: int
) -> None:
    path = pack(memory_onnx, tmp_path / "x.fmu", target=target, fmi=fmi, nodes=nodes)
    references = [v.get("valueReference") for v in parts(path)]
    assert len(set(references)) == len(references)


def test_no_value_reference_of_a_solver_stands_twice(tmp_path: Path) -> None:
    from fmus import pack_forming

    for path in (
        pack_twin(tmp_path / "twin.fmu"),
        pack_forming(tmp_path / "forming.fmu", process="upsetting", n_points=8),
    ):
        references = [v.get("valueReference") for v in parts(path)]
        assert len(set(references)) == len(references)


@pytest.mark.slow
@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_two_models_link_into_one_program(ageing: Path, memory_onnx: Path, tmp_path: Path, fmi: str) -> None:
    """Both are composed models; a program that links both prefixes their functions with modelIdentifier."""
    command = c_compiler()  # the system's first: Zig makes the C library anew for a program
    major, objects, names = fmi[0], [], []
    for number, model in enumerate((ageing, memory_onnx)):
        path = pack(model, tmp_path / f"{number}.fmu", fmi=fmi)
        names.append(read_description(path).find("CoSimulation").get("modelIdentifier"))
        with zipfile.ZipFile(path) as archive:
            archive.extractall(tmp_path / str(number))
        for header, text in fmi_headers(fmi).items():
            text = text.replace("#define fmi2FullName(name) name\n", _PREFIXED)  # fmpy's copy has no prefix
            (tmp_path / str(number) / "sources" / header).write_text(text)
        source = tmp_path / str(number) / "sources" / f"fmi{major}.c"
        objects.append(tmp_path / f"{number}.o")
        define = f"-DFMI{major}_FUNCTION_PREFIX={names[-1]}_"
        subprocess.run([*command, "-std=c99", "-O0", "-c", define, source, "-o", objects[-1]], check=True)
    assert all(re.fullmatch(r"friction_composed_[0-9a-f]{16}", name) for name in names)
    calls = ", ".join(f"{name}_fmi{major}GetVersion()" for name in names)
    declared = "\n".join(f"const char *{name}_fmi{major}GetVersion(void);" for name in names)
    main = tmp_path / "main.c"
    main.write_text(
        f'#include <stdio.h>\n{declared}\nint main(void) {{ printf("%s %s", {calls}); return 0; }}\n'
    )
    program = tmp_path / "program"
    done = subprocess.run([*command, main, *objects, "-o", program, "-lm"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    told = subprocess.run([program], capture_output=True, text=True, check=True).stdout.split()
    assert len(told) == 2 and all(version.startswith(major) for version in told)


@pytest.mark.parametrize("target", ["native", "python"])
def test_a_name_belongs_to_one_model(tmp_path: Path, target: str) -> None:
    def name_of(mu: float, file: str, **more: object) -> tuple[str, bytes]:
        path = pack(ConstantFriction(mu), tmp_path / file, target=target, **more)
        return str(read_description(path).find("CoSimulation").get("modelIdentifier")), path.read_bytes()

    first, again = name_of(0.08, "a.fmu"), name_of(0.08, "other name.fmu")
    assert first == again
    assert read_description(tmp_path / "a.fmu").get("modelName") == "friction constant"
    others = [name_of(0.08 + 2.0**-56, "b.fmu")[0], name_of(0.08, "c.fmu", nodes=2)[0]]
    assert len({first[0], *others}) == 3
    own, content = name_of(0.08, "d.fmu", name="polymer_B7")
    assert own == "polymer_B7" and content == name_of(0.08, "e.fmu", name="polymer_B7")[1]
    fmu = UnpackedFmu.of(tmp_path / "d.fmu")
    assert fmu.raw.modelName == "polymer_B7"
    with RunningFmu(fmu) as running:
        assert running.get_real(["mu"]) == [0.08]
    for bad in ("polymer B7", "7up", "", "möbius", "a" * 65, "../x"):
        with pytest.raises(InputError, match=r"allowed: a name as in C.*for instance '[a-z_][a-z_0-9]*'"):
            name_of(0.08, "x.fmu", name=bad)


def test_options_of_the_kinds_that_lack_them(linear_onnx: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"arrays with FMI version '2.0', allowed: '3.0'"):
        pack(linear_onnx, tmp_path / "x.fmu", arrays=True)
    with pytest.raises(InputError, match="name = 'x': belongs to an FMU"):
        pack(linear_onnx, tmp_path / "x", target="c", name="x")


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
@pytest.mark.usefixtures("uncompiled")
def test_nominal_values_and_default_experiment(ageing: Path, tmp_path: Path, fmi: str) -> None:
    path = pack(ageing, tmp_path / "x.fmu", fmi=fmi, nodes=2)
    nominal = {}
    for variable in parts(path):
        typed = variable if fmi == "3.0" else variable[0]
        nominal[variable.get("name").partition("[")[0]] = typed.get("nominal")
    for quantity in LOADS:
        assert float(nominal[quantity.name]) == quantity.nominal
    assert float(nominal["mu"]) == 0.08
    experiment = dict(read_description(path).find("DefaultExperiment").attrib)
    # The fastest memory: D / v_rel at the highest speed of the domain, 500 mm/s; a fixed step resolves it.
    assert {k: float(v) for k, v in experiment.items()} == {
        "startTime": 0.0,
        "stopTime": 1.0,
        "stepSize": 0.01,
    }
    assert float(experiment["stepSize"]) <= D / 500.0


@pytest.mark.usefixtures("uncompiled")
def test_a_fast_memory_gets_a_small_step(tmp_path: Path) -> None:
    from fmus.interface.friction_source import parse_source
    from fmus.interface.time_constants import fastest_time_constant

    for slower, step in ((1.0, 0.01), (8.0, 0.002), (80.0, 2e-4), (1e5, 1e-4)):
        content = ageing_bytes(distance=D / slower)
        path = pack(save(content, tmp_path / "x.onnx"), tmp_path / "x.fmu")
        assert fastest_time_constant(parse_source(content, "x")) == pytest.approx(
            D / slower / 500.0, rel=1e-6
        )
        assert float(read_description(path).find("DefaultExperiment").get("stepSize")) == step
