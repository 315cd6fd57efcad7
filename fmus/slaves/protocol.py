"""Messages between the native front of a solver FMU and the solver process; the other side is `front.h`.

A message is its length (unsigned, 4 bytes) and as many bytes. A request starts with a code of one byte, a
reply with a status of one byte. All numbers are little-endian, real numbers float64. An error's reply
carries a text in UTF-8.

============ ============================================= ===============================================
request      content                                       reply
============ ============================================= ===============================================
HELLO        "TFMU", version                               "TFMU", version, text: the package's version
CONFIGURE    length and name of the solver, its JSON       nothing
START        inputs and parameters                         outputs (float64), flags (one byte each)
STEP         elapsed, step, inputs                         outputs, flags
SAVE         nothing                                       number of the state (8 bytes)
RESTORE      number of a state                             nothing
FREE         number of a state                             nothing
QUIT         nothing                                       none: the process ends
SERIALIZE    number of a state, the front's own part       the state as bytes
DESERIALIZE  the state as bytes                            number of the state, the front's own part
REMARKS      nothing                                       text: a line for each warning about the run so far
============ ============================================= ===============================================

HELLO and its reply stay as they are in all versions, so that two versions can tell each other apart. A front
does without REMARKS where the solver does not know them.
"""

from __future__ import annotations

import os
import struct
from importlib.metadata import PackageNotFoundError, version

VERSION = 1
MAGIC = b"TFMU"
#: Longest message [bytes].
LONGEST = 64 * 1024**2

HELLO, CONFIGURE, START, STEP, SAVE, RESTORE, FREE, QUIT, SERIALIZE, DESERIALIZE, REMARKS = range(1, 12)
#: Statuses are those of FMI 2.0.
OK, DISCARD, ERROR = 0, 2, 3


def package_version() -> str | None:
    """Return the version of the package tribofmu, None where it is not installed as one."""
    try:
        return version("tribofmu")
    except PackageNotFoundError:
        return None


class Channel:
    """Messages over a file descriptor that is read and written."""

    def __init__(self, descriptor: int) -> None:
        self.descriptor = descriptor

    def read(self) -> bytes | None:
        """Return the next message; None when the other side has gone.

        Raises ValueError: a length that no message has.
        """
        head = self._exactly(4)
        if head is None:
            return None
        (length,) = struct.unpack("<I", head)
        if not 0 < length <= LONGEST:
            raise ValueError(f"message of {length} bytes, allowed: 1 to {LONGEST}")
        return self._exactly(length)

    def write(self, status: int, content: bytes = b"") -> None:
        """Send a reply.

        Raises OSError: the other side has gone.
        """
        rest = memoryview(struct.pack("<IB", len(content) + 1, status) + content)
        while rest:
            rest = rest[os.write(self.descriptor, rest) :]

    def _exactly(self, count: int) -> bytes | None:
        parts = []
        while count:
            try:
                part = os.read(self.descriptor, min(count, 1 << 20))
            except ConnectionError:
                return None
            if not part:
                return None
            parts.append(part)
            count -= len(part)
        return b"".join(parts)
