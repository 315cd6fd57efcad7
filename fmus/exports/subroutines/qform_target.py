"""``--target qform``: a user subroutine of QForm, in Lua from the graph that the C is generated from.

QForm's manual (Processor user subroutines) shows `FrictionStress`, `UserFields`, `result` and `store`; the names of the fields of
the contact are not public, so they are an option.
"""

from __future__ import annotations

import re

import numpy as np

from friction_models.common import InputError
from friction_models.loads import LOADS

from ...interface.friction_source import FrictionSource
from .. import options
from ..common import Files, Reference, description, documents, domain_limits, one_line, template, test_box
from ..host_units import HostUnits, host_units
from .lua import lua_functions, lua_list, lua_number
from .ufric_target import depends_on

OPTIONS = ("fields", "units", "temperature")
#: Fields of the contact by what they are; only `T` is named in the public manual.
FIELDS = {"T": "T", "T_tool": "T_tool", "v_rel": "sliding_velocity", "sigma_n": "pressure"}


def history(
    source: FrictionSource, units: HostUnits, apart: float = 4.0, points: int = 4, steps: int = 8
) -> str:
    """Return the calls of the self-test.

    For each step dt and the number of points, then two iterations: a row a point with both temperatures, speed, pressure, expected
    mu, and 1 in the last iteration. The temperatures are `apart` from their mean. Point 2 loses contact for a while.
    """
    reference = Reference(source)
    lower, upper = test_box(source)
    rng = np.random.default_rng(26)
    sd, state = np.zeros(points), reference.model.start_state(points)
    before = np.zeros((points, 5))
    before[:, 4] = 1.0
    rows = []
    for step in range(1, steps + 1):
        dt = float(rng.uniform(2e-3, 1e-2))
        for k in range(points):
            if before[k, 2] > 0.0:
                sd[k] += before[k, 0] * dt
            at = before[k : k + 1].copy()
            at[0, 3] = sd[k]
            state[k : k + 1] = reference.step(at, state[k : k + 1], dt)
        for last in (0, 1):
            rows.append(f"{dt / units.time:.17g} {points}")
            for k in range(points):
                v, T, sigma = rng.uniform(lower[:3], upper[:3])
                if k == 1 and step in (3, 4):
                    sigma = 0.0
                before[k] = (v, T, sigma, sd[k], 1.0)
                mu = float(reference.mu(before[k : k + 1], state[k : k + 1])[0])
                host = units.to_host(before[k : k + 1])[0]
                numbers = (host[1] - apart, host[1] + apart, host[0], host[2], mu)
                rows.append(" ".join(f"{float(x):.17g}" for x in numbers) + f" {last}")
    return "\n".join(rows) + "\n"


def qform_files(
    source: FrictionSource, fields: object = None, units: object = "tonne-mm-s", temperature: object = None
) -> Files:
    """Return the files of a QForm export.

    `fields` are names of the fields of the contact by ``T``, ``T_tool``, ``v_rel``, ``sigma_n``; `units` and `temperature`
    are theirs (`host_units`).
    Raises InputError: a name that is no Lua name, unknown units, or a graph that is not translated.

    Examples
    --------
    >>> from fmus.source.reading import read_source
    >>> from friction_models import ConstantFriction
    >>> sorted(qform_files(read_source(ConstantFriction(mu=0.1))))[3:]
    ['model.onnx', 'qform.lua', 'selftest.lua', 'selftest.txt']
    """
    host = host_units(units, temperature)
    names = FIELDS | {k: _field(k, v) for k, v in options.mapping("fields", fields, FIELDS).items()}
    states = [f"tf_{s.name}" for s in source.states]
    lower, upper = domain_limits(source)
    step = (
        "  local x = limited(loads, false)\n  if not x then return nil end\n"
        "  if not (x[3] > 0.0) or dt == 0.0 then return memory end\n"
        "  local y = tf_model_step(x, memory, tf_system, dt)\n"
        "  for i = 1, #y do if not finite(y[i]) then return nil end end\n  return y\n"
    )
    given = ", ".join(dict.fromkeys(names[k] for k in FIELDS))
    values = description(source) | {
        "FIELDS": given,
        "UNITS": f"{host.names[0]}/{host.names[1]}, {host.names[2]}, {host.temperature}",
        "SPEED": lua_number(host.speed),
        "PRESSURE": lua_number(host.pressure),
        "TIME": lua_number(host.time),
        "T_FACTOR": lua_number(host.warmth.factor),
        "T_OFFSET": lua_number(host.warmth.offset),
        "SYSTEM_LINES": "".join(
            f"\n  {lua_number(p.start)}, -- {one_line(f'{p.name} [{p.unit}]')}" for p in source.system
        )
        + ("\n" if source.system else ""),
        "STATE_FIELDS": "".join(
            f'local tf_field_{k} = result("{n}", {lua_number(s.start)})\n'
            for k, (n, s) in enumerate(zip(states, source.states))
        ),
        "LUA_MODEL": lua_functions(source),
        "LOAD_LOWER": lua_list([q.lower for q in LOADS]),
        "LOAD_UPPER": lua_list([q.upper for q in LOADS]),
        "DOMAIN_LOWER": lua_list(lower),
        "DOMAIN_UPPER": lua_list(upper),
        "STEP_LUA": step if states else "  return limited(loads, false) and memory\n",
        "PREV_STATES": "".join(f", prev_{n}" for n in states),
        "MEMORY": ", ".join(f"prev_{n}" for n in states),
        "STORE_STATES": "".join(f"  store(tf_field_{k}, following[{k + 1}])\n" for k in range(len(states))),
        "STATE_ARGUMENTS": "".join(f", {n}" for n in states),
        "MEMORY_NOW": ", ".join(states),
        "FIELD_T": names["T"],
        "FIELD_T_TOOL": names["T_tool"],
        "FIELD_V": names["v_rel"],
        "FIELD_P": names["sigma_n"],
        "DEPENDS": ", ".join(depends_on(source)) or "none of the loads",
    }
    return {
        "qform.lua": template("qform.lua", values),
        "selftest.lua": template("qform_selftest.lua", values),
        "selftest.txt": history(source, host, 0.0 if names["T"] == names["T_tool"] else 4.0),
        "README.txt": template("readme_qform.txt", values),
        **documents(source),
    }


def _field(what: str, name: object) -> str:
    if isinstance(name, str) and re.fullmatch(r"[A-Za-z_]\w*", name, flags=re.ASCII) and len(name) <= 60:
        return name
    raise InputError(f"field of {what!r} is {name!r}, allowed: a name of letters, digits and underscores")
