"""Campaigns of rigs that nobody here knows: which column is which, which file is which test, what test tables say."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from typer.testing import CliRunner

from friction_models.common import InputError
from orchestrator.cli.app import app
from sct_twin import SctRecord
from sct_twin.ingest.campaign_files import ingest
from sct_twin.ingest.channel_guess import draft
from sct_twin.ingest.channel_map import ChannelMap
from sct_twin.ingest.measurement_files import NameTemplate, proposed
from sct_twin.ingest.preview import preview, shortened
from sct_twin.ingest.quality import quality_row, warnings
from sct_twin.ingest.raw_campaign import read_test_table
from sct_twin.readers import RawTable
from sct_twin.virtual_lab.rig.file_formats import FORMATS

Maker = Callable[..., SctRecord]

#: Columns of rigs and what each of them is; what is missing there has to be asked about, or is no channel.
RIGS: dict[str, tuple[dict[str, str], dict[str, str]]] = {
    "German": (
        {
            "Zeit": "s",
            "Normalkraft": "kN",
            "Reibkraft": "kN",
            "Weg": "mm",
            "Geschwindigkeit": "mm/s",
            "Plattentemperatur": "°C",
            "Werkzeugtemperatur": "°C",
            "Probentemperatur": "°C",
        },
        {
            "t": "Zeit",
            "F_n": "Normalkraft",
            "F_r": "Reibkraft",
            "s": "Weg",
            "v": "Geschwindigkeit",
            "T_plate": "Plattentemperatur",
        },
    ),
    "abbreviated": (
        {
            "Messzeit": "ms",
            "FN Ist": "N",
            "FN Soll": "N",
            "FR": "N",
            "s_Platte": "mm",
            "Gleitgeschw.": "mm/s",
            "Temp.Pl.": "°C",
            "Reibwert": "-",
        },
        {
            "t": "Messzeit",
            "F_n": "FN Ist",
            "F_r": "FR",
            "s": "s_Platte",
            "v": "Gleitgeschw.",
            "T_plate": "Temp.Pl.",
        },
    ),
    "two strokes": (
        {
            "Zeit": "s",
            "Stempelkraft": "kN",
            "Zugkraft": "kN",
            "Stempelweg": "mm",
            "Schlittenweg": "mm",
            "Temp": "°C",
        },
        {"t": "Zeit", "F_n": "Stempelkraft", "F_r": "Zugkraft", "s": "Schlittenweg", "T_plate": "Temp"},
    ),
    "English": (
        {
            "Time": "s",
            "Normal Force": "lbf",
            "Friction Force": "lbf",
            "Friction Coefficient": "-",
            "Position": "in",
        },
        {"t": "Time", "F_n": "Normal Force", "F_r": "Friction Force", "s": "Position"},
    ),
    "numbered cells": (
        {
            "Zeit": "s",
            "Kraft 1": "kN",
            "Kraft 2": "kN",
            "Weg 1": "mm",
            "Weg 2": "mm",
            "T_1": "°C",
            "T_2": "°C",
        },
        {"t": "Zeit"},
    ),
    "one force": (
        {"Zeit": "s", "Kraft": "kN", "Reibungskraft": "kN", "Verschiebung": "mm"},
        {"t": "Zeit", "F_r": "Reibungskraft", "s": "Verschiebung"},
    ),
    "units in the names": (
        dict.fromkeys(
            ("t_s", "load_N", "load_nominal_N", "F_r_kN", "sliding_distance_um", "v_um_s", "T_plate_K"), ""
        ),
        {
            "t": "t_s",
            "F_n": "load_N",
            "F_r": "F_r_kN",
            "s": "sliding_distance_um",
            "v": "v_um_s",
            "T_plate": "T_plate_K",
        },
    ),
    "no units": (
        {"t": "", "F_N": "", "F_R": "", "x": "", "T": ""},
        {"t": "t", "F_n": "F_N", "F_r": "F_R", "s": "x", "T_plate": "T"},
    ),
    **{
        f"virtual rig, {name}": (
            {column.name: column.unit for column in form.columns.values()},
            {channel: column.name for channel, column in form.columns.items()},
        )
        for name, form in FORMATS.items()
    },
}


def table(units: dict[str, str]) -> RawTable:
    return RawTable(pd.DataFrame({name: [0.0, 1.0] for name in units}), units, "rig.csv")


@pytest.mark.parametrize("rig", RIGS)
def test_what_a_column_is_called_says_what_it_is(rig: str) -> None:
    units, expected = RIGS[rig]
    found = yaml.safe_load(draft(table(units)))["channels"]
    assert {entry["quantity"]: name for name, entry in found.items()} == expected


def test_what_is_open_is_asked_with_the_columns_named() -> None:
    text = draft(table(RIGS["numbered cells"][0]))
    for question in (
        "F_n (normal force): is it 'Kraft 1' or 'Kraft 2'?",
        "F_r (force that drives the plate): is it 'Kraft 1' or 'Kraft 2'?",
        "s (plate position): is it 'Weg 1' or 'Weg 2'?",
        "T_plate (plate temperature): is it 'T_1' or 'T_2'?",
        "no column found for a (plate acceleration): it can be missing",
    ):
        assert question in text
    # Answers are given by taking marks away.
    for line in ("Kraft 2: {quantity: F_n}", "Kraft 1: {quantity: F_r}", "Weg 1: {quantity: s}"):
        assert f"  # {line}" in text
        text = text.replace(f"  # {line}", f"  {line}")
    columns = ChannelMap.load(yaml.safe_load(text)).columns
    assert columns is not None and columns["Kraft 2"].quantity == "F_n"


def test_units_that_nobody_wrote_down_are_asked_for() -> None:
    found = yaml.safe_load(draft(table(RIGS["units in the names"][0])))["channels"]
    units = {
        "t_s": "s",
        "load_N": "N",
        "F_r_kN": "kN",
        "sliding_distance_um": "um",
        "v_um_s": "um/s",
        "T_plate_K": "K",
    }
    assert {name: entry["unit"] for name, entry in found.items()} == units
    text = draft(table(RIGS["no units"][0]))
    assert {entry["unit"] for entry in yaml.safe_load(text)["channels"].values()} == {"?"}
    assert "write it in place of ?" in text
    with pytest.raises(InputError, match=r"unknown unit of column 't' '\?'; allowed: .*s, us"):
        ChannelMap.load(yaml.safe_load(text))


def test_a_data_set_needs_no_ingest(tmp_path: Path) -> None:
    (tmp_path / "points.csv").write_text("test_id,t,v_rel,T,sigma_n,sd,psi,mu\n")
    with pytest.raises(InputError, match=r"holds points of friction .* as they are \(--data\)"):
        preview(tmp_path)


def ends_unloaded(record: SctRecord, sign: float) -> SctRecord:
    """A record from 0.6 s on, when the load is up, and with 0.3 s behind it in which the load is taken off."""
    begin, rest = 600, np.arange(300)
    load = np.concatenate([record.F_n[begin:], np.maximum(0.0, 1.0 - rest / 100.0) * 94e3 + 25.0 + rest % 3])

    def held(values: np.ndarray | None, end: float) -> np.ndarray:
        assert values is not None
        return np.concatenate([values[begin:], np.full(len(rest), end)])

    assert record.s is not None
    return replace(
        record,
        t=np.arange(len(load)) / 1000.0,
        F_n=sign * load,
        F_r=held(record.F_r, -40.0),
        s=held(record.s, record.s[-1]),
        a=held(record.a, 0.0),
        T_plate=held(record.T_plate, 20.0),
    )


def test_a_record_that_begins_under_load(record_maker: Maker) -> None:
    record = ends_unloaded(record_maker(noise=1.0), 1.0)
    row = quality_row(record, 25.0)
    # The made-up friction is 0.08, the made-up zero 25 N.
    assert row["mu_mean"] == pytest.approx(0.08, abs=2e-4)
    assert row["F_n_zero_N"] is None and row["F_n_zero_end_N"] == pytest.approx(26.0, abs=2.0)
    assert "begins under load" in " ".join(warnings({**row, "notes": ""}))
    with pytest.raises(InputError, match="set sign: -1"):
        quality_row(ends_unloaded(record_maker(noise=1.0), -1.0))


TABLES = {
    "comma": "test_id,v_set,T_tool,lubricant\n007,50,20.5,MoS2\n008,5,,dry\n",
    "semicolon, decimal comma": "test_id;v_set;T_tool;lubricant\n007;50;20,5;MoS2\n008;5;;dry\n",
    "tab": "test_id\tv_set\tT_tool\tlubricant\n007\t50\t20.5\tMoS2\n008\t5\t\tdry\n",
    "preamble, units, padding": "Versuchsplan;;;;;\n;;;;;\ntest_id;v_set;T_tool;lubricant;;\n;mm/s;°C;-;;\n"
    "007;50;20,5;MoS2;;\n;;;;;\n008;5;;dry;;\n",
    "units in brackets": 'test_id;v_set [mm/s];"T_tool [°C]";lubricant\r\n007;50;"20,5";"MoS2"\r\n008;5;;dry\r\n',
}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252", "utf-16", "utf-32"])
@pytest.mark.parametrize("kind", TABLES)
def test_test_tables_in_every_spelling(tmp_path: Path, kind: str, encoding: str) -> None:
    path = tmp_path / "tests.csv"
    path.write_bytes(TABLES[kind].encode(encoding))
    found = read_test_table(path)
    assert list(found.columns) == ["test_id", "v_set", "T_tool", "lubricant"]
    assert found["test_id"].tolist() == ["007", "008"] and found["v_set"].tolist() == [50, 5]
    assert found["T_tool"].iloc[0] == 20.5 and np.isnan(found["T_tool"].iloc[1])
    assert found["lubricant"].tolist() == ["MoS2", "dry"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Versuch;v\n7;5\n", "column 'test_id' is missing; present: Versuch, v"),
        ("test_id;v\n7;5\n;6\n", "row 1 has no test_id; allowed: a name in every row"),
        ("test_id;v\n7;5;9\n", "row 0 has the value '9' in column 3, the header names 2; allowed"),
        ("test_id;v\n", "the table has no rows"),
        ("test_id;v;v\n7;5;9\n", "column 'v' stands twice"),
        ("test_id;T_tool [bar]\n7;293\n", "unit"),
        ("test_id;v\n7;5\n7;6\n", "test_id '7' stands in two rows"),
        ("", "the file is empty"),
    ],
)
def test_test_tables_that_are_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "tests.csv"
    path.write_text(text)
    with pytest.raises(InputError) as error:
        read_test_table(path)
    assert message in str(error.value) and "tests.csv" in str(error.value)


def test_units_of_test_tables_are_converted(tmp_path: Path) -> None:
    path = tmp_path / "tests.csv"
    path.write_text("test_id;T_tool [K];v_set [m/s]\n7;293,15;0,05\n")
    row = read_test_table(path).iloc[0]
    assert row["T_tool"] == pytest.approx(20.0) and row["v_set"] == pytest.approx(50.0)


@pytest.mark.parametrize(
    ("template", "name", "test"),
    [
        ("SCT_{test_id}_raw", "SCT_017_raw", "017"),
        ("*_V{test_id}_*", "2026-02-01_V12b_50mms_MoS2", "12b"),
        ("????-??-?? {test_id}", "2026-02-01 A 7", "A 7"),
        ("{test_id} (*)", "a (1)", "a"),
    ],
)
def test_a_part_of_the_file_name_is_the_test(template: str, name: str, test: str) -> None:
    names = NameTemplate.load(template, "map")
    assert names is not None and names.test_of(name) == test
    with pytest.raises(InputError, match=r"the name 'other\.name' does not fit"):
        names.test_of("other.name")


@pytest.mark.parametrize("template", ["SCT", "{test_id}{test_id}", 7, "*a*b*c*{test_id}"])
def test_templates_that_are_refused(template: object) -> None:
    with pytest.raises(InputError, match=r"channel map: test_id is .*; allowed: "):
        ChannelMap.load({"test_id": template})


def test_a_template_is_proposed_where_the_table_knows_the_tests() -> None:
    files = [Path(f"2026020{k}_SCT_0{k}_{v}mms.csv") for k, v in ((1, 50), (2, 5), (3, 55))]
    assert proposed(["01", "02", "03"], files) == "*_SCT_{test_id}_*"
    assert proposed(["A"], files) is None


def test_files_get_the_names_of_the_test_table(tmp_path: Path, record_maker: Maker) -> None:
    rig = tmp_path / "rig"
    rig.mkdir()
    for name in ("SCT_007_raw", "SCT_008_raw", "notes_on_SCT"):
        record_maker(noise=1.0).save(rig / f"{name}.csv")
    (rig / "tests.csv").write_text("test_id;v_set;T_tool\n007;50;20,5\n008;50;20,5\n")
    shown = " ".join(preview(rig).split())
    assert "test '007' of the test table has no file" in shown and "not in the test table" in shown
    assert "test_id: 'SCT_{test_id}_raw'" in shown
    without = {"channels": {name: name for name in ("t", "F_n", "F_r", "s")}}
    assert "test 'SCT_007_raw' is not in the test table" in " ".join(preview(rig, without).split())
    report = ingest(rig, {"test_id": "SCT_{test_id}_raw"}, tmp_path / "out")
    assert report.campaign.tests["test_id"].tolist() == ["007", "008"]
    assert report.campaign.tests["T_tool"].tolist() == [20.5, 20.5]
    assert "the name 'notes_on_SCT' does not fit test_id" in " ".join(report.left_out["reason"])
    command = ["ingest", str(rig), "--test-id", "SCT_00{test_id}_raw", "-o", str(tmp_path / "second")]
    run = CliRunner().invoke(app, command)
    # The option goes before the map; 7 is not 007.
    assert run.exit_code == 0 and "(is it '007' there?)" in " ".join(run.output.split())
    assert (tmp_path / "second" / "raw" / "7.csv").is_file()


@pytest.mark.parametrize(
    ("tests", "stems", "template"),
    [
        (
            ["017", "018"],
            ["2026-03-01_Rig2_Versuch017_a", "2026-03-02_Rig1_Versuch018_b"],
            "*_Versuch{test_id}_*",
        ),
        (["017", "018"], ["V017", "V018"], "V{test_id}"),
        (["017", "018"], ["SCT_017_raw", "SCT_018_raw"], "SCT_{test_id}_raw"),
        (["17", "18"], ["V0170", "V0180"], None),
    ],
)
def test_a_number_behind_letters_is_found(tests: list[str], stems: list[str], template: str | None) -> None:
    assert proposed(tests, [Path(f"{stem}.csv") for stem in stems]) == template


@pytest.mark.parametrize("room", [8, 9, 12, 20])
def test_names_stay_apart_when_they_are_cut(room: int) -> None:
    for names in (
        ["Versuch_001_platte_A_50mms", "Versuch_002_platte_A_50mms", "test", ""],
        ["campaign_x_a_1", "campaign_x_b_1", "campaign_x_b_2"],
    ):
        short = shortened(names, room)
        assert len(set(short)) == len(names)
        assert max(map(len, short)) <= room
    # Where nothing that short tells them apart, they are not cut.
    far = [f"{a}{'-' * 30}{b}{'-' * 30}" for a in "xy" for b in "12"]
    assert shortened(far, room) == far


def test_a_rig_from_its_export_to_friction(tmp_path: Path, record_maker: Maker) -> None:
    """A spreadsheet's export, the map that the dry run drafts, and the friction that was put in."""

    def cell(value: float, digits: int) -> str:
        return f"{value:,.{digits}f}".replace(",", "x").replace(".", ",").replace("x", ".")

    record = record_maker(noise=1.0, mass=0.0)
    assert record.s is not None and record.T_plate is not None
    head = ["Messprotokoll;;;;;", "Prüfer;Meier;;;;", "Probe;15,00;mm;;;", ";;;;;"]
    head += ["Zeit;Normalkraft;Reibkraft;Weg;Plattentemperatur;", "s;N;N;mm;°C;"]
    rows = zip(record.t, record.F_n, record.F_r, record.s, record.T_plate)
    body = [";".join(map(cell, row, (3, 1, 2, 4, 1))) + ";" for row in rows]
    rig = tmp_path / "rig"
    rig.mkdir()
    text = "\r\n".join([*head, *body, ";;;;;", "Ende der Messung;;;;;"])
    (rig / "2026-02-01_Versuch 017.csv").write_bytes(text.encode("cp1252"))
    (rig / "tests.csv").write_bytes("test_id;v_set;T_tool\r\n017;50,0;20,0\r\n".encode("cp1252"))
    shown = preview(rig)
    mapping = yaml.safe_load(shown[shown.index("channels:") :])
    (tmp_path / "channels.yaml").write_text(yaml.safe_dump({**mapping, "test_id": "*_Versuch {test_id}"}))
    command = ["ingest", str(rig), "--map", str(tmp_path / "channels.yaml"), "-o", str(tmp_path / "out")]
    run = CliRunner().invoke(app, command)
    assert run.exit_code == 0 and "1 test in" in run.output and "0 left out" in run.output
    assert "2 lines behind the numbers passed over: 'Ende der Messung'" in " ".join(run.output.split())
    quality = pd.read_csv(tmp_path / "out" / "quality.csv", dtype={"test_id": str}).iloc[0]
    assert quality["test_id"] == "017" and quality["rows"] == len(record.t)
    assert quality["mu_mean"] == pytest.approx(0.08, abs=3e-4)
