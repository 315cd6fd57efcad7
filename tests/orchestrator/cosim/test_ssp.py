"""Systems as SSP archives: there and back without a change, and what is refused."""

from __future__ import annotations

import copy
import hashlib
import pickle
import zipfile
from pathlib import Path

import numpy as np
import pytest
from lxml import etree

from fmus.archive.content import write_archive
from fmus.ssp.packing import pack_ssp
from fmus.ssp.reading import read_ssp
from fmus.ssp.systems import DESCRIPTION
from friction_models import ConstantFriction, LinearFriction
from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES
from orchestrator import Master, Run, System
from tests.friction_models.made_up import campaign
from tests.orchestrator.native_fmus import Real, native_fmu

POINTS, STEPS, STEP = 5, 8, 0.01


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    from fmus import pack

    folder = tmp_path_factory.mktemp("ssp")
    model = LinearFriction().fit_frame(campaign(tests=6, points=20))
    units = {"v_rel": "mm/s", "T": "degC", "sigma_n": "MPa", "sd": "mm", "psi": "1"}
    first = {"v_rel": 50.0, "T": 60.0, "sigma_n": 800.0, "sd": 2.0, "psi": 1.5}
    places = range(1, POINTS + 1)
    variables = [Real(f"{q}[{k}]", "output", unit=units[q]) for q in LOAD_NAMES for k in places]
    variables += [Real(f"mu[{k}]", "input", 0.05) for k in places]
    variables += [Real("force", "output", unit="kN"), Real("gain", "parameter", 1.0)]
    lines = [f"V({q}_{k}) = {first[q]!r} * (1.0 + 0.1 * t * {k}.0);" for q in LOAD_NAMES for k in places]
    lines.append("V(force) = V(gain) * (" + " + ".join(f"V(mu_{k})" for k in places) + ");")
    return {
        "one": pack(model, folder / "one.fmu"),
        "all": pack(model, folder / "all.fmu", nodes=POINTS),
        "three": pack(model, folder / "three.fmu", fmi="3.0", arrays=True),
        "scalars": pack(model, folder / "scalars.fmu", fmi="3.0"),
        "constant": pack(ConstantFriction(0.1), folder / "constant.fmu", nodes=POINTS),
        "process": native_fmu(folder / "process.fmu", variables, "\n".join(lines)),
    }


def system(fmu: dict[str, Path], friction: str) -> System:
    return System.from_dict(
        {
            "name": "extrusion & test",
            "communication_step": STEP,
            "stop_time": STEP * STEPS,
            "components": {
                "friction": {"fmu": str(fmu[friction])},
                "process": {"fmu": str(fmu["process"]), "start": {"gain": 0.1 + 0.2}},
            },
            "connections": [f"process.{q} -> friction.{q}" for q in LOAD_NAMES]
            + ["friction.mu -> process.mu"],
            "order": ["process", "friction"],
            "record": ["process.force", "process.T", "friction.mu"],
            "synthetic": True,
            "provenance": {"campaign_seed": 7, "note": "made <up>"},
        }
    )


def test_there_and_back_changes_nothing(fmu: dict[str, Path], tmp_path: Path) -> None:
    original = system(fmu, "all")
    path = original.export(tmp_path / "system.ssp")
    assert path.read_bytes() == original.export(tmp_path / "again.ssp").read_bytes()
    loaded = System.load(path)
    first, second = Master(original).run(tmp_path / "a"), Master(loaded).run(tmp_path / "b")
    assert first.values.keys() == second.values.keys()
    for name, values in first.values.items():
        np.testing.assert_array_equal(second[name], values)
    assert second.synthetic and second.manifest["provenance"] == first.manifest["provenance"]
    assert loaded.evaluation_order() == ["process", "friction"]
    # The run keeps the FMUs of the archive, and runs again without it.
    path.unlink()
    rerun = Master(System.load(tmp_path / "b" / "system.yaml")).run(tmp_path / "c")
    np.testing.assert_array_equal(rerun["process.force"], first["process.force"])
    assert Run.load(tmp_path / "b")["process.force"].shape == (STEPS + 1,)


@pytest.mark.parametrize("which", ["one", "three", "scalars"])
def test_points_become_components_of_one_resource(fmu: dict[str, Path], tmp_path: Path, which: str) -> None:
    original = system(fmu, which)
    path = original.export(tmp_path / "system.ssp")
    structure = read_ssp(path)
    assert [c.name for c in structure.components] == [
        *(f"friction_{k + 1}" for k in range(POINTS)),
        "process",
    ]
    assert {c.source for c in structure.components} == {"resources/friction.fmu", "resources/process.fmu"}
    run, wanted = Master(System.load(path)).run(tmp_path / "a"), Master(original).run(tmp_path / "b")
    np.testing.assert_array_equal(run["process.force"], wanted["process.force"])
    together = np.column_stack([run[f"friction_{k + 1}.mu"] for k in range(POINTS)])
    np.testing.assert_array_equal(together, wanted["friction.mu"])


def test_replacing_one_resource_swaps_the_friction(fmu: dict[str, Path], tmp_path: Path) -> None:
    path = system(fmu, "all").export(tmp_path / "system.ssp")
    with zipfile.ZipFile(path) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    files["resources/friction.fmu"] = fmu["constant"].read_bytes()
    run = Master(System.load(write_archive(tmp_path / "other.ssp", files))).run(tmp_path / "run")
    np.testing.assert_allclose(run["friction.mu"], 0.1)
    swapped = Master(System.load(path).swap("friction", fmu["constant"])).run(tmp_path / "swapped")
    np.testing.assert_array_equal(swapped["process.force"], run["process.force"])


def test_the_standard_is_kept(fmu: dict[str, Path], tmp_path: Path) -> None:
    from fmpy.ssp.ssd import read_ssd

    for boundary in (False, True):
        path = system(fmu, "one").export(tmp_path / f"{boundary}.ssp", boundary=boundary)
        ssd = read_ssd(str(path), validate=True)
        assert len(ssd.system.elements) == POINTS + 1
        assert {u.name: u.factor for u in ssd.units}["MPa"] in {1e6, "1000000.0"}
        assert bool(ssd.system.connectors) == boundary


def test_a_friction_model_alone(tmp_path: Path) -> None:
    from fmpy.ssp.ssd import read_ssd

    for boundary in (False, True):
        path = pack_ssp(ConstantFriction(0.07), tmp_path / f"{boundary}.ssp", boundary=boundary)
        assert read_ssd(str(path), validate=True).name == "friction"
        run = Master(System.load(path)).run(tmp_path / f"run-{boundary}")
        np.testing.assert_allclose(run["friction.mu"], 0.07)
    with pytest.raises(InputError, match=r"allowed: '\.ssp'"):
        pack_ssp(ConstantFriction(0.07), tmp_path / "x.zip")


def test_unpacked_folders_go_with_the_last_system(fmu: dict[str, Path], tmp_path: Path) -> None:
    loaded = System.load(system(fmu, "all").export(tmp_path / "system.ssp"))
    place = loaded.fmu_path("friction")
    copies = [copy.deepcopy(loaded), loaded.swap("friction", fmu["constant"])]
    borrowed = pickle.loads(pickle.dumps(loaded))  # noqa: S301 - as another process gets it
    assert borrowed.fmu_path("friction") == place
    del loaded, borrowed
    assert place.is_file()
    del copies
    assert not place.exists()


def ssd(body: str, head: str = "") -> bytes:
    spaces = "http://ssp-standard.org/SSP1/SystemStructure"
    return (
        f'<?xml version="1.0"?>{head}<ssd:SystemStructureDescription version="1.0" name="x" '
        f'xmlns:ssd="{spaces}Description" xmlns:ssc="{spaces}Common" xmlns:ssv="{spaces}ParameterValues">'
        f'<ssd:System name="s">{body}</ssd:System></ssd:SystemStructureDescription>'
    ).encode()


def component(name: str, source: str = "resources/x.fmu", inside: str = "") -> str:
    return f'<ssd:Elements><ssd:Component name="{name}" source="{source}">{inside}</ssd:Component></ssd:Elements>'


def values(inside: str) -> str:
    return (
        "<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues><ssv:ParameterSet><ssv:Parameters>"
        f'<ssv:Parameter name="p">{inside}</ssv:Parameter></ssv:Parameters></ssv:ParameterSet></ssd:ParameterValues>'
        "</ssd:ParameterBinding></ssd:ParameterBindings>"
    )


LINK = (
    '<ssd:Connection startElement="a" startConnector="y" endElement="{}" endConnector="u">{}</ssd:Connection>'
)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (None, "no SystemStructure.ssd"),
        (b"<x", "not readable XML"),
        (b"<x/>", "allowed: an SSP 1.0 system structure"),
        (ssd("", '<!DOCTYPE a [<!ENTITY b "c">]>'), "document type"),
        (ssd(""), "has no components"),
        (ssd(component("a", "/etc/passwd")), "'/etc/passwd', which is not in the archive"),
        (ssd(component("a", "../x.fmu")), r"'\.\./x\.fmu', which is not in the archive"),
        (ssd(component("a", "http://x/y.fmu")), "not in the archive"),
        (ssd(component("a", DESCRIPTION)), "allowed: an FMU in the archive"),
        (ssd(component("a.b")), r"component name 'a\.b'"),
        (ssd(component("a") + component("a")), "'a' stands twice"),
        (ssd('<ssd:Elements><ssd:System name="t"/></ssd:Elements>'), "nested systems"),
        (ssd(component("a") + f"<ssd:Connections>{LINK.format('b', '')}</ssd:Connections>"), "'b', which is no"),
        (
            ssd(component("a") + f"<ssd:Connections>{LINK.format('a', '<ssc:LinearTransformation/>')}</ssd:Connections>"),
            "transforms values",
        ),
        (ssd(component("a", inside=values('<ssv:Real value="nan"/>'))), "'nan', allowed: Real"),
        (ssd(component("a", inside=values('<ssv:Integer value="1.5"/>'))), "'1.5', allowed: Integer"),
        (ssd(component("a", inside=values('<ssv:Binary value="00"/>'))), "type 'Binary'"),
    ],
)  # fmt: skip
def test_foreign_and_hostile_archives_are_refused(tmp_path: Path, content: bytes | None, said: str) -> None:
    files = {"resources/x.fmu": b"not looked at"} | ({DESCRIPTION: content} if content is not None else {})
    path = write_archive(tmp_path / "x.ssp", files)
    with pytest.raises(InputError, match=said) as seen:
        System.load(path)
    assert str(path) in str(seen.value)


def test_a_broken_fmu_inside_is_named(tmp_path: Path) -> None:
    path = write_archive(tmp_path / "x.ssp", {"resources/x.fmu": b"?", DESCRIPTION: ssd(component("a"))})
    with pytest.raises(InputError, match=r"x\.fmu: not an FMU"):
        System.load(path)
    with pytest.raises(InputError, match="no such file"):
        System.load(tmp_path / "nowhere.ssp")
    (tmp_path / "garbage.ssp").write_bytes(b"\0" * 50)
    with pytest.raises(InputError, match=r"garbage\.ssp: not an SSP"):
        System.load(tmp_path / "garbage.ssp")


def test_omsimulator_finds_its_annotation_first(fmu: dict[str, Path], tmp_path: Path) -> None:
    """It takes the first annotation for its own, whatever its type says, and aborts on another one."""
    alone = pack_ssp(ConstantFriction(0.07), tmp_path / "alone.ssp")
    for path in (alone, system(fmu, "all").export(tmp_path / "system.ssp")):
        with zipfile.ZipFile(path) as archive:
            root = etree.fromstring(archive.read(DESCRIPTION))
        first = next(e for e in root.iter() if etree.QName(e).localname == "Annotation")
        assert first.get("type") == "org.openmodelica"
        master = next(e for e in first.iter() if etree.QName(e).localname == "FixedStepMaster")
        assert float(master.get("stepSize")) == System.load(path).communication_step


def test_inputs_of_the_system_have_start_values(fmu: dict[str, Path], tmp_path: Path) -> None:
    def told(path: Path) -> dict[str, float]:
        """Return the start values of the system's inputs, as the archive says them."""
        with zipfile.ZipFile(path) as archive:
            root = etree.fromstring(archive.read(DESCRIPTION))
        (inside,) = (e for e in root if etree.QName(e).localname == "System")
        names = {c.get("name") for c in inside.iterfind("{*}Connectors/{*}Connector[@kind='input']")}
        values = inside.iterfind("{*}ParameterBindings//{*}Parameter")
        found = {v.get("name"): float(v[0].get("value")) for v in values}
        assert names == found.keys()
        linked = {
            c.get("startConnector") for c in inside.iterfind("{*}Connections/*") if not c.get("startElement")
        }
        assert linked == names
        return found

    alone = pack_ssp(ConstantFriction(0.07), tmp_path / "alone.ssp", boundary=True)
    assert told(alone) == {"v_rel": 50.0, "T": 80.0, "sigma_n": 1000.0, "sd": 10.0, "psi": 1.2}
    connections = [f"process.{q} -> friction.{q}" for q in LOAD_NAMES if q != "T"] + [
        "friction.mu -> process.mu"
    ]
    open_ = System.from_dict(
        {
            "communication_step": STEP,
            "stop_time": STEP * STEPS,
            "components": {
                "friction": {"fmu": str(fmu["one"]), "start": {"T": 77.0}},
                "process": {"fmu": str(fmu["process"])},
            },
            "connections": connections,
            "record": ["process.force"],
        }
    )
    path = open_.export(tmp_path / "open.ssp", boundary=True)
    assert told(path) == {f"friction_{k + 1}_T": 77.0 for k in range(POINTS)}
    wanted = Master(open_).run(tmp_path / "a")["process.force"]
    np.testing.assert_array_equal(Master(System.load(path)).run(tmp_path / "b")["process.force"], wanted)
    # What the archive says about the system's input holds, not what it says about the component.
    with zipfile.ZipFile(path) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    root = etree.fromstring(files[DESCRIPTION])
    (value,) = root.xpath(
        "//*[local-name()='System']/*[1]/following-sibling::*//*[@name='friction_2_T']/*[@value]"
    )
    value.set("value", "277.0")
    files[DESCRIPTION] = etree.tostring(root)
    other = Master(System.load(write_archive(tmp_path / "other.ssp", files))).run(tmp_path / "c")[
        "process.force"
    ]
    assert np.all(np.abs(other - wanted)[1:] > 1e-6)


def test_archives_say_what_they_were_made_of(
    fmu: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    made = system(fmu, "one")
    made.provenance["author"] = "A. Maker"
    with zipfile.ZipFile(made.export(tmp_path / "one.ssp")) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    digests = {name: hashlib.sha256(content).hexdigest() for name, content in files.items()}
    folder = "extra/org.ssp-standard.ssp-traceability"
    space = "{http://ssp-standard.org/SSPTraceability1/"
    entry = f"{space}SSPTraceabilityCommon}}ClassificationEntry"

    task = etree.fromstring(files[f"{folder}.stmd/SimulationTask.stmd"])
    whole = etree.fromstring(files[f"{folder}.srmd/resourceMetaData.srmd"])
    assert task.tag == f"{space}SimulationTaskMetaData}}SimulationTaskMetaData"
    assert whole.tag == f"{space}SimulationResourceMetaData}}SimulationResourceMetaData"
    for root in (task, whole):
        assert (root.get("version"), root.get("name")) == ("1.0.0-rc.2", "extrusion & test")
        assert (root.get("author"), root.get("generationTool")) == ("A. Maker", "tribofmu")
        assert root.get("generationDateAndTime") == "1970-01-02T00:00:00Z"
    told = {e.get("keyword"): e.text for e in whole.iter(entry)}
    resources = {r.get("source"): r for r in task.iter(f"{space}SSPTraceabilityCommon}}Resource")}
    names = ["resources/friction.fmu", "resources/process.fmu", DESCRIPTION]
    assert list(resources) == [f"../../{name}" for name in names]
    for name in names:
        found = {e.get("keyword"): e.text for e in resources[f"../../{name}"].iter(entry)}
        assert found["sha256"] == told[f"sha256.{name}"] == digests[name]
    friction = {e.get("keyword"): e.text for e in resources["../../resources/friction.fmu"].iter(entry)}
    assert friction["generationTool"] == "tribofmu" and friction["fmiVersion"] == "2.0"
    assert friction["components"] == " ".join(f"friction_{k + 1}" for k in range(POINTS))

    # Another content is another task; without the variable no time is told.
    monkeypatch.delenv("SOURCE_DATE_EPOCH")
    with zipfile.ZipFile(system(fmu, "scalars").export(tmp_path / "other.ssp")) as archive:
        other = etree.fromstring(archive.read(f"{folder}.stmd/SimulationTask.stmd"))
    assert other.get("GUID") != task.get("GUID") and other.get("generationDateAndTime") is None
