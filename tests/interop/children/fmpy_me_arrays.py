"""fmpy's class for FMI 3.0 model exchange, with arrays of structural length, driven by hand."""

from __future__ import annotations

from typing import Any

from tests.interop.children.common import done, job, references


def main() -> None:
    from fmpy import extract, read_model_description
    from fmpy.fmi3 import FMU3Model

    work = job()
    description: Any = read_model_description(work["fmu"], validate=True)
    number = references(work["fmu"])
    model: Any = FMU3Model(
        guid=description.guid,
        unzipDirectory=extract(work["fmu"]),
        modelIdentifier=description.modelExchange.modelIdentifier,
        instanceName="friction",
    )
    model.instantiate()
    model.enterConfigurationMode()
    model.setUInt64([number["n"]], [work["n"]])
    model.exitConfigurationMode()
    model.enterInitializationMode()
    model.exitInitializationMode()
    model.updateDiscreteStates()
    model.enterContinuousTimeMode()
    inputs, outputs = [number[n] for n in work["inputs"]], [number[n] for n in work["outputs"]]
    values = []
    for k, row in enumerate(work["series"]):
        model.setTime(k * work["step"])
        model.setFloat64(inputs, row)
        values.append(model.getFloat64(outputs, nValues=len(outputs) * work["n"]))
    model.terminate()
    model.freeInstance()
    done(values)


if __name__ == "__main__":
    main()
