"""ecospy: one FMU whose inputs are set, or a system from an SSP, or connected FMUs."""

from __future__ import annotations

import ctypes
import sys
import time
from pathlib import Path
from typing import Any

from tests.interop.children.common import done, job


def main() -> None:
    # Its library wants Intel's tbb, which the wheel of that name puts where no loader looks.
    ctypes.CDLL(str(next(Path(sys.prefix, "lib").glob("libtbb.so.12"))), mode=ctypes.RTLD_GLOBAL)
    from ecospy import EcosSimulation, EcosSimulationStructure
    from ecospy.lib import EcosLib

    EcosLib.set_log_level("warn")
    work = job()
    if "ssp" in work:
        simulation: Any = EcosSimulation(work["step"], ssp_path=work["ssp"])
    else:
        structure: Any = EcosSimulationStructure()
        for name, path in work["fmus"].items():
            structure.add_model(name, path)
        for source, target in work.get("connections", ()):
            structure.make_real_connection(source.replace(".", "::", 1), target.replace(".", "::", 1))
        simulation = EcosSimulation(work["step"], structure=structure)
    if not simulation.init():
        raise RuntimeError(EcosLib.get_last_error())
    values = []
    outputs = [name.replace(".", "::", 1) for name in work["outputs"]]
    for k in range(work["steps"]):
        for full, value in zip(work.get("inputs", ()), work["series"][k] if "series" in work else ()):
            simulation.set_real(full.replace(".", "::", 1), value)
        simulation.step()
        values.append([simulation.get_real(name) for name in outputs])
    more = work.get("timed", 0)
    began = time.perf_counter()
    if more:
        simulation.step(more)
    seconds = time.perf_counter() - began
    simulation.terminate()
    simulation.free()
    done(values, seconds=seconds)


if __name__ == "__main__":
    main()
