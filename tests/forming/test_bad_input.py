"""What cannot be: refused in one sentence with the parameter, its value and what is allowed; nothing but InputError."""

from __future__ import annotations

import inspect
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from forming import BackwardCupExtrusion, ForwardRodExtrusion
from forming.processes.specimen_upsetting import upset
from forming.processes.upsetting import RingCompression, Upsetting
from forming.tools.punch_geometry import PunchGeometry
from friction_models.common import InputError

PROCESSES = (ForwardRodExtrusion, BackwardCupExtrusion, Upsetting, RingCompression)
FLAGS = ("tool_heating", "isothermal", "remeshing")
MATERIALS = ("material", "tool_material")
COARSE = {"mesh_size": 0.8, "n_points": 30, "tool_heating": False}
#: A temperature, if a low one; nothing else.
COLD = -7.5
#: Values that are no dimension, speed, temperature, count, flag or material.
NONSENSE = (
    math.nan,
    math.inf,
    -math.inf,
    COLD,
    10**400,
    "20",
    "no",
    b"x",
    [1, 2],
    {"a": 1},
    1 + 2j,
    np.array([1.0, 2.0]),
)


def parameters(process) -> list[str]:
    """Return the names of all parameters of a constructor, those of its base, too, where it passes them on."""
    names: list[str] = []
    for kind in process.__mro__:
        if "__init__" not in vars(kind):
            continue
        own = inspect.signature(kind).parameters.values()
        names += [p.name for p in own if p.kind is not p.VAR_KEYWORD]
        if all(p.kind is not p.VAR_KEYWORD for p in own):
            break
    return sorted(set(names))


def is_one_sentence(message: str, name: str, value: object) -> bool:
    shown = value if isinstance(value, str) else repr(value)
    named = name in message and (str(shown)[:8] in message or f"{value!s:.8}" in message)
    return named and "allowed" in message and "\n" not in message and len(message) < 400


@pytest.mark.parametrize("process", PROCESSES)
def test_nonsense_for_any_parameter_is_refused_by_name_and_value(process):
    names = parameters(process)
    assert len(names) >= 15 and "speed" in names and "tool_material" in names
    for name in names:
        for value in NONSENSE:
            if name in ("T_ambient", "T_tool") and value is COLD:
                continue
            with pytest.raises(InputError) as caught:
                process(**{name: value})
            if name in MATERIALS:  # files and names of materials have sentences of their own
                assert "allowed" in str(caught.value) or "material" in str(caught.value)
            else:
                assert is_one_sentence(str(caught.value), name, value), (name, value, str(caught.value))


@pytest.mark.parametrize(
    ("process", "wrong", "sentence"),
    [
        (BackwardCupExtrusion, {"punch_diameter": 21.0}, "punch_diameter = 21.0 mm; allowed: 7 to 18.4 mm"),
        (ForwardRodExtrusion, {"exit_diameter": 25.0}, "exit_diameter = 25.0 mm; allowed: 4 to 19.4 mm"),
        (ForwardRodExtrusion, {"entry_radius": -1.0}, "entry_radius = -1.0 mm; allowed: 0.05 to 10 mm"),
        (ForwardRodExtrusion, {"billet_length": 0.0}, "billet_length = 0.0 mm; allowed: 10 to 200 mm"),
        (BackwardCupExtrusion, {"edge_radius": 9.0}, "edge_radius = 9.0 mm; allowed: 0.2 to 5.656 mm"),
        (
            ForwardRodExtrusion,
            {"T_billet": 600.0},
            "T_billet = 600 degC; allowed: 0 to 500 degC, the range of",
        ),
        (RingCompression, {"bore_diameter": 12.0}, "bore_diameter = 12.0 mm; allowed: 0.6 to 10.8 mm"),
    ],
)
def test_geometry_and_material_that_cannot_be(process, wrong, sentence):
    with pytest.raises(InputError) as caught:
        process(**wrong)
    assert sentence in str(caught.value)


def test_a_reduction_of_more_than_the_whole_height_is_refused():
    with pytest.raises(InputError, match=r"upsetting: stroke = 16\.0 mm; allowed: 0\.001 to 12 mm"):
        Upsetting().run(0.1, 16.0)


@pytest.mark.parametrize("mu", [math.nan, -0.1, math.inf, 1e6, "0.1", None, 1j, [0.1], [[0.1], [0.2, 0.3]]])
def test_friction_that_cannot_be_is_refused_before_the_start(mu):
    with pytest.raises(InputError, match=r"friction: mu .*allowed: "):
        ForwardRodExtrusion(**COARSE).run(mu, 1.0)


@pytest.mark.parametrize(
    ("gives", "words"),
    [
        (math.nan, r"mu = nan at marker 7 and stroke 0\.300 mm; allowed: finite, 0 to 10"),
        (-0.1, r"mu = -0\.1 at marker 7 and stroke 0\.300 mm; allowed: finite, 0 to 10"),
        ("thick", r"mu = .*thick.* at stroke 0\.300 mm; allowed: a number from 0 to 10"),
    ],
)
def test_a_run_whose_friction_law_fails_keeps_what_it_has(gives, words):
    def law(loads, t):
        mu = np.full(len(loads), 0.1).astype(object)
        if t > 0.05:
            mu[7] = gives
        return mu if isinstance(gives, str) and t > 0.05 else mu.astype(float)

    process = ForwardRodExtrusion(**COARSE)
    with pytest.raises(InputError, match=words):
        process.run(law, 1.0)
    kept = process.result
    assert kept is not None and kept.status == "stopped"
    assert kept.message.startswith("stopped at stroke 0.300 mm: friction: mu = ")
    assert kept.stroke[-1] == pytest.approx(0.3) and np.isfinite(kept.force).all() and kept.force[-1] > 0.0


def test_a_friction_law_cannot_change_the_loads():
    def law(loads, t):
        loads[:] = np.nan
        return np.full(len(loads), 0.1)

    result = ForwardRodExtrusion(**COARSE).run(law, 0.4)
    assert result.status == "ok" and np.isfinite(result.contact.loads).all()


def test_a_run_that_leaves_the_range_of_its_material_says_so():
    result = ForwardRodExtrusion(**COARSE, T_billet=480.0, T_tool=480.0, speed=500.0).run(0.15, 3.0)
    assert np.isfinite(result.force).all()
    (warning,) = result.warnings
    assert "material '16MnCr5': temperature reached" in warning and "known for 0 to 500 degC" in warning


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"speed": "a"}, "upset: speed = 'a' mm/s; allowed: "),
        ({"mesh_size": None}, "upset: mesh_size = None mm; allowed: 0.1 to 1.875 mm"),
        ({"T_tool": math.nan}, "upset: T_tool = nan degC; allowed: "),
        ({"T0": 700.0}, "upset: T0 = 700 degC; allowed: 0 to 500 degC, the range of material '16MnCr5'"),
        ({"n_radii": -1}, "upset: n_radii = -1; allowed: "),
        ({"force": "a"}, "upset: force = 'a'; allowed: "),
        ({"force": ([0.0, 1.0], "b")}, "upset: force = ([0.0, 1.0], 'b'); allowed: "),
        ({"force": math.nan}, "upset: highest force = nan N; allowed: "),
        ({"mu": -1}, "friction: mu = -1.0 at marker 0 and stroke 0.000 mm; allowed: finite, 0 to 10"),
    ],
)
def test_upsetting_to_a_force_refuses_what_cannot_be(wrong, sentence):
    with pytest.raises(InputError) as caught:
        upset(**wrong)
    assert str(caught.value).startswith(sentence)


@pytest.mark.parametrize("value", NONSENSE)
def test_punches_refuse_nonsense(value):
    for name in ("specimen_diameter", "specimen_height", "bore_diameter", "tip_diameter", "tip_height"):
        with pytest.raises(InputError, match=rf"punch: {name} = "):
            PunchGeometry(**{name: value})


def rods():
    """Ranges of a rod, each a little wider than what is allowed."""
    return st.fixed_dictionaries(
        {"exit_diameter": st.floats(3.5, 19.8), "half_angle": st.floats(9.0, 81.0)},
        optional={
            "billet_length": st.floats(9.0, 60.0),
            "speed": st.floats(0.001, 2100.0),
            "T_billet": st.floats(-10.0, 520.0),
            "T_tool": st.floats(-55.0, 720.0),
            "entry_radius": st.floats(0.0, 10.5),
            "edge_radius": st.floats(0.0, 10.5),
            "land": st.floats(0.0, 21.0),
            "relief": st.floats(0.0, 21.0),
            "container_length": st.floats(20.0, 100.0),
            "die_outer_diameter": st.floats(22.0, 200.0),
            "press_stiffness": st.floats(5.0, 1000.0),
        },
    )


def cups():
    """Ranges of a cup, each a little wider than what is allowed."""
    return st.fixed_dictionaries(
        {"punch_diameter": st.floats(6.5, 19.0), "nose_angle": st.floats(-1.0, 31.0)},
        optional={
            "billet_length": st.floats(5.0, 60.0),
            "speed": st.floats(0.001, 2100.0),
            "T_billet": st.floats(-10.0, 520.0),
            "edge_radius": st.floats(0.1, 3.0),
            "land": st.floats(0.0, 21.0),
            "tip_radius": st.floats(0.0, 20.5),
            "relief": st.floats(0.0, 3.0),
            "punch_length": st.floats(0.5, 2050.0),
        },
    )


def rings():
    """Ranges of a ring, each a little wider than what is allowed."""
    return st.fixed_dictionaries(
        {"bore_diameter": st.floats(0.5, 11.0), "height": st.floats(1.0, 31.0)},
        optional={
            "speed": st.floats(0.001, 2100.0),
            "T_billet": st.floats(-10.0, 520.0),
            "T_tool": st.floats(-55.0, 720.0),
            "shear_factor": st.floats(-0.05, 1.05),
            "isothermal": st.booleans(),
            "remeshing": st.booleans(),
            "htc": st.floats(-1.0, 500.0),
            "T_ambient": st.floats(-60.0, 750.0),
            "h_ambient": st.floats(-1.0, 500.0),
        },
    )


def a_result_without_nan_or_one_sentence(process, given_values, mu, share):
    try:
        size = {} if process is RingCompression else {"mesh_size": 0.8}
        made = process(**given_values, **size, n_points=20, tool_heating=False)
        # Only the beginning: whether a run ends at its stroke is what the sweep measures.
        result = made.run(mu, max(0.01, 0.1 * share * made.max_stroke))
    except InputError as error:
        message = str(error)
        assert "allowed" in message and "\n" not in message and len(message) < 400, message
        assert any(name in message for name in [*parameters(process), "friction: mu"]), message
        return
    numbers = [result.force, result.work, result.stroke, result.contact.loads, result.contact.position]
    assert all(np.isfinite(values).all() for values in numbers)
    assert math.isfinite(result.energy_balance) and math.isfinite(result.volume_change)
    assert result.status == "ok" or result.message.startswith("stopped at stroke")


@settings(max_examples=40, deadline=None, derandomize=True)
@given(rods(), st.floats(-0.02, 0.5), st.floats(0.0, 1.0))
def test_any_rod_gives_a_result_without_nan_or_one_sentence(given_values, mu, share):
    a_result_without_nan_or_one_sentence(ForwardRodExtrusion, given_values, mu, share)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(cups(), st.floats(-0.02, 0.5), st.floats(0.0, 1.0))
def test_any_cup_gives_a_result_without_nan_or_one_sentence(given_values, mu, share):
    a_result_without_nan_or_one_sentence(BackwardCupExtrusion, given_values, mu, share)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(rings(), st.floats(-0.02, 0.5), st.floats(0.0, 1.0))
def test_any_ring_gives_a_result_without_nan_or_one_sentence(given_values, mu, share):
    a_result_without_nan_or_one_sentence(RingCompression, given_values, mu, share)
