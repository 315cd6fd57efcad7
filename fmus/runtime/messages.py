"""Log messages of one FMU instance."""

from __future__ import annotations

import re

from .c_interface.slave import DISCARD, WARNING

#: Messages of one instance that are kept; an FMU may log every step.
MAX_MESSAGES = 1000
MAX_LENGTH = 2000
#: How the line of a warning begins, behind the name of the instance.
WARNS = "warning: "

#: FMI 2.0 messages are formats of printf. Their values come as variadic arguments, which portable Python code
#: cannot receive; the format alone is shown, and it is said that values are missing.
_PLACEHOLDER = re.compile(r"%[-+#0]*(\d+|\*)?(\.(\d+|\*))?(hh|h|ll|l|j|z|t|L)?[diouxXeEfFgGaAcsp]")
_WITHOUT_VALUES = " (the FMU's values for the placeholders cannot be shown)"

#: PythonFMU wraps what was said into a line of its own, and the Python exception around it.
_PYTHON = re.compile(r"(?:PyObject_CallMethod\s+|^)\w+\((['\"])(?P<said>.*)\1\)$", re.MULTILINE)


class Messages:
    """The messages of the instance `name`; `log` receives the lines, the name in front, up to `MAX_MESSAGES`.

    Examples
    --------
    >>> log = []
    >>> messages = Messages("friction", log)
    >>> messages.receive(3, b"T is not finite")
    >>> messages.cause("SetReal returned 3"), log
    ('T is not finite', ['friction: error: T is not finite'])
    """

    def __init__(self, name: str, log: list[str]) -> None:
        self.name = name
        self.log = log
        self._count = 0
        self._error = ""
        self._remark = ""

    def forget(self) -> None:
        """Begin a call: what was said before is no cause of its failure."""
        self._error = self._remark = ""

    @property
    def complained(self) -> bool:
        """Whether the call logged an error."""
        return bool(self._error)

    def receive(self, status: int, message: bytes | None, is_format: bool = True) -> None:
        """Take a message that came with an FMI status (2.0 and 3.0 number them alike)."""
        text = (message or b"")[:MAX_LENGTH].decode("utf-8", "replace").strip()
        if is_format and _PLACEHOLDER.search(text):
            text += _WITHOUT_VALUES
        if status >= DISCARD:
            self._error = text
        elif text:
            self._remark = text
        if text and status == WARNING:
            text = f"{WARNS}{text}"
        self.note(text if status <= DISCARD else f"error: {text}")

    def note(self, text: str) -> None:
        """Keep a line of this instance."""
        self._count += 1
        if self._count <= MAX_MESSAGES:
            self.log.append(f"{self.name}: {text}")
        elif self._count == MAX_MESSAGES + 1:
            self.log.append(f"{self.name}: more than {MAX_MESSAGES} messages; the others are not kept")

    def cause(self, error: object) -> str:
        """Return why a call failed: the last error that the FMU logged in it, `error` and its last word without one."""
        said = self._error or " ".join(str(error).split())
        if not self._error and self._remark:
            said = f"{said}: {self._remark}"
        self.forget()
        python = _PYTHON.search(said)
        return python["said"] if python else said
