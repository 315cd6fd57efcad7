"""Exports for hosts that take code, compiled, driven in the host's order at 10 000 points and compared with ONNX Runtime."""

from __future__ import annotations

import ctypes
import shutil
from pathlib import Path

import numpy as np
import pytest

from fmus.exports import export
from fmus.exports.common import Reference
from fmus.exports.host_units import HostUnits
from fmus.exports.subroutines.lua import lua_functions
from fmus.interface.friction_source import parse_source
from friction_models.common import InputError
from tests.fmus.catalogue import content_of
from tests.fmus.exported import Compiled, Made, as_c, deviation, made, run
from tests.fmus.graphs import Array, graph_bytes, node
from tests.fmus.test_export_subroutines import build_fortran

COUNT = 10_000
DEFORM = ["deform.f", "usr_bcc.f", "usr_upd.f", "selftest.f90"]


def spread(model: Made, seed: int, count: int) -> Array:
    """Loads that fill the trained domain, psi from 1 on."""
    lower = np.maximum(model.lower, [1e-3, -np.inf, 1e-3, 0.0, 1.0])
    return np.random.default_rng(seed).uniform(lower, model.upper, size=(count, 5))


class History:
    """Points that come to the wanted loads in steps, as a host drives them: sd and psi grow from 0 and 1."""

    def __init__(self, model: Made, seed: int, count: int = COUNT, steps: int = 14) -> None:
        self.reference = Reference(model.source)
        self.states = len(model.source.states)
        self.count = count
        self.wanted = spread(model, seed, count)
        self.dt = np.full(steps, 0.01)
        self.dt[-1] = 1e-4
        v = self.wanted[:, 0]
        before = np.maximum(self.wanted[:, 3] - v * self.dt[-1], 0.0) / (self.dt[:-1].sum())
        self.speed = np.vstack([np.repeat(before[None], steps - 1, axis=0), v[None]])
        self.growth = self.wanted[:, 4] ** (1.0 / (steps - 1))
        self.sd = np.cumsum(self.speed * self.dt[:, None], axis=0)
        self.psi = np.cumprod(np.vstack([np.ones(count), np.repeat(self.growth[None], steps - 1, 0)]), axis=0)

    def loads(self, step: int) -> Array:
        return np.column_stack([self.speed[step], self.wanted[:, 1:3], self.sd[step], self.psi[step]])

    def mu(self) -> Array:
        """mu after each step, shape (steps, n)."""
        state = self.reference.model.start_state(self.count)
        found = []
        for step, dt in enumerate(self.dt):
            at = self.loads(step)
            if self.states:
                state = self.reference.step(at, state, float(dt))
            found.append(self.reference.mu(at, state if self.states else None))
        return np.array(found)


def write(path: Path, blocks: list[tuple[str, Array]], formats: str) -> None:
    with path.open("w") as file:
        for head, rows in blocks:
            file.write(head + "\n")
            np.savetxt(file, rows, fmt=formats)


@pytest.mark.parametrize(
    ("name", "units", "count"),
    [
        pytest.param("polynomial", "tonne-mm-s", 1000, marks=pytest.mark.nightly),
        pytest.param("linear + work_exhaustion", "tonne-mm-s", COUNT, marks=pytest.mark.nightly),
        ("linear + work_exhaustion", "english", 500),
        ("linear + tool_roughness", "tonne-mm-s", 500),
    ],
)
def test_deform_follows_the_model_at_ten_thousand_nodes(
    name: str, units: str, count: int, tmp_path: Path
) -> None:
    model = made(name)
    folder = export(model.source, tmp_path / "deform", "deform", units=units)
    for part in DEFORM[:3]:
        assert max(map(len, (folder / part).read_text().splitlines())) <= 72
    build_fortran(folder, DEFORM, "-fcheck=all")
    assert deviation(run(["./driver"], folder)) < 1e-12
    host = HostUnits(units, "degF" if units == "english" else "degC")
    path = History(model, 8, count)
    blocks = []
    for step, mu in enumerate(path.mu()):
        v, T, sigma, _, _ = host.to_host(path.loads(step)).T
        number, zero = np.arange(1.0, count + 1), np.zeros(count)
        rows = [number, T - 5.0, T + 5.0, v, zero, sigma, path.psi[step] * 3.0, zero, mu]
        blocks.append((f"{float(path.dt[step])!r} 0 {count}", np.column_stack(rows)))
    write(folder / "many.txt", blocks, "%d %.17g %.17g %.17g %.17g %.17g %.17g %d %.17g")
    output = run(["./driver", "many.txt"], folder)
    assert f"ok: {14 * count} coefficients" in output
    assert deviation(output) < 1e-12


def test_deform_notices_a_wrong_unit_and_too_few_node_variables(tmp_path: Path) -> None:
    source = made("linear + work_exhaustion").source
    folder = export(source, tmp_path / "deform", "deform")
    code = folder / "deform.f"
    text = code.read_text()
    code.write_text(text.replace("tf_pressure =\n     &  1d0", "tf_pressure =\n     &  1.001d0"))
    assert code.read_text() != text
    build_fortran(folder, DEFORM)
    with pytest.raises(AssertionError, match="expected"):
        run(["./driver"], folder)
    code.write_text(text.replace("tf_first = 1\n", "tf_first = 9\n"))
    build_fortran(folder, DEFORM)
    with pytest.raises(AssertionError, match="11 user node variables; needed: at least 16"):
        run(["./driver"], folder)
    with pytest.raises(InputError, match="units of the host 'kg-mm-ms'; allowed: english, tonne-mm-s"):
        export(source, tmp_path / "x", "deform", units="kg-mm-ms")


DOUBLE = ["-fdefault-real-8", "-fdefault-double-8"]


@pytest.mark.parametrize(
    ("name", "units", "temperature", "count"),
    [
        pytest.param("polynomial", "tonne-mm-s", "degC", 1000, marks=pytest.mark.nightly),
        ("linear + work_exhaustion", "kg-mm-ms", "K", COUNT),
        pytest.param("linear + tool_roughness", "kg-m-s", "K", 100, marks=pytest.mark.nightly),
    ],
)
def test_lsdyna_follows_the_model_at_ten_thousand_nodes(
    name: str, units: str, temperature: str, count: int, tmp_path: Path
) -> None:
    model = made(name)
    folder = export(model.source, tmp_path / "lsdyna", "lsdyna", units=units, temperature=temperature)
    assert max(map(len, (folder / "lsdyna.f").read_text().splitlines())) <= 72
    build_fortran(folder, ["lsdyna.f", "selftest.f90"], *DOUBLE, "-fcheck=all")
    assert deviation(run(["./driver"], folder)) < 1e-12
    host = HostUnits(units, temperature)
    path = History(model, 9, count, steps=3)
    blocks = [(" ".join(repr(p.start) for p in model.source.system), np.empty((0, 12)))]
    for step, mu in enumerate(path.mu()):
        v, T, sigma, _, _ = host.to_host(path.loads(step)).T
        dt = float(path.dt[step]) / host.time
        area, zero, one = path.psi[step] * 2.0, np.zeros(count), np.ones(count)
        rows = [
            np.arange(1.0, count + 1),
            area,
            -sigma * area,
            v * dt,
            zero,
            one,
            zero,
            zero,
            one,
            T - 9.0,
            T + 9.0,
            mu,
        ]
        blocks.append((f"{dt!r} {count} 0. 1e15", np.column_stack(rows)))
    write(folder / "many.txt", blocks, "%d" + 11 * " %.17g")
    output = run(["./driver", "many.txt"], folder)
    assert f"ok: {3 * count} coefficients" in output
    assert deviation(output) < 1e-12
    build_fortran(folder, ["lsdyna.f", "selftest.f90"], "-Wno-conversion")  # the single precision version
    assert 0.0 < deviation(run(["./driver"], folder)) < 1e-6


def test_lsdyna_takes_the_dynamic_coefficient_where_a_load_is_no_number(tmp_path: Path) -> None:
    source = made("linear + work_exhaustion").source
    folder = export(source, tmp_path / "lsdyna", "lsdyna", thermal=False)
    build_fortran(folder, ["lsdyna.f", "selftest.f90"], *DOUBLE)
    assert deviation(run(["./driver"], folder)) < 1e-12
    row = "5 1. -800. 0.1 0. 0. 0. 0. 1. 0. 0. "
    (folder / "bad.txt").write_text("\n1e-3 1 NaN 1e9\n" + row + "0.25\n")  # the driver's FRIC2 is 0.25
    assert "ok: 1 coefficients" in run(["./driver", "bad.txt"], folder)
    (folder / "good.txt").write_text("\n1e-3 1 80. 1e9\n" + row + "0.25\n")
    with pytest.raises(AssertionError, match="expected"):
        run(["./driver", "good.txt"], folder)
    with pytest.raises(InputError, match="thermal = 'maybe', allowed: true, false"):
        export(source, tmp_path / "x", "lsdyna", thermal="maybe")
    driver = folder / "selftest.f90"
    driver.write_text(driver.read_text().replace("nhv = 4 + 2", "nhv = 3"))
    build_fortran(folder, ["lsdyna.f", "selftest.f90"], *DOUBLE)
    with pytest.raises(AssertionError, match=r"NHSV = 3 in .*; needed: at least 4"):
        run(["./driver"], folder)


#: Every operator of our own models is in one of these; all of the catalogue agree, which takes 20 s.
IN_LUA = [
    "power_law",
    "ffnn + work_exhaustion + tool_roughness",
    "gradient_boosting",
    "polynomial + stribeck + flash_temperature + rate_state + work_exhaustion",
]


def lua() -> str:
    found = next((c for c in ("lua5.4", "lua", "luajit") if shutil.which(c)), None)
    if found is None:
        pytest.skip("no Lua interpreter (lua5.4): the Lua of this export is not run")
    return found


@pytest.mark.parametrize(
    "name", [IN_LUA[0], *(pytest.param(n, marks=pytest.mark.nightly) for n in IN_LUA[1:3]), IN_LUA[3]]
)
def test_qform_follows_the_model_at_ten_thousand_points(name: str, tmp_path: Path) -> None:
    source = parse_source(content_of(name), name)
    folder = export(source, tmp_path / "qform", "qform", units="kg-m-s", temperature="K")
    assert deviation(run([lua(), "selftest.lua"], folder)) < 1e-12
    # The five loads freely, each point with memory from a step of its own: asked for within the script.
    lower, upper = (np.array(x) for x in (source.box.lower, source.box.upper))
    count = 1000 if name.startswith("ffnn") else COUNT  # a network takes Lua 0.3 ms a point
    points = np.random.default_rng(10).uniform(lower, upper, size=(count, 5))
    reference = Reference(source)
    state = reference.model.start_state(count)
    if source.states:
        state = reference.step(points, state, 0.02)
    mu = reference.mu(points, state if source.states else None)
    np.savetxt(folder / "points.txt", np.column_stack([points, state, mu]), fmt="%.17g")
    (folder / "ask.lua").write_text(
        "function set_target_workpiece() end\nfunction parameter(_, x) return x end\n"
        "function result(n, x) return x end\n"
        + (folder / "qform.lua").read_text()
        + f"""
local worst = 0.0
for line in io.lines("points.txt") do
  local x = {{}}
  for word in line:gmatch("%S+") do x[#x + 1] = tonumber(word) end
  local memory = {{}}
  for i = 1, {len(source.states)} do memory[i] = x[5 + i] end
  worst = math.max(worst, math.abs(tf_coefficient(x, memory) - x[#x]))
end
print(string.format("ok: largest deviation %.1e", worst))
"""
    )
    assert deviation(run([lua(), "ask.lua"], folder)) < 1e-12


def test_qform_takes_the_names_of_the_fields_and_refuses_what_lua_has_not(tmp_path: Path) -> None:
    source = made("linear + work_exhaustion").source
    names = {"T_tool": "T", "v_rel": "v_slide", "sigma_n": "p_contact"}
    folder = export(source, tmp_path / "qform", "qform", fields=names)
    text = (folder / "qform.lua").read_text()
    assert "function FrictionStress(T, v_slide, p_contact, tf_sd, tf_mu, tf_work)" in text
    with pytest.raises(InputError, match=r"field of 'v_rel' is 'v, os.exit\(\)', allowed: a name"):
        export(source, tmp_path / "x", "qform", fields={"v_rel": "v, os.exit()"})
    with pytest.raises(InputError, match="did you mean 'sigma_n'"):
        export(source, tmp_path / "x", "qform", fields={"sigma": "p"})
    rounded = graph_bytes(
        [
            node("Gather", "loads i0", "v", axis=1),
            node("Cast", "v", "f", to=1),
            node("Cast", "f", "mu", to=11),
        ],
        {"i0": np.array([0])},
    )
    with pytest.raises(InputError, match="single precision has no counterpart in Lua"):
        lua_functions(parse_source(rounded, "rounded.onnx"))
    assert deviation(run([lua(), "selftest.lua"], folder)) < 1e-12
    code = folder / "qform.lua"
    code.write_text(text.replace("0.5 * (T + T_tool)", "0.501 * (T + T_tool)"))
    assert code.read_text() != text
    with pytest.raises(AssertionError, match="expected"):
        run([lua(), "selftest.lua"], folder)


@pytest.mark.parametrize(
    ("target", "parts"),
    [
        ("deform", DEFORM),
        pytest.param("lsdyna", ["lsdyna.f", "selftest.f90"], marks=pytest.mark.nightly),
    ],
)
def test_effects_that_remember_go_through_the_fortran_hosts(
    target: str, parts: list[str], tmp_path: Path
) -> None:
    """Speed, contact heating, rate and state, and exhausted lubricant in one model: several states a point."""
    source = parse_source(content_of(IN_LUA[-1]), IN_LUA[-1])
    assert len(source.states) >= 2
    folder = export(source, tmp_path / target, target)
    build_fortran(folder, parts, *(DOUBLE if target == "lsdyna" else []))
    assert deviation(run(["./driver"], folder)) < 1e-12


def test_c_and_marc_follow_the_model_at_ten_thousand_points(tmp_path: Path) -> None:
    model = made("polynomial")
    code = Compiled(export(model.source, tmp_path / "c", "c"))
    loads = spread(model, 12, COUNT)
    found = np.empty(COUNT)
    assert code("mu_many")(ctypes.c_size_t(COUNT), as_c(loads.T.copy()), None, None, 1, as_c(found)) == 0
    np.testing.assert_allclose(found, Reference(model.source).mu(loads), rtol=0.0, atol=1e-12)

    model = made("linear + work_exhaustion")
    folder = export(model.source, tmp_path / "ufric", "ufric")
    build_fortran(folder, ["ufric.f", "selftest.f90"])
    path = History(model, 13, COUNT, steps=3)
    path.psi[:] = 1.0  # UFRIC is not handed it
    rows, zero = [], np.zeros(COUNT)
    for step, mu in enumerate(path.mu()):
        v, T, sigma, _, _ = path.loads(step).T
        now = np.full(COUNT, path.dt[: step + 1].sum())
        number = np.arange(1.0, COUNT + 1)
        rows.append(np.column_stack([number, zero + step + 1, now, number, zero, v, zero, T, sigma, mu]))
    np.savetxt(folder / "many.txt", np.vstack(rows), fmt="%d %d" + 8 * " %.17g")
    output = run(["./driver", "many.txt"], folder)
    assert f"ok: {3 * COUNT} calls" in output and deviation(output) < 1e-12


def test_abaqus_subroutines_follow_the_model_at_ten_thousand_points(tmp_path: Path) -> None:
    """Eight points through 1250 increments: every load anywhere in the domain, sd growing to its end."""
    model = made("linear + work_exhaustion")
    folder = export(model.source, tmp_path / "vfric", "vfric")
    build_fortran(folder, ["vfric.f", "selftest/selftest.f90"], "-I", "selftest")
    reference, points, rng = Reference(model.source), 8, np.random.default_rng(14)
    loads = spread(model, 14, COUNT).reshape(-1, points, 5)
    dt = float(model.upper[3] / loads[:, :, 0].sum(axis=0).max())
    sd, state = np.zeros(points), reference.model.start_state(points)
    text = ["1. 20."]
    for inc, at in enumerate(loads, 1):
        area = at[:, 4] if inc > 1 else np.ones(points)
        turn = rng.uniform(0.0, 2.0 * np.pi, points)
        slip = np.column_stack([np.cos(turn), np.sin(turn), 0.0 * turn]) * (at[:, 0] * dt)[:, None]
        sd += np.sqrt((slip**2).sum(axis=1))
        now = np.column_stack([np.sqrt((slip**2).sum(axis=1)) / dt, at[:, 1:3], sd, area])
        state = reference.step(now, state, dt)
        mu = reference.mu(now, state)
        text.append(f"{inc} {dt!r} {points}")
        values = np.column_stack([slip, at[:, 2] * area, area, at[:, 1], at[:, 1], mu])
        text += [f"{k + 1} " + " ".join(f"{x:.17g}" for x in row) for k, row in enumerate(values)]
    (folder / "many.txt").write_text("\n".join(text) + "\n")
    output = run(["./driver", "many.txt"], folder)
    assert f"ok: {2 * COUNT} forces" in output and deviation(output) < 1e-12
