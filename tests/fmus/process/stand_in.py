"""A stand-in for the solver process that answers as it is told, to see what the front makes of it.

Run by a plain interpreter (no packages), with the mode in the environment variable STAND_IN. Only the framing
is shared with the real one: written out here on purpose, so that a change of the protocol shows.
"""

import os
import socket
import struct
import sys
import time

OUTPUTS = 5
mode = os.environ["STAND_IN"]
connection = socket.socket(fileno=int(sys.argv[-1].partition(":")[2]))


def read(count):
    data = b""
    while len(data) < count:
        part = connection.recv(count - len(data))
        if not part:
            sys.exit(0)
        data += part
    return data


def reply(status, content=b""):
    connection.sendall(struct.pack("<IB", len(content) + 1, status) + content)


def numbers(value):
    return struct.pack(f"<{OUTPUTS}d", *[value] * OUTPUTS)


while True:
    (length,) = struct.unpack("<I", read(4))
    code, content = read(1)[0], read(length - 1)
    if code == 1:
        version = 7 if mode == "version" else 1
        reply(0, (b"HTTP" if mode == "stranger" else b"TFMU") + struct.pack("<I", version) + b"9.9")
    elif code == 3:
        reply(0, numbers(1.0))
    elif code != 4:
        reply(0)
    elif mode == "hang":
        time.sleep(600.0)
    elif mode == "short":
        reply(0, b"123")
    elif mode == "huge":
        connection.sendall(struct.pack("<IB", 0xFFFFFFFF, 0))
    elif mode == "dies":
        sys.stderr.write("Traceback\nZeroDivisionError: 100 % wrong\n")
        sys.stderr.flush()
        connection.sendall(struct.pack("<IB", 41, 0) + b"half")
        os._exit(9)
    elif mode == "flood":
        for _ in range(40):
            os.write(1, b"x" * 65536 + b"\n")
            os.write(2, b"y" * 65536 + b"\n")
        reply(0, numbers(2.0))
