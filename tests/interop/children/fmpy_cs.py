"""fmpy, co-simulation: its own classes for FMI 2.0 and 3.0; arrays of FMI 3.0 by the structural parameter n."""

from __future__ import annotations

from typing import Any

from tests.interop.children.common import done, job, references


def main() -> None:
    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Slave
    from fmpy.fmi3 import FMU3Slave

    work = job()
    description: Any = read_model_description(work["fmu"], validate=True)
    number = references(work["fmu"])
    three = description.fmiVersion.startswith("3")
    kind: Any = FMU3Slave if three else FMU2Slave
    slave = kind(
        guid=description.guid,
        unzipDirectory=extract(work["fmu"]),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="friction",
    )
    slave.instantiate()
    inputs, outputs = [number[n] for n in work["inputs"]], [number[n] for n in work["outputs"]]
    values = []
    if three:
        points = work.get("n", 1)
        if points > 1:
            slave.enterConfigurationMode()
            slave.setUInt64([number["n"]], [points])
            slave.exitConfigurationMode()
        slave.enterInitializationMode()
        slave.exitInitializationMode()
    else:
        slave.setupExperiment()
        slave.enterInitializationMode()
        slave.exitInitializationMode()
    for k, row in enumerate(work["series"]):
        if three:
            slave.setFloat64(inputs, row)
            slave.doStep(k * work["step"], work["step"])
            values.append(slave.getFloat64(outputs, nValues=len(outputs) * points))
        else:
            slave.setReal(inputs, row)
            slave.doStep(k * work["step"], work["step"])
            values.append(slave.getReal(outputs))
    slave.terminate()
    slave.freeInstance()
    done(values)


if __name__ == "__main__":
    main()
