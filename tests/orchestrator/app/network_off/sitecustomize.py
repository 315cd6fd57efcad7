"""Python finds this file first where its folder is in ``PYTHONPATH``: whatever leaves this machine fails as with the network off, and is noted.

The note goes into the file that the environment variable ``TRIBOFMU_TRIED`` names.
"""

import os
import sys


def _watch(event: str, arguments: tuple[object, ...]) -> None:
    if event == "socket.getaddrinfo":
        host = arguments[0]
    elif event in {"socket.connect", "socket.sendto"} and isinstance(arguments[1], tuple):
        host = arguments[1][0]
    else:
        return
    name = host.decode() if isinstance(host, bytes) else str(host or "localhost")
    if name in {"localhost", "::1", "0.0.0.0", "::"} or name.startswith("127."):
        return
    with open(os.environ["TRIBOFMU_TRIED"], "a", encoding="utf-8") as tried:
        tried.write(f"{event} {name}\n")
    raise OSError(f"the network is off: {name}")


sys.addaudithook(_watch)
