"""The rig of the virtual laboratory: motion, sensors, faults, protocols, lubricants and what its logger writes."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from friction_models.common import InputError
from sct_twin import RawCampaign, SctRecord, SctTwin
from sct_twin.ingest.campaign_files import ingest
from sct_twin.ingest.channel_map import ChannelMap
from sct_twin.ingest.quality import quality_row
from sct_twin.readers import guarded, read_file
from sct_twin.twin.heat.contact_temperature import ThermalSettings
from sct_twin.virtual_lab import (
    FORMATS,
    LUBRICANTS,
    Campaign,
    Faults,
    Instruments,
    Rig,
    load_truth,
    run_protocol,
)
from sct_twin.virtual_lab.law import ContactLaw, TrueLaw
from sct_twin.virtual_lab.plans import complete_plan
from sct_twin.virtual_lab.protocols import Schedule
from sct_twin.virtual_lab.rig.drive import commanded, on_elastic_drive
from sct_twin.virtual_lab.rig.file_formats import DIGITS
from sct_twin.virtual_lab.rig.instruments import RECORDED, lagged

from .test_virtual_lab import loads

Maker = Callable[..., SctRecord]
NEEDS = {"mdf": "asammdf", "tdms": "nptdms", "xlsx": "openpyxl"}
ROW = {"sigma_set": 1000.0, "v_set": 100.0, "T_tool": 60.0, "sd_set": 12.0}
PROTOCOLS = [
    ROW,
    {**ROW, "protocol": "pressure_ramp", "sigma_end": 400.0},
    {**ROW, "protocol": "hold", "hold_at": 6.0, "hold": 2.0},
    {**ROW, "protocol": "zero_reading", "zero_reading": 0.5},
    {**ROW, "protocol": "pressure_step", "sigma_levels": "400;1000;600"},
]


@pytest.fixture(scope="module")
def real(tmp_path_factory: pytest.TempPathFactory, lab_cache: Path) -> RawCampaign:
    """Every protocol on a rig with all flaws, as catman files, taken over by `ingest`."""
    home = tmp_path_factory.mktemp("rig")
    lab = Campaign(pd.DataFrame(PROTOCOLS), lubricant="mos2", seed=2, cache=lab_cache)
    lab.write(home / "files", "catman", jobs=1)
    assert sorted(p.name for p in (home / "files" / "raw").iterdir()) == [
        f"sct00{k}.bin" for k in range(1, 6)
    ]
    report = ingest(home / "files", home / "files" / "channels.yaml", home / "campaign")
    assert report.left_out.empty
    return report.campaign


@pytest.mark.parametrize("name", FORMATS)
def test_files_of_every_format_hold_the_test(tmp_path: Path, record_maker: Maker, name: str) -> None:
    if name in NEEDS:
        pytest.importorskip(NEEDS[name], reason=f"{NEEDS[name]} is not installed (extra [daq])")
    kind = FORMATS[name]
    record = record_maker(noise=1.0)
    frame = record.to_frame()[list(RECORDED)]
    kind.save(tmp_path / f"größe{kind.suffix}", frame)
    (tmp_path / "channels.yaml").write_text(kind.channel_map(25.0))
    mapping = ChannelMap.load(tmp_path / "channels.yaml")
    assert mapping.moving_mass == 25.0
    again = mapping.record(read_file(tmp_path / f"größe{kind.suffix}"), "x")
    for channel in RECORDED:
        wanted = frame[channel].to_numpy().round(DIGITS[channel])
        assert getattr(again, channel) == pytest.approx(wanted, abs=0.02 * 10.0 ** -DIGITS[channel]), channel
    if name == "xlsx":
        guarded.close()


def test_csv_looks_like_an_export(tmp_path: Path, record_maker: Maker) -> None:
    FORMATS["csv"].save(tmp_path / "a.csv", record_maker().to_frame())
    lines = (tmp_path / "a.csv").read_text(encoding="utf-8").splitlines()
    assert lines[:2] == [
        "Zeit;Normalkraft;Reibkraft;Plattenweg;Beschleunigung;Plattentemperatur",
        "s;kN;kN;mm;m/s2;°C",
    ]
    assert lines[3].startswith("0,001;0,025;")


def test_a_plate_sticks_until_the_drive_overcomes_static_friction() -> None:
    k, F, mu, static, mass = 1e5, 2e5, 0.08, 0.02, 0.025
    drive = 20.0 * np.arange(200) / 1000.0
    damping = 2 * 0.3 * np.sqrt(k * mass)
    s, pull = on_elastic_drive(drive, F, mu, static, 0.02, k, damping, mass)
    moved = int(np.argmax(s > 0))
    # (mu + static) F = 20 kN winds the drive up by 0.2 mm: 10 ms at 20 mm/s; the damper adds a little.
    assert moved == pytest.approx(10, abs=1) and (s[:moved] == 0).all()
    assert (np.diff(pull[1:moved]) > 0).all() and pull[moved - 1] < (mu + static) * F
    assert pull.max() == pytest.approx((mu + static) * F, rel=0.1)
    # It overshoots, and slides on behind the drive by mu F / k, with what is left of the static share.
    assert (np.diff(s) >= 0).all() and drive[-1] - s[-1] == pytest.approx(mu * F / k, rel=0.02)
    assert np.diff(s)[-1] == pytest.approx(0.02, rel=0.02)


def test_commanded_motion() -> None:
    steps = commanded((5.0, 100.0, 5.0), 30.0, 12000.0)
    sd = np.cumsum(steps) / 1000.0
    middle = [float(np.interp(x, sd, steps)) for x in (5.0, 17.5, 28.0)]
    assert middle == pytest.approx([5.0, 100.0, 5.0], rel=0.01)
    assert sd[-1] == pytest.approx(30.0, abs=0.2)
    hold = commanded((100.0,), 30.0, 12000.0, (12.0, 0.5))
    still = np.flatnonzero(hold[5:] == 0.0) + 5
    assert 490 <= len(still) <= 515 and np.ptp(still) == len(still) - 1
    assert np.cumsum(hold)[still[0]] / 1000.0 == pytest.approx(12.0, abs=0.1)


def test_force_of_a_schedule() -> None:
    ramp = Schedule((100.0,), (1.0, 0.4), ramp=True)
    assert ramp.force(np.array([0.0, 25.0, 50.0]), 50.0, 100.0) == pytest.approx([1.0, 0.7, 0.4])
    levels = Schedule((100.0,), (0.5, 1.0))
    assert levels.force(np.array([0.0, 24.0, 25.0, 27.5, 31.0]), 50.0, 100.0) == pytest.approx(
        [0.5, 0.5, 0.5, 0.75, 1.0]
    )


def test_protocols_reach_the_record_and_the_truth(real: RawCampaign) -> None:
    truth = load_truth(real.folder.parent / "files")[1]
    constant, ramp, hold, _, steps = (truth[f"sct00{k}"] for k in range(1, 6))
    assert np.ptp(constant["sigma_n"]) < 0.03 * constant["sigma_n"].mean()
    # The contact is the one of upsetting: pressure follows the force.
    fall = ramp["sigma_n"][:110] / ramp["sigma_n"][0]
    assert fall == pytest.approx(1.0 - 0.6 * ramp["sd"][:110] / 12.0, abs=0.03)
    assert steps["sigma_n"][[20, 70, 115]] / ramp["sigma_n"][0] == pytest.approx([0.4, 1.0, 0.6], abs=0.02)
    at = int(np.argmax(np.diff(hold["t"])))
    assert hold["sd"][at] == pytest.approx(6.0, abs=0.2) and np.diff(hold["t"])[at] > 1.9
    # Without friction heat the contact cools down.
    assert hold["T"][at + 1] < hold["T"][at] - 20.0
    record = real.record("sct004")
    free = record.F_n < 2e3
    assert free.sum() > 1000 and free[:550].all() and free[-450:].all()
    assert real.metadata("sct003")["hold"] == 2.0 and real.metadata("sct001")["lubricant"] == "mos2"


def test_flaws_of_the_rig_are_in_the_record(real: RawCampaign) -> None:
    record = real.record("sct001")
    assert record.s is not None and record.T_plate is not None
    moving = int(np.argmax(record.s - np.median(record.s[:100]) > 0.03))
    wound = record.F_r[moving - 4 : moving].mean() - np.median(record.F_r[:100])
    # Before the plate moves the drive is wound up to more than half of the friction force.
    assert wound > 0.03 * record.F_n[moving]
    assert np.abs(np.diff(record.T_plate)).max() < 1.5
    tests = real.tests
    for name, scatter in (("specimen_diameter", 0.02), ("specimen_height", 0.03)):
        assert tests[name].nunique() == 5
        assert np.abs(tests[name] - 15.0).max() < 4.0 * scatter


def test_contact_is_measured_after_the_test(
    real: RawCampaign, tiny: RawCampaign, lab_cache: Path, tmp_path: Path
) -> None:
    true = json.loads((real.folder.parent / "files" / "truth.json").read_text())["tests"]
    error = [
        row["contact_diameter"] - true[row["test_id"]]["contact_diameter"] for _, row in real.tests.iterrows()
    ]
    assert 0.0 < np.abs(error).max() <= 0.105 and len(set(error)) == 5
    assert real.info["reality"]["sensors"]["contact_reading"] == 0.04
    assert "contact_diameter" not in tiny.tests
    # Nothing else is drawn from its stream: the same seed gives the same records without it.
    usual = Campaign(pd.DataFrame(PROTOCOLS[:1]), lubricant="mos2", seed=2, cache=lab_cache)
    blind = replace(usual, instruments=replace(usual.sensors, contact_reading=0.0))
    raw = [lab.run(tmp_path / name, jobs=1) for lab, name in ((usual, "usual"), (blind, "blind"))]
    assert raw[0].raw_file("sct001").read_bytes() == raw[1].raw_file("sct001").read_bytes()
    pd.testing.assert_frame_equal(raw[0].tests.drop(columns="contact_diameter"), raw[1].tests)


def test_reality_is_stated_and_is_not_the_twins(real: RawCampaign) -> None:
    reality = real.info["reality"]
    for name, both in reality["thermal"].items():
        assert both["laboratory"] != both["twin"], name
    assert reality["flow_stress_factor"] != 1.0 and reality["sensors"]["stiffness"] == 1e5
    assert real.synthetic and real.info["lubricant"] == "mos2 (virtual)"
    # What it is upset and rubbed with is known to the truth alone.
    text = json.dumps(real.info)
    assert "upsetting_mu" not in text and "law" not in text
    known = json.loads((real.folder.parent / "files" / "truth.json").read_text())
    mu = [test["upsetting_mu"] for test in known["tests"].values()]
    assert len(set(mu)) == 5 and np.mean(mu) == pytest.approx(LUBRICANTS["mos2"].upsetting_mu, rel=0.15)


def test_further_tests_have_the_same_lubricant(real: RawCampaign, lab_cache: Path, tmp_path: Path) -> None:
    files = real.folder.parent / "files"
    lab = Campaign(pd.DataFrame(PROTOCOLS), lubricant="mos2", seed=2, cache=lab_cache)
    more = run_protocol(lab, [{**ROW, "v_set": 200.0}], tmp_path / "more", jobs=1)
    stored = [load_truth(folder)[0] for folder in (files, more.folder)]
    assert stored[0]["law"] == stored[1]["law"]
    assert stored[0]["tests"]["sct001"] != stored[1]["tests"]["sct001"]
    with pytest.raises(InputError, match=r"no truth.json and truth.npz"):
        run_protocol(real.folder, [ROW])


def test_a_reading_without_load_shows_the_offset_of_the_cell(lab_cache: Path, tmp_path: Path) -> None:
    row = {**ROW, "sd_set": 3.0}
    lab = Campaign(pd.DataFrame([row]), hidden="force_zero", seed=2, cache=lab_cache)
    again = Campaign(pd.DataFrame([row]), hidden=["stribeck", "force_zero"], seed=2)
    assert lab.true_faults is not None and lab.true_faults == again.true_faults
    assert [e.name for e, _ in again.true_law.hidden] == ["stribeck"] and not lab.true_law.hidden
    offset = lab.true_faults.force_zero
    assert 1800.0 <= offset <= 2200.0
    usual = lab.run(tmp_path / "usual", jobs=1)
    assert "force_zero" not in json.dumps(usual.info) + usual.tests.to_csv()
    assert load_truth(usual.folder)[0]["faults"]["force_zero"] == offset
    asked = run_protocol(
        lab, [{**row, "protocol": "zero_reading", "zero_reading": 0.5}], tmp_path / "asked", jobs=1
    )
    tests = [SctTwin().run(raw, jobs=1).tests.iloc[0] for raw in (usual, asked)]
    assert "F_r_zero_end" not in tests[0] and abs(tests[0]["F_r_zero"]) < 120.0  # tared before the load
    assert tests[1]["F_r_zero_end"] - tests[1]["F_r_zero"] == pytest.approx(offset, abs=20.0)
    with pytest.raises(InputError, match="hidden force_zero beside faults of some tests; allowed"):
        Campaign("tiny-6", hidden="force_zero", faults=Faults(spikes=1, tests=("sct001",)))
    with pytest.raises(InputError, match="did you mean 'force_zero'"):
        Campaign("tiny-6", hidden="force_zeros")


def test_thermocouple_lag() -> None:
    step = np.where(np.arange(3000) < 1000, 20.0, 120.0)
    shown = lagged(step, 0.5)
    assert shown[1500] == pytest.approx(20.0 + 100.0 * (1.0 - np.exp(-1.0)), abs=0.2)
    assert lagged(step, 0.0) is step


@pytest.mark.parametrize(
    ("faults", "column", "least"),
    [
        (Faults(spikes=3, spike_size=2e4), "F_n_spikes", 3),
        (Faults(clip=0.1), "F_r_clipped", 3),
        (Faults(gaps=1, gap_length=0.03), "gaps", 1),
    ],
)
def test_faults_are_seen(record_maker: Maker, faults: Faults, column: str, least: int) -> None:
    clean = record_maker(noise=1.0)
    rng = np.random.default_rng(0)
    bad = SctRecord.from_frame("x", faults.apply(clean.to_frame(), 100, rng), clean.metadata)
    assert quality_row(clean)[column] < least <= quality_row(bad)[column]


def test_faults_that_leave_no_trace_or_no_record(record_maker: Maker) -> None:
    clean, rng = record_maker(), np.random.default_rng(0)
    frame = clean.to_frame()
    zero = Faults(force_zero=300.0).apply(frame, 100, rng)
    assert (zero["F_r"] - frame["F_r"])[[50, 150]].tolist() == pytest.approx([0.0, 300.0])
    drift = Faults(drift=40.0).apply(frame, 100, rng)
    assert (drift["F_r"] - frame["F_r"]).iloc[1000] == pytest.approx(40.0)
    with pytest.raises(InputError, match=r"'s' is .* in every row"):
        SctRecord.from_frame("x", Faults(dead="s").apply(frame, 100, rng), {})
    late = Faults(late_start=True).apply(frame, 100, rng)
    assert (
        len(late) == len(frame) - 105 and quality_row(SctRecord.from_frame("x", late))["F_n_zero_N"] is None
    )
    assert Faults(tests=("a",)).happen_to("a") and not Faults(tests=("a",)).happen_to("b")


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ({"protocol": "speed_stp"}, "unknown protocol 'speed_stp'.*did you mean 'speed_step'"),
        ({"protocol": "speed_step"}, "row 0: v_levels is missing; allowed: numbers such as"),
        ({"protocol": "speed_step", "v_levels": "5;x"}, "v_levels = 'x'; allowed: 0.5 to 1000 mm/s"),
        ({"protocol": "pressure_ramp", "sigma_end": 1500}, "sigma_end = 1500; allowed: 20 to 1000 MPa"),
        ({"protocol": "hold", "hold_at": 5.0}, "hold is missing; allowed: 0.05 to 600 s"),
        ({"sigma_set": np.nan}, "sigma_set is missing; allowed: 50 to 2900 MPa"),
        ({"psi_set": 7}, "psi_set = 7; allowed: a specimen shape of the rig: 1.069, 5, 10, 20"),
        ({"test_id": "../x"}, "test_id '../x'; allowed: a name that can be a file name"),
        ({"T_tool": "hot"}, "T_tool = 'hot'; allowed: 0 to 350 degC"),
    ],
)
def test_rows_that_cannot_be_tested(row: dict[str, str | float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        complete_plan(pd.DataFrame([{**ROW, **row}]), 0, "plan")


def test_a_plan_of_ones_own(tmp_path: Path) -> None:
    file = tmp_path / "plan.csv"
    pd.DataFrame(PROTOCOLS).rename(columns={"sigma_set": "sigma_set [MPa]"}).to_csv(file, index=False)
    plan = Campaign(file, seed=4).tests
    assert plan["protocol"].tolist()[1:] == ["pressure_ramp", "hold", "zero_reading", "pressure_step"]
    assert plan["sigma_levels"].iloc[4] == "400;1000;600" and plan["synthetic"].all()
    assert sorted(plan["order"]) == [1, 2, 3, 4, 5] and set(plan["role"]) == {"train"}
    with pytest.raises(InputError, match=r"absent.csv: no such file"):
        Campaign(tmp_path / "absent.csv")
    with pytest.raises(InputError, match=r"column 'v_set' is missing"):
        complete_plan(pd.DataFrame([{"sigma_set": 1.0, "T_tool": 20.0}]), 0, "plan")
    with pytest.raises(InputError, match="repeats belong to a named plan"):
        Campaign(file, repeats=2)
    twice = Campaign("tiny-6+3", repeats=2).tests
    assert len(twice) == 15 and twice["repeat"].tolist()[:4] == [1, 2, 1, 2]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Campaign(lubricant="polimer"), "unknown lubricant 'polimer'.*did you mean 'polymer'"),
        (
            lambda: Campaign("tiny-6").write("x", "catmn"),
            "unknown file format 'catmn'.*did you mean 'catman'",
        ),
        (lambda: Campaign(repeats=0), "repeats = 0; allowed: 1 to 50"),
        (lambda: Instruments(stiffness=-1.0), "stiffness = -1.0; allowed"),
        (lambda: Faults(dead="F_x"), "unknown channel 'F_x'"),
        (lambda: Faults(clip=2.0), "clip = 2.0; allowed: 0 to 0.9"),
    ],
)
def test_what_the_laboratory_refuses(make: Callable[[], object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize("name", LUBRICANTS)
def test_lubricants(name: str) -> None:
    i = loads()
    law = TrueLaw.draw("stribeck", 5, name)
    assert TrueLaw.from_dict(json.loads(json.dumps(law.to_dict()))).mu(i) == pytest.approx(law.mu(i), abs=0)
    mu = law.without_hidden(i)
    assert (mu > 0.02).all() and (mu < 0.15).all()
    X = np.column_stack([np.ones(len(mu)), i.v_rel, i.T, i.sigma_n, i.sd, i.psi])
    rest = mu - X @ np.linalg.lstsq(X, mu, rcond=None)[0]
    # Between the noise of a tribometer and its accuracy: a linear model misses something, but not everything.
    assert 0.0015 < rest.std() < 0.01
    assert mu.std() > rest.std()
    other = TrueLaw.draw(None, 5, next(n for n in LUBRICANTS if n != name)).mu(i)
    assert np.corrcoef(mu, other)[0, 1] < 0.9
    regular = ContactLaw(law)(np.array([[0.0, -20.0, 0.0, 0.0, 0.9]]), 0.0)
    assert np.isfinite(regular).all() and (regular > 0).all()


def test_a_plain_rig_has_no_flaws_of_a_real_one() -> None:
    plain, real_one = asdict(Instruments()), asdict(Instruments.realistic())
    changed = {name for name in plain if plain[name] != real_one[name]}
    assert all(plain[name] == 0.0 for name in changed) and "stiffness" in changed
    assert not Rig().scattered and Rig.realistic().scattered
    heat = ThermalSettings()
    assert Rig().thermal.heat_transfer != heat.heat_transfer
    assert asdict(Rig().thermal.plate) != asdict(heat.plate)
