"""A loaded binary and its one instance: what FMI 2.0 and 3.0 have in common.

Functions are bound once and called without declared argument types: ctypes then passes the objects it is
given as they are, which costs half of what conversion does. Every argument is therefore a ctypes object.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from ctypes import CDLL, byref, c_bool, c_char_p, c_double, c_size_t, c_uint, c_uint8, c_void_p
from pathlib import Path
from typing import Any, ClassVar

from friction_models.common import InputError

_STATUS = ("ok", "warning", "discard", "error", "fatal", "pending")
#: Calls that return more than this failed.
WARNING = 1
DISCARD = 2
FATAL = 4

Receiver = Callable[[int, bytes | None], None]


def binaries(raw: Any) -> list[str]:
    """Return where the binary for this machine may lie in the archive, likeliest first."""
    from fmpy import platform, platform_tuple, sharedLibraryExtension

    # FMI 2.0.4 names other processors as FMI 3.0 does; older FMUs put them into the folder of the system.
    x86 = platform_tuple.startswith("x86")
    folders = [platform, platform_tuple] if x86 else [platform_tuple, platform]
    if raw.fmiVersion != "2.0":
        folders = [platform_tuple]
    name = (raw.coSimulation or raw.modelExchange).modelIdentifier + sharedLibraryExtension
    return [f"binaries/{folder}/{name}" for folder in folders]


def library_in(unpacked: Path, raw: Any) -> Path:
    """Return the path of the library for this machine in an unpacked FMU; it may not exist."""
    found = [unpacked / place for place in binaries(raw)]
    return next((place for place in found if place.is_file()), found[0])


class CallFailed(RuntimeError):
    """A call returned a status that is neither ok nor warning."""


class Slave:
    """A loaded binary and one instance of it; `Fmi2Slave` and `Fmi3Slave` say how its functions are called.

    Attributes
    ----------
    raw : object
        fmpy's model description.
    now, size : ctypes.c_double
        Start and length of the next step [s]; `advance` passes them on.
    wants_to_end, early : ctypes.c_bool
        Set by a step after which the FMU asks to end the simulation, and by one that did not come to its end (FMI 3.0).
    reached : ctypes.c_double
        Time that such a step reached [s].

    Raises
    ------
    InputError
        The binary cannot be loaded or lacks a function.
    """

    prefix: ClassVar[str]

    def __init__(self, archive: Path, raw: Any, unpacked: Path) -> None:
        self.archive = archive
        self.raw = raw
        self.unpacked = unpacked
        self.now, self.size = c_double(0.0), c_double(0.0)
        self.wants_to_end, self.early = c_bool(False), c_bool(False)
        self.reached = c_double(0.0)
        self.fatal = False
        self._component: c_void_p | None = None
        self._functions: dict[str, Any] = {}
        self._keep: Any = None
        try:
            self._library: Any = CDLL(str(library_in(unpacked, raw)))
        except OSError as error:
            reason = " ".join(str(error).split())
            raise InputError(f"{archive}: the binary cannot be loaded ({reason})") from None

    def function(self, name: str) -> Any:
        """Return a function of the binary; `name` without the prefix ``fmi2`` or ``fmi3``."""
        if name not in self._functions:
            try:
                # By item, not attribute: a function object of our own, whose argument types nobody declares.
                self._functions[name] = self._library[self.prefix + name]
            except AttributeError:
                raise InputError(
                    f"{self.archive}: the binary lacks the function {self.prefix}{name}"
                ) from None
        return self._functions[name]

    def call(self, name: str, *arguments: Any) -> None:
        """Call a function on the instance.

        Raises
        ------
        CallFailed
            The FMU refused.
        """
        self.passed(name, self.function(name)(self._component, *arguments))

    def passed(self, name: str, status: int) -> None:
        """Raise `CallFailed` for a status above warning."""
        if status > WARNING:
            self.refused(name, status)

    def refused(self, name: str, status: int) -> None:
        """Raise `CallFailed` for this status."""
        self.fatal = self.fatal or status == FATAL
        meaning = _STATUS[status] if 0 <= status < len(_STATUS) else f"status {status}"
        raise CallFailed(f"{self.prefix}{name} returned {meaning}")

    def exchange(self, group: Any, direction: str) -> tuple[Any, tuple[Any, ...]]:
        """Return function and arguments that get or set (`direction`) a `ports.Group`."""
        name = f"{direction}{group.exchange.removeprefix(self.prefix)}"
        return self.function(name), (self._component, *group.arguments)

    def advance(self, keeps_older_states: bool = False) -> tuple[Any, tuple[Any, ...]]:
        """Return function and arguments of a step from `now` by `size`.

        States saved before `now` may be restored afterwards if `keeps_older_states`.
        """
        raise NotImplementedError

    def terminated(self) -> bool:
        """Return whether a discarded step says that the FMU ends the simulation (FMI 2.0); `reached` is then set."""
        return False

    def instantiate(self, name: str, receive: Receiver) -> None:
        """Create the instance; `receive` gets status and text of its messages."""
        raise NotImplementedError

    def enter_initialization(self, stop_time: float | None = None) -> None:
        """Begin the initialization mode of a run from 0 to `stop_time` [s], None for an open end."""
        raise NotImplementedError

    def exit_initialization(self) -> None:
        """End the initialization mode."""
        self.call("ExitInitializationMode")

    def set_string(self, reference: int, value: str) -> None:
        """Set a string variable."""
        text, one = (c_char_p * 1)(value.encode()), c_size_t(1)
        # FMI 3.0 wants the number of values, too.
        self.call("SetString", byref(c_uint(reference)), one, text, *([one] if self.prefix == "fmi3" else []))

    def save_state(self) -> c_void_p:
        """Return a handle to the whole state."""
        state = c_void_p()
        self.call(self._state("Get"), byref(state))
        return state

    def restore_state(self, state: c_void_p) -> None:
        """Go back to a saved state."""
        self.call(self._state("Set"), state)

    def free_state(self, state: c_void_p) -> None:
        """Give up a saved state."""
        self.call(self._state("Free"), byref(state))

    def serialize(self, state: c_void_p) -> bytes:
        """Return a saved state as bytes."""
        size = c_size_t()
        self.call(self._state("Serialized", "Size"), state, byref(size))
        content = (c_uint8 * size.value)()
        self.call(self._state("Serialize"), state, content, size)
        return bytes(content)

    def deserialize(self, content: bytes) -> c_void_p:
        """Return a handle to the state that `serialize` wrote."""
        state = c_void_p()
        verb = "DeSerialize" if self.prefix == "fmi2" else "Deserialize"
        given = (c_uint8 * len(content)).from_buffer_copy(content)
        self.call(self._state(verb), given, c_size_t(len(content)), byref(state))
        return state

    def derivatives(
        self, name: str, unknowns: Sequence[int], knowns: Sequence[int], seed: Sequence[float], count: int
    ) -> list[float]:
        """Return what `name` (``GetDirectionalDerivative``, ``GetAdjointDerivative``) gives for a seed: `count` numbers."""
        of, by = (c_uint * len(unknowns))(*unknowns), (c_uint * len(knowns))(*knowns)
        given, found = (c_double * len(seed))(*seed), (c_double * count)()
        pairs: tuple[Any, ...] = (given, found)
        if self.prefix == "fmi3":
            pairs = (given, c_size_t(len(given)), found, c_size_t(count))
        self.call(name, of, c_size_t(len(of)), by, c_size_t(len(by)), *pairs)
        return list(found)

    def _state(self, verb: str, what: str = "") -> str:
        return f"{verb}FMU{'state' if self.prefix == 'fmi2' else 'State'}{what}"

    def free(self) -> None:
        """Free the instance and unload the library, except after a fatal error, when nothing may be called."""
        from fmpy import freeLibrary

        component, self._component = self._component, None
        if self.fatal:
            return
        if component is not None:
            self.function("FreeInstance")(component)
        self._functions.clear()
        library, self._library = self._library, None
        if library is not None:
            freeLibrary(library._handle)

    def _created(self, pointer: int | None) -> None:
        if not pointer:
            raise CallFailed("the FMU creates no instance")
        self._component = c_void_p(pointer)
