"""Two tiny FMUs whose coupled recursion can be written down, built with PythonFMU for the master's tests."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from pythonfmu import FmuBuilder

LAW = '''
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class {name}(Fmi2Slave):
    """mu = offset + slope * load, at n points."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.loads = [1.0] * {n}
        self.offset = {offset}
        for k in range({n}):
            self.register_variable(Real(
                f"load[{{k + 1}}]", causality=Fmi2Causality.input, start=1.0, variability=Fmi2Variability.continuous,
                getter=lambda k=k: self.loads[k], setter=lambda v, k=k: self.loads.__setitem__(k, v)))
        self.register_variable(Real("offset", causality=Fmi2Causality.parameter, start={offset},
                                    variability=Fmi2Variability.fixed))
        for k in range({n}):
            self.register_variable(Real(
                f"mu[{{k + 1}}]", causality=Fmi2Causality.output, variability=Fmi2Variability.continuous,
                getter=lambda k=k: self.offset + {slope} * self.loads[k]))

    def do_step(self, current_time, step_size):
        return self.loads[0] < {fails_above}
'''

PROCESS = '''
from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class {name}(Fmi2Slave):
    """load[k] grows by (k + 1) * mu[k] * h; stroke is time; force is the sum of the loads."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.load = [1.0] * {n}
        self.mu = [0.0] * {n}
        self.stroke = 0.0
        for k in range({n}):
            self.register_variable(Real(
                f"mu[{{k + 1}}]", causality=Fmi2Causality.input, start=0.0, variability=Fmi2Variability.continuous,
                getter=lambda k=k: self.mu[k], setter=lambda v, k=k: self.mu.__setitem__(k, v)))
            self.register_variable(Real(
                f"load[{{k + 1}}]", causality=Fmi2Causality.output, variability=Fmi2Variability.continuous,
                getter=lambda k=k: self.load[k], setter=lambda v, k=k: self.load.__setitem__(k, v)))
        self.register_variable(Boolean("high", causality=Fmi2Causality.output,
                                       variability=Fmi2Variability.discrete,
                                       getter=lambda: self.load[0] > 1.5, setter=lambda v: None))
        self.register_variable(Real("stroke", causality=Fmi2Causality.output))
        self.register_variable(Real("force", causality=Fmi2Causality.output, getter=lambda: sum(self.load)))

    def do_step(self, current_time, step_size):
        for k in range({n}):
            self.load[k] += (k + 1) * self.mu[k] * step_size
        self.stroke = current_time + step_size
        return True

    def _get_fmu_state(self):
        return {{"load": list(self.load), "mu": list(self.mu), "stroke": self.stroke}}

    def _set_fmu_state(self, state):
        self.load, self.mu, self.stroke = list(state["load"]), list(state["mu"]), state["stroke"]
'''


def build(source: str, name: str, folder: Path, **values: float | int) -> Path:
    """Write the script under its own module name and build the FMU."""
    script = folder / f"{name}.py"
    script.write_text(source.format(name=name, **values), encoding="utf-8")
    built = FmuBuilder.build_FMU(script, dest=folder, canGetAndSetFMUstate=True)
    return Path(built)


def law(
    folder: Path, name: str, n: int = 2, offset: float = 0.1, slope: float = 0.5, fails_above: float = 1e9
) -> Path:
    return build(LAW, name, folder, n=n, offset=offset, slope=slope, fails_above=fails_above)


def process(folder: Path, name: str, n: int = 2) -> Path:
    return build(PROCESS, name, folder, n=n)


def slow_process(folder: Path, name: str, mark: Path) -> Path:
    """The same process, a tenth of a second a step, all of it in Python; it writes the file `mark` when it steps."""
    begin = "    def do_step(self, current_time, step_size):\n"
    slow = (
        f"        open({str(mark)!r}, 'w').close()\n"
        "        end = __import__('time').monotonic() + 0.1\n"
        "        while __import__('time').monotonic() < end:\n"
        "            pass\n"
    )
    return build(PROCESS.replace(begin, begin + slow), name, folder, n=2)


def system_content(law_fmu: Path, process_fmu: Path, **changes: object) -> dict[str, object]:
    """The system of both, as it would stand in a YAML file."""
    content: dict[str, object] = {
        "name": "tiny",
        "communication_step": 0.1,
        "stop_time": 1.0,
        "components": {
            "friction": {"fmu": str(law_fmu), "start": {"offset": 0.1}},
            "forming": {"fmu": str(process_fmu)},
        },
        "connections": ["forming.load -> friction.load", "friction.mu -> forming.mu"],
    }
    return content | changes


def write_system(folder: Path, tiny: Mapping[str, Path]) -> None:
    """Write a law and a process, and ``system.yaml`` that couples them for five steps, into a user's folder."""
    for name in ("law", "process"):
        (folder / f"{name}.fmu").write_bytes(tiny[name].read_bytes())
    (folder / "system.yaml").write_text(
        "communication_step: 0.1\nstop_time: 0.5\ncomponents:\n"
        "  friction: {fmu: law.fmu}\n  forming: {fmu: process.fmu}\n"
        "connections: ['forming.load -> friction.load', 'friction.mu -> forming.mu']\n"
    )
