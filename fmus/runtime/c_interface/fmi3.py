"""The functions of an FMI 3.0 co-simulation FMU."""

from __future__ import annotations

import os
from ctypes import CFUNCTYPE, byref, c_bool, c_char_p, c_double, c_int, c_size_t, c_void_p
from typing import Any

from .slave import Receiver, Slave

_LOGGER3 = CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)


class Fmi3Slave(Slave):
    """FMI 3.0 for co-simulation, without event mode and early return."""

    prefix = "fmi3"

    def instantiate(self, name: str, receive: Receiver) -> None:
        def logger(_environment: Any, status: int, _category: bytes, message: bytes | None) -> None:
            receive(status, message)

        self._keep = _LOGGER3(logger)
        resources = self.unpacked.resolve() / "resources"
        create = self.function("InstantiateCoSimulation")
        create.restype = c_void_p
        no, yes, nothing = c_bool(False), c_bool(True), c_void_p(None)
        self._created(
            create(
                c_char_p(name.encode()),
                c_char_p(self.raw.guid.encode()),
                c_char_p((str(resources) + os.sep).encode() if resources.is_dir() else None),
                no,
                yes,
                no,
                no,
                nothing,
                c_size_t(0),
                nothing,
                self._keep,
                nothing,
            )
        )

    def enter_initialization(self, stop_time: float | None = None) -> None:
        self.call(
            "EnterInitializationMode",
            c_bool(False),
            c_double(0.0),
            c_double(0.0),
            c_bool(stop_time is not None),
            c_double(stop_time or 0.0),
        )

    def advance(self, keeps_older_states: bool = False) -> tuple[Any, tuple[Any, ...]]:
        events = c_bool(False)
        keeps_no_older_state = c_bool(not keeps_older_states)
        return self.function("DoStep"), (
            self._component,
            self.now,
            self.size,
            keeps_no_older_state,
            byref(events),
            byref(self.wants_to_end),
            byref(self.early),
            byref(self.reached),
        )
