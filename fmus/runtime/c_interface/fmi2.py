"""The functions of an FMI 2.0 co-simulation FMU."""

from __future__ import annotations

from ctypes import CFUNCTYPE, Structure, byref, c_char_p, c_double, c_int, c_void_p, cast
from typing import Any

from friction_models.common import InputError

from .slave import WARNING, Receiver, Slave

#: What can be asked after a discarded step: the time that it reached, and whether the FMU ends the simulation.
_LAST_TIME, _TERMINATED = 2, 3

_LOGGER2 = CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)


class _Callbacks2(Structure):
    _fields_ = (
        ("logger", _LOGGER2),
        ("allocate", c_void_p),
        ("free", c_void_p),
        ("step_finished", c_void_p),
        ("environment", c_void_p),
    )


class Fmi2Slave(Slave):
    """FMI 2.0 for co-simulation."""

    prefix = "fmi2"

    def instantiate(self, name: str, receive: Receiver) -> None:
        from fmpy import calloc, free

        # A receiver of its own for each instance. fmpy's proxy, which fills in the placeholders of formats,
        # has one receiver a process: messages of every instance would arrive at the one created last.
        def logger(
            _environment: Any, _name: bytes, status: int, _category: bytes, message: bytes | None
        ) -> None:
            receive(status, message)

        keep = _Callbacks2(_LOGGER2(logger), cast(calloc, c_void_p), cast(free, c_void_p), None, None)
        self._keep = keep
        create = self.function("Instantiate")
        create.restype = c_void_p
        co_simulation, visible, logging = c_int(1), c_int(0), c_int(1)
        self._created(
            create(
                c_char_p(name.encode()),
                co_simulation,
                c_char_p(self.raw.guid.encode()),
                c_char_p((self.unpacked.resolve() / "resources").as_uri().encode()),
                byref(keep),
                visible,
                logging,
            )
        )

    def enter_initialization(self, stop_time: float | None = None) -> None:
        end = c_int(stop_time is not None), c_double(stop_time or 0.0)
        self.call("SetupExperiment", c_int(0), c_double(0.0), c_double(0.0), *end)
        self.call("EnterInitializationMode")

    def advance(self, keeps_older_states: bool = False) -> tuple[Any, tuple[Any, ...]]:
        keeps_no_older_state = c_int(not keeps_older_states)
        return self.function("DoStep"), (self._component, self.now, self.size, keeps_no_older_state)

    def terminated(self) -> bool:
        # PythonFMU gives this answer whenever `do_step` returns False, whatever the reason.
        if "pythonfmu" in str(self.raw.generationTool).lower():
            return False
        ended, kinds = c_int(0), (c_int(_TERMINATED), c_int(_LAST_TIME))
        try:
            status = self.function("GetBooleanStatus")(self._component, kinds[0], byref(ended))
            if status > WARNING or not ended.value:
                return False
            if self.function("GetRealStatus")(self._component, kinds[1], byref(self.reached)) > WARNING:
                self.reached.value = self.now.value
        except InputError:  # a binary without these functions
            return False
        return True
