"""A campaign from files of many formats: units, phases, quality, faults, what is shown before."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from typer.testing import CliRunner

from friction_models.loads import InputError
from orchestrator.cli.app import app
from sct_twin import RawCampaign, SctRecord
from sct_twin.channel_map import ChannelMap
from sct_twin.channels import CHANNEL_NAMES, CHANNELS
from sct_twin.ingest import ingest
from sct_twin.preview import preview
from sct_twin.quality import drift, quality_row, repeats, thinned
from sct_twin.readers import guarded
from sct_twin.units import conversion

from .reader_files import SUFFIX, WRITERS, write_plain
from .test_readers import NEEDS

Maker = Callable[..., SctRecord]
UNITS = {name: CHANNELS[name].unit for name in CHANNEL_NAMES}
MDF_MAP = {"channels": {("time" if name == "t" else name): name for name in CHANNEL_NAMES}}


def test_every_format_gives_the_same_campaign(tmp_path: Path, record_maker: Maker) -> None:
    record = record_maker(noise=1.0)
    for kind in ("semicolon", "catman ASCII", "catman", "TDMS", "MATLAB", "Parquet", "Excel", "MDF"):
        if kind in NEEDS:
            pytest.importorskip(NEEDS[kind], reason=f"{NEEDS[kind]} is not installed (extra [daq])")
        file = tmp_path / f"{kind.replace(' ', '_')}{SUFFIX[kind]}"
        WRITERS[kind](file, record.to_frame(), UNITS)
        report = ingest(file, MDF_MAP if kind == "MDF" else None, tmp_path / "out")
        again = report.campaign.record(file.stem)
        for name, tolerance in (("t", 1e-6), ("F_n", 0.06), ("F_r", 0.006), ("s", 6e-6), ("a", 0.06)):
            assert np.abs(getattr(again, name) - getattr(record, name)).max() < tolerance, (kind, name)
    guarded.close()


def test_one_bad_file_does_not_stop_the_others(tmp_path: Path, record_maker: Maker) -> None:
    record = record_maker(noise=1.0)
    folder = tmp_path / "rig"
    folder.mkdir()
    frame = record.to_frame()
    write_plain(folder / "good.csv", frame, UNITS)
    write_plain(folder / "swapped.csv", frame.rename(columns={"F_n": "F_r", "F_r": "F_n"}), UNITS)
    write_plain(folder / "unit_n.csv", frame, {**UNITS, "F_r": "kN"})
    write_plain(folder / "unit_r.csv", frame.assign(F_r=frame["F_r"] / 1e3), UNITS)
    write_plain(folder / "unit_s.csv", frame, {**UNITS, "s": "um"})
    write_plain(folder / "sign.csv", frame.assign(F_n=-frame["F_n"]), UNITS)
    write_plain(folder / "constant.csv", frame.assign(F_r=3.0), UNITS)
    write_plain(folder / "backwards.csv", frame.iloc[::-1], UNITS)
    write_plain(folder / "missing.csv", frame.drop(columns="s"), UNITS)
    write_plain(folder / "position.csv", frame.assign(s=frame["T_plate"], T_plate=frame["s"]), UNITS)
    text = (folder / "good.csv").read_bytes()
    (folder / "truncated.csv").write_bytes(text[: len(text) // 2])
    (folder / "good.parquet").write_bytes(b"PAR1" + bytes(100))
    (folder / "old.xls").write_bytes(b"\xd0\xcf\x11\xe0")
    (folder / "notes.pdf").write_bytes(b"%PDF")
    (folder / "tests.csv").write_text("test_id,v_set\ngood,50\nunit_s,50\nabsent,5\n")
    report = ingest(folder, None, tmp_path / "out")
    assert list(report.quality["test_id"]) == ["good"]
    said = {Path(row["file"]).name: row["reason"] for row in report.left_out.to_dict("records")}
    expected = {
        "swapped.csv": "are the columns swapped, or is a unit wrong?",
        "unit_n.csv": "are the columns swapped, or is a unit wrong?",
        "unit_r.csv": "allowed: 0.001 to 1",
        "unit_s.csv": "moves by",
        "sign.csv": "set sign: -1",
        "constant.csv": "a constant signal is not a measurement",
        "backwards.csv": "time must increase",
        "missing.csv": "'s' is missing",
        "position.csv": "a position that moves (are the columns swapped?)",
        "good.parquet": "a second file of test 'good'",
        "old.xls": "suffix '.xls' has no reader",
        "": "test 'absent' of the test table has no file",
    }
    for name, reason in expected.items():
        assert reason in said.pop(name), name
    assert "truncated.csv" in said.pop("truncated.csv")
    assert not said
    assert len(RawCampaign.load(tmp_path / "out")) == 1
    assert str(report).count("left out:") == len(report.left_out)


def test_speed_against_the_test_table(record_maker: Maker) -> None:
    record = replace(record_maker(noise=1.0), metadata={"v_set": 500.0})
    with pytest.raises(InputError, match=r"slides at 50.*mm/s, the test table says v_set 500 mm/s"):
        quality_row(record)
    assert quality_row(replace(record, metadata={"v_set": 50.0}))["speed_mm_s"] == pytest.approx(
        50.0, rel=0.02
    )


def test_quality_sees_what_is_wrong(record_maker: Maker) -> None:
    record = record_maker(noise=1.0)
    row = quality_row(record)
    assert row["F_n_zero_N"] == pytest.approx(25.0, abs=40.0) and row["F_n_clipped"] == 0
    assert row["upsetting_s"] == pytest.approx(0.1, abs=0.02)
    assert row["sliding_s"] == pytest.approx(0.8, abs=0.01)
    clip = np.minimum(record.F_r, 0.9 * record.F_r.max())
    assert quality_row(replace(record, F_r=clip))["F_r_clipped"] > 3
    spiky = record.F_n.copy()
    spiky[[300, 600]] += 5e3
    assert quality_row(replace(record, F_n=spiky))["F_n_spikes"] >= 2
    kept = np.delete(np.arange(len(record)), slice(400, 420))
    gap = {name: getattr(record, name)[kept] for name in CHANNEL_NAMES}
    assert quality_row(replace(record, **gap))["gaps"] == 1
    drifting = replace(record, F_r=record.F_r + 2000.0 * record.t)
    assert quality_row(drifting)["F_r_drift_N_per_s"] == pytest.approx(2000.0, abs=600.0)
    t = np.arange(100) / 100.0
    assert drift(t, 3.0 * t + 1.0, np.arange(50)) == pytest.approx(3.0)
    assert drift(t, t, np.arange(10)) is None


def test_a_fast_record_is_thinned_for_detection(record_maker: Maker) -> None:
    record = record_maker()
    t = np.linspace(record.t[0], record.t[-1], 50_000)
    columns: dict[str, Any] = {n: np.interp(t, record.t, getattr(record, n)) for n in CHANNEL_NAMES}
    fast = replace(record, **{**columns, "t": t})
    assert len(thinned(record)) == len(record)
    assert thinned(fast).sampling_rate == pytest.approx(2000.0, rel=0.05)
    assert quality_row(fast)["sliding_s"] == pytest.approx(quality_row(record)["sliding_s"], abs=0.005)


def test_repeats_are_tests_with_the_same_settings() -> None:
    tests = pd.DataFrame(
        {"test_id": list("abcd"), "v_set": [5, 5, 50, 5], "bore": [15.0, 15.0, 15.0, np.nan]}
    )
    assert repeats(tests) == [2, 2, 1, 1]
    assert repeats(tests[["test_id"]]) == [None] * 4


@pytest.mark.parametrize(
    ("quantity", "unit", "expected"),
    [
        ("F_n", "lbf", (4.4482216, 0.0)),
        ("F_n", "daN", (10.0, 0.0)),
        ("s", "inch", (25.4, 0.0)),
        ("s", "µm", (1e-3, 0.0)),
        ("a", "cm/s^2", (10.0, 0.0)),
        ("a", "m/s²", (1e3, 0.0)),
        ("T_plate", "degF", (5.0 / 9.0, -160.0 / 9.0)),
        ("t", "min", (60.0, 0.0)),
    ],
)
def test_units_that_pint_knows(quantity: str, unit: str, expected: tuple[float, float]) -> None:
    assert conversion(quantity, unit) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    "unit", ["bar", "m", "nonsense", "N**9", "N^99999999", "N" * 500, "__import__", "1/0", ""]
)
def test_units_that_are_refused(unit: str) -> None:
    with pytest.raises(InputError, match="unknown unit of column 'F_n'"):
        conversion("F_n", unit)


def test_stated_phases_cut_the_record(tmp_path: Path, record_maker: Maker) -> None:
    record = record_maker(noise=1.0)
    frame = record.to_frame().assign(Phase=np.where(record.t < 0.8, 1, 2))
    frame.loc[frame["t"] > 1.0, "Phase"] = 3
    write_plain(tmp_path / "t1.csv", frame, {**UNITS, "Phase": ""})
    for phases in (
        {"channel": "Phase", "upsetting": 1, "sliding": 2},
        {"upsetting": [0.0, 0.7995], "sliding": [0.7995, 1.0]},
    ):
        report = ingest(tmp_path / "t1.csv", {"phases": phases}, tmp_path / "out")
        assert report.campaign.record("t1").t[-1] == pytest.approx(1.0)
        row = report.campaign.tests.iloc[0]
        assert (row["t_sliding"], row["t_end"]) == (0.8, 1.0)
    late = {"upsetting": [0.0, 0.9], "sliding": [0.9, 1.0]}
    assert "sliding is said to begin at 0.9 s" in str(
        ingest(tmp_path / "t1.csv", {"phases": late}, tmp_path / "out")
    )
    with pytest.raises(InputError, match="no row of the phase sliding"):
        ingest(tmp_path / "t1.csv", {"phases": {"upsetting": [0, 1], "sliding": [8, 9]}}, tmp_path / "no")


@pytest.mark.parametrize(
    ("phases", "message"),
    [
        ("guess", "phases is 'guess'; allowed: detect"),
        ({"upset": 1}, "unknown key 'upset'.*did you mean 'upsetting'"),
        ({"upsetting": [1, 0], "sliding": [2, 3]}, r"upsetting is \[1, 0\]; allowed: \[first, last\]"),
        ({"upsetting": [0, 2], "sliding": [1, 3]}, "allowed: upsetting first"),
        ({"channel": "P", "upsetting": "x", "sliding": 1}, "upsetting is 'x'; allowed: a value of 'P'"),
        ({"channel": "P", "upsetting": 1, "sliding": 1}, "allowed: two different values"),
    ],
)
def test_bad_phases(phases: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        ChannelMap.load({"phases": phases})


def test_preview_and_the_command(tmp_path: Path, record_maker: Maker) -> None:
    record = record_maker(noise=1.0)
    names = {"t": "Zeit", "F_n": "Kraft Z", "F_r": "Kraft X", "s": "Weg", "a": "Beschl", "T_plate": "Temp"}
    file = tmp_path / "t1.csv"
    write_plain(
        file, record.to_frame().rename(columns=names), {names[n]: u for n, u in UNITS.items()}, ";", ","
    )
    shown = preview(file)
    assert "missing: 't'" in shown
    # What is proposed is a channel map that works.
    mapping = yaml.safe_load(shown[shown.index("channels:") :])
    assert {v["quantity"]: k for k, v in mapping["channels"].items()} == names
    assert ingest(file, mapping, tmp_path / "first").campaign.record("t1").F_n == pytest.approx(
        record.F_n, abs=0.1
    )
    (tmp_path / "channels.yaml").write_text(yaml.safe_dump(mapping), encoding="utf-8")
    command = ["ingest", str(file), "--map", str(tmp_path / "channels.yaml"), "-o", str(tmp_path / "out")]
    run = CliRunner().invoke(app, [*command, "--dry-run"])
    assert run.exit_code == 0 and "upsetting from 0.1" in run.output.replace("\n", " ")
    assert not (tmp_path / "out").exists()
    run = CliRunner().invoke(app, command)
    assert run.exit_code == 0 and (tmp_path / "out" / "quality.csv").is_file()
    shutil.rmtree(tmp_path / "out")


def test_the_channel_map_of_the_documentation(tmp_path: Path, record_maker: Maker) -> None:
    text = (Path(__file__).parents[2] / "docs" / "measurements.md").read_text(encoding="utf-8")
    example = text.split("```yaml", 1)[1].split("```", 1)[0]
    record = record_maker(noise=1.0)
    frame = pd.DataFrame(
        {
            "Time  1": record.t,
            "Kraft Z": -record.F_n / 1e3 + 0.35,
            "Kraft X": record.F_r / 4.4482216152605,
            "Weg": record.s,
            "Beschl": record.a / 9806.65,
            "Platte": record.T_plate + 273.15,
        }
    )
    units = {"Time  1": "s", "Kraft Z": "kN", "Kraft X": "", "Weg": "mm", "Beschl": "g", "Platte": "K"}
    WRITERS["catman ASCII"](tmp_path / "t1.asc", frame, units)
    (tmp_path / "channels.yaml").write_text(example, encoding="utf-8")
    report = ingest(tmp_path / "t1.asc", tmp_path / "channels.yaml", tmp_path / "out")
    again = report.campaign.record("t1")
    assert report.campaign.moving_mass == 25.0 and again.number("T_tool") == 20.0
    for name, tolerance in (("F_n", 0.06), ("F_r", 0.006), ("a", 0.06), ("T_plate", 6e-4)):
        assert np.abs(getattr(again, name) - getattr(record, name)).max() < tolerance
    # The quality table of the page names the columns that there are.
    for name in report.quality.columns:
        assert f"`{name}`" in text, name
