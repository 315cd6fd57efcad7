"""libcosimpy: one FMU whose inputs are overridden, or a system from an SSP, or two connected FMUs."""

from __future__ import annotations

import time
from typing import Any

from tests.interop.children.common import done, job, references


def main() -> None:
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.WARNING)
    work = job()
    nanoseconds = round(work["step"] * 1e9)
    index: dict[str, int] = {}
    if "ssp" in work:
        # Without a step size it comes from the archive's annotation.
        execution: Any = CosimExecution.from_ssp_file(work["ssp"])
        index = {name: execution.slave_index_from_instance_name(name) for name in work["fmus"]}
    else:
        execution = CosimExecution.from_step_size(nanoseconds)
        for name, path in work["fmus"].items():
            index[name] = execution.add_local_slave(CosimLocalSlave(path, name))
    number = {name: references(path) for name, path in work["fmus"].items()}

    def place(full: str) -> tuple[int, int]:
        component, _, variable = full.partition(".")
        return index[component], number[component][variable]

    for source, target in work.get("connections", ()):
        execution.connect_real_variables(*place(source), *place(target))
    observer: Any = CosimObserver.create_last_value()
    execution.add_observer(observer)
    override: Any = CosimManipulator.create_override()
    execution.add_manipulator(override)
    values = []
    for k in range(work["steps"]):
        for full, value in zip(work.get("inputs", ()), work["series"][k] if "series" in work else ()):
            slave, reference = place(full)
            override.slave_real_values(slave, [reference], [value])
        assert execution.step()
        values.append([observer.last_real_values(s, [r])[0] for s, r in map(place, work["outputs"])])
    more = work.get("timed", 0)
    began = time.perf_counter()
    if more:
        execution.step(more)
    done(values, seconds=time.perf_counter() - began)


if __name__ == "__main__":
    main()
