"""Records and readers: what is read, converted, refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from friction_models.common import InputError
from sct_twin import RawCampaign, SctRecord
from sct_twin.ingest.campaign_files import ingest
from sct_twin.ingest.channel_map import ChannelMap
from sct_twin.readers import read_csv

Maker = Callable[..., SctRecord]


def load(path: Path) -> SctRecord:
    return ChannelMap().record(read_csv(path), path.stem)


def test_round_trip(tmp_path: Path, record_maker: Maker) -> None:
    record = record_maker(noise=1.0)
    again = load(record.save(tmp_path / "a.csv"))
    for name, tolerance in (("t", 1e-6), ("F_n", 0.06), ("F_r", 0.006), ("s", 6e-6), ("a", 0.06)):
        assert np.abs(getattr(again, name) - getattr(record, name)).max() < tolerance
    assert (tmp_path / "a.csv").read_text().splitlines()[1] == "s,N,N,mm,mm/s2,degC"


def test_units_are_converted(tmp_path: Path, record_maker: Maker) -> None:
    record = record_maker()
    frame = record.to_frame()
    frame["F_n"] /= 1e3
    frame["a"] /= 1e3
    frame["t"] *= 1e3
    frame["T_plate"] += 273.15
    path = tmp_path / "kn.csv"
    path.write_text("t,F_n,F_r,s,a,T_plate\nms,kN,N,mm,m/s2,K\n" + frame.to_csv(index=False, header=False))
    again = load(path)
    assert again.F_n == pytest.approx(record.F_n)
    assert again.t == pytest.approx(record.t)
    assert again.a == pytest.approx(record.a, abs=1e-6)
    assert again.T_plate == pytest.approx(record.T_plate)


@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_semicolon_or_tab_and_decimal_comma(tmp_path: Path, record_maker: Maker, delimiter: str) -> None:
    record = record_maker()
    path = tmp_path / "de.csv"
    body = record.to_frame().to_csv(index=False, header=False, sep=delimiter, decimal=",")
    header = "t,F_n,F_r,s,a,T_plate\ns,N,N,mm,mm/s2,°C\n".replace(",", delimiter)
    path.write_text(header + body, encoding="cp1252")
    assert load(path).F_n == pytest.approx(record.F_n)


BAD: dict[str, tuple[Callable[[list[str]], list[str]], str]] = {
    "missing column": (lambda t: [t[0].replace("F_r", "Fr"), *t[1:]], r"'F_r' is missing.*is it 'Fr'"),
    "unit": (
        lambda t: [t[0], t[1].replace("mm/s2", "kN"), *t[2:]],
        r"unit of column 'a' 'kN'; allowed:.*mm/s2",
    ),
    "no units": (lambda t: [t[0], *t[2:]], r"column 't' has no unit; allowed: one of s, ms"),
    "not a number": (
        lambda t: [*t[:9], t[9].replace(",", ",x", 1), *t[10:]],
        r"column 'F_n', line 10: value 'x",
    ),
    "NaN": (lambda t: [*t[:9], "0.007,,0,7,0,20", *t[10:]], r"column 'F_n', line 10: value nan"),
    "unordered": (
        lambda t: [*t[:9], t[8], *t[10:]],
        r"column 't', line 10: time 0.006 s comes after 0.006 s",
    ),
    "empty": (lambda t: [], r"the file is empty"),
    "header only": (lambda t: t[:2], r"no rows behind the header"),
    "truncated": (lambda t: [*t[:-1], t[-1][:7]], r"the file looks truncated"),
    "short": (lambda t: t[:12], r"10 rows; a record needs at least 50"),
    "too many cells": (
        lambda t: [*t[:20], t[20] + ",1,2", *t[21:]],
        r"bad.csv, line 21: 8 cells, the table has 6",
    ),
    "one column": (lambda t: [line.replace(",", " ") for line in t], r"names one column only"),
    "twice": (
        lambda t: [t[0].replace("F_r", "F_n"), *t[1:]],
        r"column 'F_n' stands 2 times; .*'F_n \(1\)' or 'F_n \(2\)'",
    ),
}


@pytest.mark.parametrize("fault", BAD)
def test_one_sentence_for_a_bad_file(tmp_path: Path, record_maker: Maker, fault: str) -> None:
    spoil, message = BAD[fault]
    path = record_maker().save(tmp_path / "bad.csv")
    lines = spoil(path.read_text().splitlines())
    path.write_text("\n".join(lines) + ("\n" if lines else ""))
    with pytest.raises(InputError, match=message) as error:
        load(path)
    assert "bad.csv" in str(error.value) and "\n" not in str(error.value)


def test_binary_and_constant_files(tmp_path: Path, record_maker: Maker) -> None:
    (tmp_path / "p.csv").write_bytes(b"\x80\x04\x95pickle")
    with pytest.raises(InputError, match="binary content"):
        read_csv(tmp_path / "p.csv")
    record = record_maker()
    with pytest.raises(InputError, match=r"column 'F_r' is 3.0 N in every row"):
        SctRecord("c", record.t, record.F_n, np.full(len(record), 3.0), record.s, record.a, record.T_plate)
    with pytest.raises(InputError, match="no such file"):
        read_csv(tmp_path / "nothing.csv")


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.binary(max_size=400) | st.text("0123456789.,;\t\n-eE tFnrsa_[]NmN", max_size=300).map(str.encode))
def test_no_content_breaks_the_reader(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "fuzz.csv"
    path.write_bytes(content)
    with pytest.raises(InputError):
        load(path)


LABORATORY = {
    "channels": {
        "Zeit": {"quantity": "t", "unit": "s"},
        "Kraft Z": {"quantity": "F_n", "unit": "kN", "sign": -1, "offset": 0.5},
        "Kraft X": {"quantity": "F_r", "unit": "N"},
        "Weg": {"quantity": "s", "unit": "mm"},
        "Beschl": {"quantity": "a", "unit": "m/s2"},
        "Temp": {"quantity": "T_plate", "unit": "degC"},
    },
    "moving_mass": 25.0,
    "metadata": {"T_tool": 20.0, "bore": 15.51},
}


def test_ingest_maps_checks_and_leaves_out(tmp_path: Path, record_maker: Maker) -> None:
    record = record_maker(noise=1.0)
    folder = tmp_path / "rig"
    folder.mkdir()
    frame = pd.DataFrame(
        {
            "Zeit": record.t,
            "Kraft Z": -record.F_n / 1e3 + 0.5,
            "Kraft X": record.F_r,
            "Weg": record.s,
            "Beschl": record.a / 1e3,
            "Temp": record.T_plate,
        }
    )
    for name in ("t1", "t2"):
        frame.to_csv(folder / f"{name}.csv", index=False, sep=";", decimal=",")
    (folder / "broken.csv").write_text("Zeit;Kraft Z\n1;2\n")
    seen: list[tuple[int, int, str]] = []
    report = ingest(folder, LABORATORY, tmp_path / "out", progress=lambda *a: seen.append(a))
    assert sorted(report.quality["test_id"]) == ["t1", "t2"]
    assert len(report.left_out) == 1 and "'Kraft X' is missing" in report.left_out["reason"][0]
    assert seen[-1][:2] == (3, 3)
    campaign = RawCampaign.load(tmp_path / "out")
    assert campaign.moving_mass == 25.0 and not campaign.synthetic
    assert campaign.record("t1").F_n == pytest.approx(record.F_n, abs=0.1)
    assert campaign.record("t2").number("T_tool") == 20.0
    row = report.quality.set_index("test_id").loc["t1"]
    assert row["sampling_rate_Hz"] == pytest.approx(1000.0) and row["gaps"] == 0
    assert row["F_r_zero_N"] == pytest.approx(-40.0, abs=15.0)
    assert (tmp_path / "out" / "quality.csv").is_file()


def test_ingest_writes_nothing_when_nothing_can_be_used(tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_text("a,b\n1,2\n")
    with pytest.raises(InputError, match="none of 1 files can be used"):
        ingest(tmp_path, None, tmp_path / "out")
    assert not (tmp_path / "out").exists()
    with pytest.raises(
        InputError, match=r"holds other files and no campaign[.]json; allowed: a new or empty folder"
    ):
        ingest(tmp_path, None, tmp_path)
    assert (tmp_path / "x.csv").is_file()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"chanels": {}}, "unknown key 'chanels'.*did you mean 'channels'"),
        ({"channels": {"x": {"quantity": "F_m"}}}, "unknown quantity 'F_m'"),
        ({"channels": {"x": {"quantity": "F_n", "unit": "bar"}}}, "unknown unit of column 'F_n' 'bar'"),
        ({"channels": {"x": {"quantity": "F_n", "sign": 2}}}, "sign is 2; allowed: 1 or -1"),
        ({"channels": {"x": {"quantity": "F_n"}}}, "quantity 't' is mapped 0 times"),
        ({"moving_mass": -1}, "moving_mass is -1; allowed: 0 to 1e5 kg"),
    ],
)
def test_channel_map_errors(content: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        ChannelMap.load(content)


def test_channel_map_from_yaml(tmp_path: Path) -> None:
    path = tmp_path / "channels.yaml"
    path.write_text("moving_mass: 12.5\n")
    assert ChannelMap.load(path).moving_mass == 12.5
    path.write_text("a: [")
    with pytest.raises(InputError, match="not YAML"):
        ChannelMap.load(path)
