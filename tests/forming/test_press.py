"""Press curve folders: round trip, units, and sentences about bad files."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from forming.press import PressCurves, PressLevel, read_curves
from friction_models.common import InputError


def level(**changes: object) -> PressLevel:
    stroke = np.linspace(0.0, 10.0, 21)
    curves = pd.concat(
        [pd.DataFrame({"stroke": stroke, "force": 300.0 * stroke + k, "repeat": k}) for k in (1, 2)]
    ).reset_index(drop=True)
    settings: dict = {"process": "fre", "T_tool": 20.0, "speed": 5.0, "lubricant": "polymer", "file": "a.csv"}
    return PressLevel(**{**settings, "curves": curves, **changes})


def test_round_trip_keeps_everything(tmp_path):
    saved = PressCurves((level(), level(file="sub/b.csv", synthetic=True)), {"press": "servo"})
    saved.save(tmp_path / "press")
    read = PressCurves.read(tmp_path / "press")
    assert read.synthetic and [v.synthetic for v in read.levels] == [False, True]
    assert read.info["press"] == "servo" and read.info["synthetic"] is True
    for a, b in zip(saved.levels, read.levels, strict=True):
        pd.testing.assert_frame_equal(a.curves, b.curves)
        assert (a.process, a.T_tool, a.speed, a.lubricant, a.file) == (
            b.process,
            b.T_tool,
            b.speed,
            b.lubricant,
            b.file,
        )


def test_force_work_and_grid_of_the_repeats():
    one = level()
    assert one.max_forces() == pytest.approx([3001.0, 3002.0])
    assert one.works() == pytest.approx([15010.0, 15020.0])
    grid = one.on_grid([5.0, 11.0])
    assert grid[:, 0] == pytest.approx([1501.0, 1502.0])
    assert np.isnan(grid[:, 1]).all()


@pytest.mark.parametrize(
    "text",
    [
        "stroke [mm],force [N],repeat\n0,1000,1\n1,2000,1\n",
        "stroke,force,repeat\nmm,N,-\n0,1000,1\n1,2000,1\n",
        "stroke [m],force [kN]\n0,1\n0.001,2\n",
        "\ufeffstroke;force;repeat;\nm;N;;\n0;1000;1;\n0,001;2000;1;\n",
        "\ufeffstroke\tforce\nm\tMN\n0\t0.001\n0.001\t0.002\n",
    ],
)
def test_units_in_header_or_row_are_converted(tmp_path, text):
    (tmp_path / "c.csv").write_text(text, encoding="utf-8")
    curves = read_curves(tmp_path / "c.csv")
    assert curves["stroke"].tolist() == [0.0, 1.0]
    assert curves["force"].tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["c.csv", "empty"]),
        ("stroke,force\n", ["c.csv", "no rows"]),
        ("stroke,forze\n0,1\n", ["c.csv", "'force'"]),
        ("stroke [inch],force [kN]\n0,1\n", ["c.csv", "'inch'", "mm"]),
        ("stroke,force\n0,1\n1,x\n", ["c.csv", "'force'", "row 1", "'x'"]),
        ("stroke,force\n0,1\n1,nan\n", ["c.csv", "'force'", "row 1"]),
        ("stroke,force\n0,1\n1,1e9\n", ["c.csv", "'force'", "row 1", "1000000000"]),
        ("stroke,force\n2,1\n1,1\n", ["c.csv", "'stroke'", "row 1", "backwards"]),
        ("stroke,force,repeat\n0,1,1\n1,1,\n", ["c.csv", "'repeat'", "row 1"]),
        ("stroke,stroke [mm],force\n0,0,1\n", ["c.csv", "'stroke'", "twice"]),
        ("stroke,force,force\n0,0,1\n", ["c.csv", "'force'", "twice"]),
        ("stroke,force,repeat\n2,1,1\n2,1,2\n1,1,1\n", ["c.csv", "'stroke'", "row 2", "backwards"]),
    ],
)
def test_a_bad_curve_file_is_named_with_its_row(tmp_path, text, words):
    (tmp_path / "c.csv").write_text(text)
    with pytest.raises(InputError) as caught:
        read_curves(tmp_path / "c.csv")
    assert all(word in str(caught.value) for word in words), str(caught.value)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("fra,20,5,oil,a.csv,false", ["row 0", "'fra'", "'fre'"]),
        ("fre,20,-5,oil,a.csv,false", ["'speed'", "row 0", "-5"]),
        ("fre,20,5,oil,../a.csv,false", ["row 0", "inside the folder"]),
        ("fre,20,5,oil,b.csv,false", ["b.csv", "no such file"]),
        ("fre,20,5,oil,a.csv,perhaps", ["row 0", "'perhaps'"]),
    ],
)
def test_a_bad_level_is_named_with_its_row(tmp_path, line, words):
    PressCurves((level(),)).save(tmp_path / "press")
    table = tmp_path / "press" / "levels.csv"
    table.write_text("process,T_tool,speed,lubricant,file,synthetic\n" + line + "\n")
    with pytest.raises(InputError) as caught:
        PressCurves.read(tmp_path / "press")
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_a_folder_without_levels_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"levels\.csv"):
        PressCurves.read(tmp_path)


def test_levels_in_other_units_and_clothes(tmp_path):
    PressCurves((level(),)).save(tmp_path / "press")
    table = tmp_path / "press" / "levels.csv"
    table.write_text(
        "\ufeffT_tool;process;speed [m/s];lubricant;file;\nK;;;;;\n293,15;fre;0,005;oil;a.csv;\n",
        encoding="utf-8",
    )
    (tmp_path / "press" / "press.json").write_text('\ufeff{"press": "servo"}', encoding="utf-8")
    read = PressCurves.read(tmp_path / "press")
    assert (read.levels[0].T_tool, read.levels[0].speed) == (pytest.approx(20.0), pytest.approx(5.0))
    assert read.info["press"] == "servo"
    table.write_text("process,T_tool,T_tool,speed,lubricant,file\nfre,20,30,5,oil,a.csv\n")
    with pytest.raises(InputError, match="'T_tool' stands twice"):
        PressCurves.read(tmp_path / "press")
