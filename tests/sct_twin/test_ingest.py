"""A campaign from files of many formats: units, phases, quality, faults, what is shown before."""

from __future__ import annotations

import shutil
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
from sct_twin import RawCampaign, SctRecord
from sct_twin.ingest.campaign_files import ingest
from sct_twin.ingest.channel_map import ChannelMap
from sct_twin.ingest.preview import preview
from sct_twin.ingest.quality import doubts, quality_row, repeats, warnings
from sct_twin.ingest.survey import survey
from sct_twin.readers import guarded
from sct_twin.records.channels import CHANNELS
from sct_twin.records.units import channel_conversion
from sct_twin.signals.clock import ENOUGH_HZ, Clock
from sct_twin.signals.force_zero import drift
from sct_twin.signals.sliding_phase import process
from sct_twin.signals.sliding_series import resample

from .reader_files import SUFFIX, WRITERS, write_plain
from .test_readers import NEEDS

Maker = Callable[..., SctRecord]
CHANNEL_NAMES = ("t", "F_n", "F_r", "s", "a", "T_plate")
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
    write_plain(folder / "unit_a.csv", frame, {**UNITS, "a": "g"})
    write_plain(folder / "unit_t.csv", frame.assign(t=1e3 * frame["t"]), UNITS)
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
        "unit_a.csv": "is a unit of 'a' or 't' wrong?",
        "unit_t.csv": "is a unit of 'a' or 't' wrong?",
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
    # The same reason with other numbers stands once, with all its files.
    assert all(Path(file).name in str(report) for file in report.left_out["file"])


def test_a_copy_of_a_record_is_named(tmp_path: Path, record_maker: Maker) -> None:
    write_plain(tmp_path / "a.csv", record_maker(noise=1.0).to_frame(), UNITS)
    write_plain(tmp_path / "b.csv", record_maker(noise=2.0).to_frame(), UNITS)
    (tmp_path / "c.csv").write_bytes((tmp_path / "a.csv").read_bytes())
    found = survey(tmp_path)
    assert [row["notes"] for row in found.rows] == [
        "",
        "",
        "holds the same numbers as test 'a': is it a copy?",
    ]


def test_speed_against_the_test_table(record_maker: Maker) -> None:
    record = replace(record_maker(noise=1.0), metadata={"v_set": 500.0})
    with pytest.raises(InputError, match=r"slides at 50.*mm/s, the test table says v_set 500 mm/s"):
        quality_row(record)
    assert quality_row(replace(record, metadata={"v_set": 50.0}))["speed_mm_s"] == pytest.approx(
        50.0, rel=0.02
    )


def test_what_was_set_against_what_was_measured(record_maker: Maker) -> None:
    record = record_maker(noise=1.0)
    with pytest.raises(
        InputError, match=r"the normal force reaches 9.*e\+04 N, the test table says F_set 94 N"
    ):
        quality_row(replace(record, metadata={"F_set": 94.0}))
    assert quality_row(replace(record, metadata={"F_set": 94e3, "v_set": "see log"}))["speed_mm_s"] > 49.0
    # A test with steps of the speed: one of them has to fit.
    steps = {"v_set": 5.0, "v_levels": "5;500;50"}
    assert quality_row(replace(record, metadata=steps))["speed_mm_s"] == pytest.approx(50.0, rel=0.02)
    with pytest.raises(InputError, match="the test table says v_set 5 mm/s"):
        quality_row(replace(record, metadata={"v_set": 5.0}))


def test_what_is_reported_but_not_refused(record_maker: Maker) -> None:
    record = record_maker(noise=1.0)
    kelvin = replace(record, T_plate=np.asarray(record.T_plate) + 273.15)
    small = replace(record, F_n=record.F_n / 1e3, F_r=record.F_r / 1e3)
    for changed, said in (
        (kelvin, "is the unit of T_plate wrong?"),
        (small, "is the unit of F_n and F_r wrong?"),
    ):
        assert said in " ".join(warnings({**quality_row(changed), "notes": ""}))
    assert warnings({**quality_row(record), "notes": ""}) == []


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


def test_a_fast_record_is_averaged(record_maker: Maker) -> None:
    record = record_maker()
    t = np.linspace(record.t[0], record.t[-1], 100_000)
    columns = {n: np.interp(t, record.t, getattr(record, n)) for n in CHANNEL_NAMES}
    fast = replace(record, **{**columns, "t": t})
    assert Clock.of(record).stride == 1
    assert 0.5 * ENOUGH_HZ < 1.0 / Clock.of(fast).dt < 1.5 * ENOUGH_HZ
    slow, quick = quality_row(record), quality_row(fast)
    assert quick["sliding_s"] == pytest.approx(slow["sliding_s"], abs=0.005)
    assert quick["mu_mean"] == pytest.approx(slow["mu_mean"], abs=2e-5)


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
    assert channel_conversion(quantity, unit) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    "unit", ["bar", "m", "nonsense", "N**9", "N^99999999", "N" * 500, "__import__", "1/0", ""]
)
def test_units_that_are_refused(unit: str) -> None:
    with pytest.raises(InputError, match="unknown unit of column 'F_n'"):
        channel_conversion("F_n", unit)


def test_stated_phases_steer_what_is_computed(tmp_path: Path, record_maker: Maker) -> None:
    record = record_maker(noise=1.0)
    frame = record.to_frame().assign(Phase=np.where(record.t < 0.9, 1, 2))
    frame.loc[frame["t"] > 1.0, "Phase"] = 3
    write_plain(tmp_path / "t1.csv", frame, {**UNITS, "Phase": ""})
    for phases in (
        {"channel": "Phase", "upsetting": 1, "sliding": 2},
        {"upsetting": [0.0, 0.8995], "sliding": [0.8995, 1.0]},
    ):
        report = ingest(tmp_path / "t1.csv", {"phases": phases}, tmp_path / "out")
        again = report.campaign.record("t1")
        # The record stays whole; the twin gets the phases from the test table.
        assert len(again) == len(record)
        row = report.campaign.tests.iloc[0]
        assert (row["t_upsetting"], row["t_sliding"], row["t_end"]) == (0.0, 0.9, 1.0)
        signals = process(again)
        assert again.t[signals.slide_start] == pytest.approx(0.9)
        assert len(signals.t) == 1001 and signals.load_start == 0
        found = report.quality.iloc[0]
        assert found["phases"] == "stated: t_upsetting t_sliding t_end"
        assert (found["sliding_s"], found["end_s"]) == (0.9, 1.0)
        assert found["sliding_detected_s"] == pytest.approx(0.8, abs=0.01)
        assert "sliding is said to begin at 0.9 s, the signals say 0.8" in " ".join(str(report).split())
    with pytest.raises(InputError, match=r"sliding is \[8, 9\] s, the record goes from 0"):
        ingest(tmp_path / "t1.csv", {"phases": {"upsetting": [0, 1], "sliding": [8, 9]}}, tmp_path / "no")


def test_phases_of_the_test_table(tmp_path: Path, record_maker: Maker) -> None:
    record = record_maker(noise=1.0)
    write_plain(tmp_path / "t1.csv", record.to_frame(), UNITS)
    (tmp_path / "tests.csv").write_text("test_id,t_sliding\nt1,0.85\n")
    report = ingest(tmp_path, None, tmp_path / "out")
    found = report.quality.iloc[0]
    # What is not stated is detected.
    assert found["phases"] == "stated: t_sliding"
    assert found["sliding_s"] == 0.85 and found["upsetting_s"] == pytest.approx(0.1, abs=0.02)
    both = {"phases": {"upsetting": [0.0, 0.8], "sliding": [0.8, 1.0]}}
    with pytest.raises(InputError, match=r"t_sliding is 0\.85 in the test table and 0\.8 s by the phases"):
        ingest(tmp_path, both, tmp_path / "no")


def test_processing_stands_in_the_map_or_in_the_test_table(tmp_path: Path, record_maker: Maker) -> None:
    record = record_maker(noise=1.0)
    spiky = record.to_frame()
    spiky.loc[50, "F_n"] += 9e3
    for name in ("t1", "t2"):
        write_plain(tmp_path / f"{name}.csv", spiky, UNITS)
    (tmp_path / "tests.csv").write_text("test_id,low_pass\nt1,auto\nt2,\n")
    report = ingest(tmp_path, {"despike": True, "low_pass": 40.0}, tmp_path / "out")
    campaign = RawCampaign.load(tmp_path / "out")
    assert list(report.quality["low_pass_Hz"]) == [100.0, 40.0]
    assert list(report.quality["spikes_removed"]) == [1, 1]
    for name, corner in (("t1", 100.0), ("t2", 40.0)):
        signals = process(campaign.record(name))
        assert signals.spikes == 1 and signals.low_pass == pytest.approx(corner)
    assert "1 spike in F_n, replaced" in str(report)
    for key, value in (("despike", "yes"), ("low_pass", 0)):
        with pytest.raises(InputError, match=f"{key} is {value!r}; allowed"):
            ChannelMap.load({key: value})


@pytest.mark.parametrize(
    ("times", "message"),
    [
        ({"t_sliding": 9.0}, "t_sliding is 9 s, the record goes from 0 to .* allowed: a time of the record"),
        (
            {"t_upsetting": 0.9, "t_sliding": 0.8},
            "t_sliding is 0.8 s, t_upsetting is 0.9 s; allowed: upsetting before sliding",
        ),
        ({"t_sliding": 0.9, "t_end": 0.9}, "t_end is 0.9 s, t_sliding is 0.9 s"),
        ({"t_end": "late"}, "metadata 't_end' is 'late'; allowed: a number"),
        ({"t_sliding": 0.05}, "sliding begins at 0.05 s, before the load; allowed: upsetting first"),
        ({"despike": "perhaps"}, "metadata 'despike' is 'perhaps'; allowed: true or false"),
        ({"low_pass": -1.0}, "metadata 'low_pass' is -1; allowed: above 0 Hz"),
        ({"F_n_std": -1.0}, "metadata 'F_n_std' is -1; allowed: 0 N and more"),
    ],
)
def test_what_a_test_table_cannot_say(
    record_maker: Maker, times: dict[str, str | float], message: str
) -> None:
    record = replace(record_maker(noise=1.0), metadata=times)
    with pytest.raises(InputError, match=message):
        process(record)


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
    assert "column 't' [s] is missing" in " ".join(shown.split())
    # What is proposed is a channel map that works.
    mapping = yaml.safe_load(shown[shown.index("channels:") :])
    assert {v["quantity"]: k for k, v in mapping["channels"].items()} == names
    assert ingest(file, mapping, tmp_path / "first").campaign.record("t1").F_n == pytest.approx(
        record.F_n, abs=0.1
    )
    (tmp_path / "channels.yaml").write_text(yaml.safe_dump(mapping), encoding="utf-8")
    command = ["ingest", str(file), "--map", str(tmp_path / "channels.yaml")]
    run = CliRunner().invoke(app, command)
    assert isinstance(run.exception, InputError) and "-o is missing" in str(run.exception)
    run = CliRunner().invoke(app, [*command, "--dry-run"])
    command += ["-o", str(tmp_path / "out")]
    assert run.exit_code == 0, run.output
    table = run.output.splitlines()
    assert max(map(len, table)) <= 80
    head = next(line.split() for line in table if line.startswith("test "))
    row = dict(zip(head, next(line.split() for line in table if line.startswith("t1 "))))
    assert float(row["slide"]) == pytest.approx(0.8, abs=0.01) and float(row["v"]) == pytest.approx(
        50, rel=0.01
    )
    assert float(row["mu"]) == pytest.approx(0.08, abs=2e-3)
    assert not (tmp_path / "out").exists()
    run = CliRunner().invoke(app, command)
    assert run.exit_code == 0 and (tmp_path / "out" / "quality.csv").is_file()
    shutil.rmtree(tmp_path / "out")


def test_voltages_become_forces(tmp_path: Path, record_maker: Maker) -> None:
    record = record_maker(noise=1.0)
    frame = pd.DataFrame(
        {
            "t": record.t,
            "AI 0": record.F_n / 25e3 + 0.12,
            "AI 1": 1.5 * record.F_r / 1e3,
            "AI 2": record.T_plate / 100.0,
            "s": record.s,
            "a": record.a,
        }
    )
    units = {"t": "s", "AI 0": "V", "AI 1": "mV", "AI 2": "V", "s": "mm", "a": "mm/s2"}
    write_plain(tmp_path / "t1.csv", frame, units)
    text = (Path(__file__).parents[2] / "docs" / "measurements.md").read_text(encoding="utf-8")
    example = text.split("### Voltages", 1)[1].split("```yaml", 1)[1].split("```", 1)[0]
    mapping = yaml.safe_load("channels:\n  t: t\n  s: s\n  a: a\n" + example)
    report = ingest(tmp_path / "t1.csv", mapping, tmp_path / "out")
    again = report.campaign.record("t1")
    for name, tolerance in (("F_n", 0.06), ("F_r", 0.006), ("T_plate", 6e-4)):
        assert np.abs(getattr(again, name) - getattr(record, name)).max() < tolerance
    assert again.number("F_r_std") == 15.0


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ({"scale": "5 kN/V", "unit": "N"}, "readings in 'N' with scale '5 kN/V' do not give 'F_n'"),
        ({"scale": "5 mm/V", "unit": "V"}, "allowed: units whose product is in N"),
        ({"scale": "kN/V", "unit": "V"}, "scale is 'kN/V'; allowed: a number with a unit"),
        ({"sensitivity": "0 mV/N", "unit": "V"}, "sensitivity is '0 mV/N'; allowed"),
        ({"scale": 5.0, "unit": "V"}, r"5\.0 has no unit; allowed: a number with a unit"),
        ({"scale": "1 N/V", "sensitivity": "1 V/N"}, "both scale and sensitivity"),
        ({"std": -1}, "std is -1; allowed"),
    ],
)
def test_scales_that_are_refused(entry: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        ChannelMap.load({"channels": {"x": {"quantity": "F_n", **entry}, "t": "t", "F_r": "F_r", "s": "s"}})


def test_a_channel_map_with_aliases_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "channels.yaml"
    path.write_text("metadata: {a: &x [1, 2], b: [*x, *x]}\n")
    with pytest.raises(InputError, match=r"channels\.yaml: holds an alias"):
        ChannelMap.load(path)
    path.write_text("metadata: " + "[" * 50 + "]" * 50 + "\n")
    with pytest.raises(InputError, match=r"channels\.yaml: nested deeper than"):
        ChannelMap.load(path)


@pytest.mark.parametrize("same_clock", [True, False])
def test_two_files_a_test(tmp_path: Path, record_maker: Maker, same_clock: bool) -> None:
    record = record_maker(noise=1.0)
    rig = tmp_path / "rig"
    rig.mkdir()
    frame = record.to_frame()
    # The press logs 100 Hz and the normal force alone; the slide is recorded from 50 ms before on.
    up, slide = frame[frame["t"] < 0.7].iloc[::10][["t", "F_n"]], frame[frame["t"] >= 0.75]
    if not same_clock:
        slide = slide.assign(t=slide["t"] - 0.75)
    for test in ("t1", "t2"):
        write_plain(rig / f"{test}_up.csv", up, UNITS)
        write_plain(rig / f"{test}_slide.csv", slide, UNITS)
    write_plain(rig / "t3_up.csv", up, UNITS)
    write_plain(rig / "other.csv", up, UNITS)
    if not same_clock:
        (rig / "tests.csv").write_text("test_id,t_wait\nt1,0.06\nt2,\n")
    mapping = {"phases": {"files": {"upsetting": "_up", "sliding": "_slide"}}}
    report = ingest(rig, mapping, tmp_path / "out")
    assert list(report.quality["test_id"]) == ["t1", "t2"]
    said = " ".join(report.left_out["reason"])
    assert "test 't3' has no sliding file" in said and "ends with neither '_up' nor '_slide'" in said
    joined = report.campaign.record("t1")
    assert joined.t[len(up)] == pytest.approx(0.75, abs=1e-6)
    truth, series = resample(process(record, 25.0)), resample(process(joined, 25.0))
    count = min(len(truth.mu), len(series.mu))
    assert np.abs(truth.mu[:count] - series.mu[:count]).mean() < 3e-4
    notes = list(report.quality["notes"])
    assert all("no F_r in the upsetting file" in note for note in notes)
    assert ("no t_wait" in notes[1]) is not same_clock


@pytest.mark.parametrize(
    ("files", "message"),
    [
        ("x", "files is 'x'; allowed: upsetting and sliding"),
        ({"upsetting": "_u"}, "sliding is None; allowed: the end of a file name"),
        ({"upsetting": "_u", "sliding": "_u"}, "both end with '_u'"),
        ({"up": "_u"}, "unknown key 'up'"),
    ],
)
def test_bad_endings(files: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        ChannelMap.load({"phases": {"files": files}})


def test_many_tests_are_shown_briefly(tmp_path: Path, record_maker: Maker) -> None:
    frame = record_maker(noise=1.0).to_frame()
    rng = np.random.default_rng(3)
    for number in range(45):
        rows = np.delete(np.arange(len(frame)), slice(300, 305 + number))
        spiky = frame.iloc[rows].copy()
        spiky.iloc[600, 1] += 1e4 * rng.uniform(1, 2)
        write_plain(tmp_path / f"a_test_with_a_long_name_{number}.csv", spiky.drop(columns="a"), UNITS)
    for width in (80, 120):
        lines = preview(tmp_path, width=width).splitlines()
        assert max(map(len, lines)) <= max(width, 80)
        assert sum(line.startswith("a_") and "  1000  " in line for line in lines) == 40
        text = " ".join(" ".join(lines).split())
        assert "and 5 more tests (quality.csv holds all)" in text
        for said in ("1 gap, the largest", "a not recorded", "1 spike in F_n, left in"):
            assert text.count(said) == 1
        assert "a_test_with_a_long_name_10, " in text and "and 39 more: 1 gap," in text
        assert "(numbers of the first)" in text


def test_the_channel_map_of_the_documentation(tmp_path: Path, record_maker: Maker) -> None:
    text = (Path(__file__).parents[2] / "docs" / "measurements.md").read_text(encoding="utf-8")
    example = text.split("## channels.yaml", 1)[1].split("```yaml", 1)[1].split("```", 1)[0]
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
    file = tmp_path / "SCT_t1_50mms.asc"
    WRITERS["catman ASCII"](file, frame, units)
    (tmp_path / "channels.yaml").write_text(example, encoding="utf-8")
    report = ingest(file, tmp_path / "channels.yaml", tmp_path / "out")
    again = report.campaign.record("t1")
    assert report.campaign.moving_mass == 25.0 and again.number("T_tool") == 20.0
    for name, tolerance in (("F_n", 0.06), ("F_r", 0.006), ("a", 0.06), ("T_plate", 6e-4)):
        assert np.abs(getattr(again, name) - getattr(record, name)).max() < tolerance
    # The quality table of the page names the columns that there are.
    for name in report.quality.columns:
        assert f"`{name}`" in text, name


def test_a_test_that_slides_less_than_was_set_is_told() -> None:
    row = {
        "F_n_spikes": 0,
        "F_r_spikes": 0,
        "spikes_removed": 0,
        "T_tool_degC": None,
        "sigma_guess_MPa": 500.0,
    }
    (said,) = doubts({**row, "sliding_mm": 26.2, "sliding_set_mm": 56.0})
    assert said.startswith("only 26.2 mm of sliding under load were found, the test table says sd_set 56 mm")
    assert doubts({**row, "sliding_mm": 55.0, "sliding_set_mm": 56.0}) == []
    assert doubts({**row, "sliding_mm": 5.0, "sliding_set_mm": None}) == []
