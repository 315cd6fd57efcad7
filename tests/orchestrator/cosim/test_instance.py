"""One instance: whose message is whose, what formats become, and what failing calls say."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fmus.runtime.c_interface.slave import binaries
from fmus.runtime.fmu_files import UnpackedFmu, describe, unpack
from fmus.runtime.instance import Instance
from fmus.runtime.messages import MAX_MESSAGES, Messages
from fmus.runtime.ports import Port
from friction_models.common import InputError
from orchestrator import SimulationError
from tests.orchestrator.native_fmus import Real, native_fmu

VARIABLES = [Real("u", "input", 2.0), Real("mode", "parameter", 0.0), Real("y", "output")]
#: Mode 1 complains with a format, mode 2 talks on and on.
STEP = """
    if (V(mode) == 1.0) { SAY("u = %g is too large by %d %%", V(u), 5); return 0; }
    if (V(mode) == 2.0) for (int k = 0; k < 3000; ++k) m->logger(m->environment, m->name, fmi2OK, "x", "still here");
"""


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory: pytest.TempPathFactory) -> UnpackedFmu:
    folder = tmp_path_factory.mktemp("instance")
    fmu = native_fmu(folder / "talker.fmu", VARIABLES, "V(y) = 10.0 * V(u) + t;", STEP)
    return unpack(describe(fmu), folder / "unpacked")


def opened(unpacked: UnpackedFmu, name: str, mode: float, log: list[str]) -> tuple[Instance, Port, Port]:
    instance = Instance(name, unpacked, log)
    instance.initialize([(unpacked.variables["mode"], mode)], 1.0)
    return instance, Port(unpacked.resolve("u")), Port(unpacked.resolve("y"))


def test_step_writes_advances_and_reads(unpacked: UnpackedFmu) -> None:
    instance, inputs, outputs = opened(unpacked, "a", 0.0, [])
    with instance:
        assert inputs.values[0] == 2.0, "a port begins at the start values"
        for k, value in enumerate((1.0, -3.0)):
            inputs.values[:] = value
            instance.step(inputs, outputs, 0.25 * k, 0.25)
            assert outputs.values[0] == 10.0 * value + 0.25 * (k + 1)
        other = Port(instance.fmu.resolve("y"))
        instance.step(inputs, other, 0.5, 0.25)
        assert other.values[0] == pytest.approx(-29.25)
        assert instance.seconds > 0.0


def test_messages_stay_with_the_instance_that_sent_them(unpacked: UnpackedFmu) -> None:
    logs: dict[str, list[str]] = {"first": [], "second": []}
    first, inputs, outputs = opened(unpacked, "first", 1.0, logs["first"])
    second, *_ = opened(unpacked, "second", 0.0, logs["second"])
    with (
        first,
        second,
        pytest.raises(
            SimulationError, match=r"'first' failed at t = 0\.5 s in a step: u = %g is too"
        ) as seen,
    ):
        first.step(inputs, outputs, 0.5, 0.1)
    assert logs["second"] == []
    # Values of placeholders do not reach Python; that is said instead of printing something else.
    assert "placeholders cannot be shown" in str(seen.value)
    assert logs["first"][0].startswith("first: error: u = %g is too large by %d %%")


def test_a_talkative_fmu_does_not_fill_the_memory(unpacked: UnpackedFmu) -> None:
    log: list[str] = []
    instance, inputs, outputs = opened(unpacked, "a", 2.0, log)
    with instance:
        instance.step(inputs, outputs, 0.0, 0.1)
    assert len(log) == MAX_MESSAGES + 1
    assert log[-1] == f"a: more than {MAX_MESSAGES} messages; the others are not kept"


def test_percent_signs_of_plain_text_are_no_placeholders() -> None:
    log: list[str] = []
    Messages("a", log).receive(1, b"50 % done, 100%")
    Messages("a", log).receive(1, b"%s %5.2f", is_format=False)
    assert log == ["a: warning: 50 % done, 100%", "a: warning: %s %5.2f"]


def test_a_binary_that_is_no_library_or_lacks_functions(unpacked: UnpackedFmu, tmp_path: Path) -> None:
    place = tmp_path / binaries(unpacked.raw)[0]
    place.parent.mkdir(parents=True)
    place.write_bytes(b"not a library")
    with pytest.raises(InputError, match=r"talker\.fmu: the binary cannot be loaded"):
        Instance("a", UnpackedFmu.of(unpacked.path, tmp_path))


def test_a_path_as_model_identifier_is_refused(tmp_path: Path) -> None:
    from fmus.archive.content import write_archive

    xml = b"""<fmiModelDescription fmiVersion="2.0" modelName="x" guid="x">
    <CoSimulation modelIdentifier="../../x"/><ModelVariables/><ModelStructure/></fmiModelDescription>"""
    fmu = write_archive(tmp_path / "x.fmu", {"modelDescription.xml": xml})
    with pytest.raises(InputError, match=r"modelIdentifier '\.\./\.\./x'"):
        describe(fmu)


def test_ports_of_mixed_types_keep_their_order() -> None:
    from fmus.runtime.fmu_variables import Variable

    mixed = [
        Variable("n", 7, "Integer", "input", "", "fmi2Integer", starts=(3.0,)),
        Variable("x", 1, "Real", "input", "", "fmi2Real", starts=(0.5,)),
        # of an FMI 3.0 array only one element is exchanged: the others go along unchanged
        Variable("v[2]", 4, "Real", "input", "", "fmi3Float64", 1, (1.0, 2.0, 3.0)),
    ]
    port = Port(mixed)
    assert port.values.tolist() == [3.0, 0.5, 2.0] and not port.is_direct
    port.values[:] = [5.0, 6.0, 7.0]
    port.to_buffers()
    assert [g.buffer.tolist() for g in port.groups] == [[5], [6.0], [1.0, 7.0, 3.0]]
    port.groups[2].buffer[:] = [8.0, 9.0, 10.0]
    port.from_buffers()
    np.testing.assert_array_equal(port.values, [5.0, 6.0, 9.0])
