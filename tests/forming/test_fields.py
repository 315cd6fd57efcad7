"""Fields of a forming run: snapshots, VTU and PVD, pictures, animation, the page and the folder of a result."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ElementTree
import zipfile
from dataclasses import replace

import meshio
import numpy as np
import pytest

from forming import BackwardCupExtrusion, ForwardRodExtrusion
from forming.fe.mesh.shape import gauss_volumes
from forming.results.field_recorder import (
    FIELDS_EVERY,
    FIELDS_FOLDER,
    FieldWriter,
    writer_from_environment,
)
from forming.results.fields import FieldHistory
from forming.results.files import load_result
from forming.results.pictures.animation import animation
from forming.results.pictures.drawing import Window, tool_polygon
from forming.results.pictures.picture import subdivided
from forming.results.snapshot import CONTACT_FIELDS, ELEMENT_FIELDS, FIELDS
from friction_models.common import InputError

COARSE = {"mesh_size": 0.7, "n_points": 50}


@pytest.fixture(scope="module")
def plain():
    return ForwardRodExtrusion(**COARSE).run(0.08, 4.0)


@pytest.fixture(scope="module")
def kept():
    return ForwardRodExtrusion(**COARSE).run(0.08, 4.0, snapshots=9)


def test_keeping_fields_changes_no_bit_of_the_run(plain, kept):
    assert len(plain.fields) == 0
    for name in ("stroke", "force", "work"):
        assert np.array_equal(getattr(plain, name), getattr(kept, name))
    for name in ("loads", "mu", "position", "tau_over_k", "active"):
        assert np.array_equal(getattr(plain.contact, name), getattr(kept.contact, name))
    assert plain.increments == kept.increments and plain.energy_balance == kept.energy_balance


def test_snapshots_stand_at_the_strokes_asked_for(kept):
    assert np.allclose(kept.fields.strokes, np.linspace(0.0, 4.0, 9), atol=0.1)
    assert kept.fields.strokes[-1] == pytest.approx(4.0)
    listed = ForwardRodExtrusion(**COARSE).run(0.08, 0.5, snapshots=[0.3, 0.1])
    assert np.allclose(listed.fields.strokes, [0.1, 0.3], atol=0.021)
    assert (listed.fields.strokes >= np.array([0.1, 0.3]) - 1e-9).all()


def test_fields_are_those_of_the_run(kept):
    """The axial stress below the punch, and the contact pressure on it, carry the punch force."""
    last = kept.fields.at()
    assert np.isfinite(last.elements).all() and last.contact[:, 0].max() > 500.0
    assert last.nodal("T").min() > 15.0 and last.nodal("T").max() < 300.0
    assert last.nodal("strain").max() > 0.6
    names = [f.name for f in ELEMENT_FIELDS]
    stress = last.elements[:, names.index("sigma_rr") : names.index("sigma_tt") + 1]
    assert np.allclose(stress.mean(axis=1), last.elements[:, names.index("sigma_m")], rtol=1e-4, atol=0.1)
    middle = last.x[last.quads].mean(axis=1)
    top = middle[:, 1] > last.x[:, 1].max() - 1.0
    volume = gauss_volumes(last.x.astype(float), last.quads.astype(np.int64)).sum(axis=1)[top]
    axial = volume @ last.elements[top, names.index("sigma_zz")] / volume.sum()
    assert -1e-3 * axial * np.pi * 10.0**2 == pytest.approx(kept.force[-1], rel=0.03)
    # Contact pressure against the mean axial stress, away from the edge of the punch.
    face = (last.x[last.chain, 1] > last.x[:, 1].max() - 0.05) & (last.x[last.chain, 0] < 8.0)
    assert last.contact[face, 0].mean() == pytest.approx(-axial, rel=0.05)


def test_tau_over_k_is_kept_for_each_marker(kept):
    contact = kept.contact
    on = contact.active
    assert (contact.tau_over_k[~on] == 0.0).all() and (contact.tau_over_k >= 0.0).all()
    assert 0.1 < contact.tau_over_k.max() <= 1.05 * kept.max_tau_over_k
    assert "tau_over_k" in contact.to_frame().columns


def test_vtu_files_read_back(kept, tmp_path):
    collection = kept.fields.write_vtu(tmp_path / "fields")
    entries = ElementTree.parse(collection).getroot().findall("./Collection/DataSet")
    times = sorted({float(e.get("timestep")) for e in entries})
    assert np.allclose(times, [s.time for s in kept.fields.snapshots])
    assert len(entries) == 3 * len(kept.fields)
    parts = {e.get("part"): e.get("file") for e in entries if float(e.get("timestep")) == times[-1]}
    last = kept.fields.at()
    body = meshio.read(tmp_path / "fields" / parts["0"])
    assert np.array_equal(body.points[:, :2], last.x) and np.array_equal(body.cells_dict["quad"], last.quads)
    assert np.array_equal(body.point_data["T [degC]"], last.T)
    assert np.array_equal(body.cell_data["sigma_m [MPa]"][0], last.elements[:, 3])
    contact = meshio.read(tmp_path / "fields" / parts["1"])
    assert np.array_equal(contact.point_data["tau_over_k"], last.contact[:, 3])
    tools = meshio.read(tmp_path / "fields" / parts["2"])
    assert set(tools.cell_data["tool"][0]) == set(range(1, len(last.tools) + 1))


def test_result_folder_reads_back_and_is_replaced(kept, tmp_path):
    for _ in range(2):
        kept.save(tmp_path / "run", "a <name>")
    read, name = load_result(tmp_path / "run")
    assert name == "a <name>" and read.increments == kept.increments and read.status == "ok"
    assert np.allclose(read.force, kept.force, rtol=1e-8, atol=1e-9)
    assert np.array_equal(read.contact.loads, kept.contact.loads)
    assert np.array_equal(read.contact.tau_over_k, kept.contact.tau_over_k)
    assert np.array_equal(read.fields.at().elements, kept.fields.at().elements)
    assert set(read.fields.at().tools) == set(kept.fields.at().tools)


def test_damaged_files_are_refused_in_one_sentence(kept, tmp_path, monkeypatch):
    path = kept.fields.save(tmp_path / "f.npz")
    whole = path.read_bytes()
    for damage in (whole[:2000], b"", b"no archive", whole[:300] + b"\0" * 400 + whole[700:]):
        path.write_bytes(damage)
        with pytest.raises(InputError, match=r"f\.npz"):
            FieldHistory.load(path)
    snapshot = kept.fields.at()
    wrong = replace(snapshot, quads=snapshot.quads + len(snapshot.x))
    FieldHistory((wrong,)).save(path)
    with pytest.raises(InputError, match="out of range"):
        FieldHistory.load(path)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("T.npy", "w") as member:
        for _ in range(60):
            member.write(bytes(1_000_000))
    monkeypatch.setattr("forming.results.fields._LARGEST", 50_000_000)
    with pytest.raises(InputError, match="bytes unpacked"):
        FieldHistory.load(path)
    kept.save(tmp_path / "run")
    (tmp_path / "run" / "forming.json").write_text('{"force": 1}')
    with pytest.raises(InputError, match=r"run"):
        load_result(tmp_path / "run")


def test_drawing_shows_workpiece_tools_and_scale(kept, tmp_path):
    path = kept.picture(tmp_path / "strain.svg", "strain", stroke=2.0)
    root = ElementTree.parse(path).getroot()
    text = " ".join(t.text or "" for t in root.iter("{http://www.w3.org/2000/svg}text"))
    assert "Equivalent plastic strain" in text and "stroke 2.0" in text and "mm" in text
    corners, values = subdivided(kept.fields.at(), "strain")
    assert len(corners) == len(values) == 9 * len(kept.fields.at().quads)
    strain = kept.fields.at().nodal("strain")
    assert values.min() >= strain.min() and values.max() <= strain.max()


@pytest.mark.parametrize("process", [ForwardRodExtrusion, BackwardCupExtrusion])
def test_tools_are_drawn_outside_the_workpiece(process):
    result = process(**COARSE).run(0.08, 0.5, snapshots=[0.5])
    snapshot = result.fields.at()
    inside = snapshot.x[snapshot.quads].mean(axis=1)
    window = Window.around(result.fields.snapshots)
    for name, chain in snapshot.tools.items():
        outline = tool_polygon(chain)
        covered = _inside(outline, inside)
        assert not covered.any(), f"{name} covers {covered.sum()} elements"
        corners = np.array([[r, z] for r in (0.0, window.r_max) for z in (window.z_min, window.z_max)])
        assert _inside(outline, corners).any() or name == "sleeve", name


def _inside(outline, points):
    a, b = outline, np.roll(outline, -1, axis=0)
    r, z = points[:, :1], points[:, 1:]
    crosses = (a[:, 1] > z) != (b[:, 1] > z)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = a[:, 0] + (z - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
    return (crosses & (r < at)).sum(axis=1) % 2 == 1


def _no_network(text):
    assert not re.search(r"""(?:src|href)\s*=\s*["'](?!#)""", text)
    assert not re.search(r"\b(?:fetch|XMLHttpRequest|import)\s*\(|@import|url\(", text)
    assert set(re.findall(r"https?://[^\s\"']+", text)) <= {"http://www.w3.org/2000/svg"}


def test_report_holds_all_frames_and_no_link(kept, tmp_path):
    text = kept.report(tmp_path / "r.html", "x</script><b>").read_text()
    _no_network(text)
    data = json.loads(re.search(r'<script type="application/json">(.*?)</script>', text, re.S).group(1))
    assert [f["stroke"] for f in data["frames"]] == pytest.approx(kept.fields.strokes.tolist())
    assert len(data["fields"]) == len(FIELDS) and "<b>" not in text
    assert len(text) < 3_000_000
    page = kept.picture(tmp_path / "p.html", "T", stroke=0.0).read_text()
    _no_network(page)
    assert '"frame":0' in page


def test_animation_stays_within_its_size(kept):
    whole = animation(kept.fields)
    small = animation(kept.fields, largest=len(whole) // 3)
    assert len(small) < 0.5 * len(whole)
    data = json.loads(re.search(r'<script type="application/json">(.*?)</script>', small, re.S).group(1))
    assert 1 <= len(data["frames"]) < len(kept.fields) and data["frame"] == len(data["frames"]) - 1


def test_writer_takes_back_what_was_rolled_back(tmp_path):
    process, writer = ForwardRodExtrusion(**COARSE), FieldWriter(tmp_path, "fre", 0.1)
    process.start(0.08)
    writer.begin(process.simulation)
    assert process.advance(0.2, writer)
    saved = process.snapshot()
    process.set_mu(0.3)
    assert process.advance(0.3, writer)
    first = FieldHistory.load(tmp_path / "fre")
    process.restore(saved)
    process.set_mu(0.02)
    assert process.advance(0.2, writer)
    again = FieldHistory.load(tmp_path / "fre")
    assert first.strokes[-1] == pytest.approx(0.5) and again.strokes[-1] == pytest.approx(0.4)
    assert (np.diff(again.strokes) > 0.0).all() and (again.at().contact[:, 2] == np.float32(0.02)).all()
    other = FieldWriter(tmp_path, "fre", 0.1)
    other.begin(process.simulation)
    assert (tmp_path / "fre-2" / "0000.npz").is_file()


def test_environment_asks_for_fields(monkeypatch, tmp_path):
    monkeypatch.delenv(FIELDS_FOLDER, raising=False)
    assert writer_from_environment("fre") is None
    monkeypatch.setenv(FIELDS_FOLDER, str(tmp_path))
    assert writer_from_environment("fre").wanted[1] == 0.5
    for bad in ("nan", "-1", "often"):
        monkeypatch.setenv(FIELDS_EVERY, bad)
        with pytest.raises(InputError, match=FIELDS_EVERY):
            writer_from_environment("fre")
    monkeypatch.delenv(FIELDS_EVERY)
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(FIELDS_FOLDER, str(tmp_path / "file"))
    process = ForwardRodExtrusion(**COARSE)
    process.start()
    with pytest.raises(InputError, match="cannot be written"):
        writer_from_environment("fre").begin(process.simulation)


@pytest.mark.parametrize("bad", [1, 2000, True, "many", [], [-0.1], [np.nan], [5.0], [[1.0]]])
def test_impossible_snapshots_are_refused(bad):
    with pytest.raises(InputError, match="snapshot"):
        ForwardRodExtrusion(**COARSE).run(0.08, 0.1, snapshots=bad)


def test_wrong_fields_and_files_are_refused(plain, kept, tmp_path):
    with pytest.raises(InputError, match="no snapshots"):
        plain.picture(tmp_path / "a.svg")
    with pytest.raises(InputError, match="did you mean 'strain'"):
        kept.picture(tmp_path / "a.svg", "strian")
    with pytest.raises(InputError, match=r"\.png; allowed: \.svg, \.html"):
        kept.picture(tmp_path / "a.png")
    assert not list(tmp_path.iterdir())


def test_a_run_that_stops_keeps_where_it_stopped():
    process = ForwardRodExtrusion(**COARSE)
    build = process._build

    def short():
        simulation = build()
        simulation.control = replace(simulation.control, attempts=12)
        return simulation

    process._build = short
    result = process.run(0.08, 4.0, snapshots=3)
    assert result.status == "stopped"
    assert result.fields.strokes[0] == 0.0 and result.fields.strokes[-1] == pytest.approx(result.stroke[-1])
    assert len(CONTACT_FIELDS) == result.fields.at().contact.shape[1]


def test_the_pressure_shown_on_a_face_carries_its_force(kept):
    """Integrated along the face as a viewer would: the punch, whose edge shares its nodes with the container."""
    last = kept.fields.at()
    x, p = last.x[last.chain].astype(float), last.contact[:, 0].astype(float)
    on_punch = x[:, 1] > x[:, 1].max() - 0.02
    a, b = x[:-1], x[1:]
    edge = on_punch[:-1] & on_punch[1:] & (p[:-1] > 0.0) & (p[1:] > 0.0)
    r0, r1, length = a[edge, 0], b[edge, 0], np.hypot(*(b - a)[edge].T)
    ring = 2.0 * np.pi * length * ((2.0 * r0 + r1) * p[:-1][edge] + (r0 + 2.0 * r1) * p[1:][edge]) / 6.0
    assert 1e-3 * ring.sum() == pytest.approx(kept.force[-1], rel=0.01)
    # Where it slides, friction is mu p; the pressure alone is averaged along the contact.
    sliding = (last.contact[:, 4] > 1.0) & (last.contact[:, 3] < 0.9)
    ratio = last.contact[sliding, 1].sum() / last.contact[sliding, 0].sum()
    assert sliding.sum() > 20 and ratio == pytest.approx(0.08, rel=0.01)
