"""Damaged ONNX files given to the readers, in a process of its own: ``python -m tests.fmus.fuzz.onnx_files SEED COUNT``.

Every file must be packed or refused with an `InputError`, within a limit of time and memory; anything else is
printed and ends the process with code 1 (or, for a crash, with the signal).
"""

from __future__ import annotations

import random
import signal
import sys
import tempfile
from pathlib import Path
from unittest import mock

import onnx

from friction_models.common import InputError

from .models import memory, network
from .onnx_damage import bytes_changed, graph_changed
from .packing import packed

#: Limits for one file [s] and for the process [bytes].
SECONDS, MEMORY = 20, 6 * 1024**3


def seeds() -> dict[str, bytes]:
    """Return good files to damage: two made by hand, ours with states and trees."""
    import zipfile

    found = {"network": network(), "memory": memory()}
    with tempfile.TemporaryDirectory() as folder:
        for kind in ("ode", "boosting"):
            with zipfile.ZipFile(packed(kind, 1, "2.0", Path(folder))) as archive:
                found[kind] = archive.read("resources/model.onnx")
    plain = onnx.load_model_from_string(found["network"])
    del plain.metadata_props[:]
    found["foreign"] = plain.SerializeToString()
    return found


def read(content: bytes, folder: Path, target: str) -> bool:
    """Give a file to the readers; return whether it was packed.

    Raises
    ------
    Exception
        Anything but an `InputError` of one short sentence.
    """
    from fmus import pack
    from friction_models.models.onnx_model import OnnxModel

    path = folder / "bad.onnx"
    path.write_bytes(content)
    worked = True
    for act in (
        lambda: pack(path, folder / "out.fmu", target=target),
        lambda: OnnxModel(path),
    ):
        try:
            act()
        except InputError as error:
            worked = False
            if "\n" in str(error) or len(str(error)) > 1500:
                raise AssertionError(f"no short sentence: {str(error)[:3000]!r}") from None
    if sorted(p.name for p in folder.iterdir() if p.name not in {"bad.onnx", "out.fmu"}):
        raise AssertionError(f"files beside the FMU: {sorted(folder.iterdir())}")
    return worked


def main(seed: int, count: int) -> int:
    """Damage `count` files; return 1 when one of them is not refused as it should be."""
    if hasattr(signal, "SIGALRM"):
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        signal.signal(
            signal.SIGALRM, lambda *_: (_ for _ in ()).throw(TimeoutError(f"more than {SECONDS} s"))
        )
    good = seeds()
    accepted = failures = 0
    kinds: set[str] = set()
    with (
        tempfile.TemporaryDirectory(prefix="tribofmu-onnx-") as place,
        mock.patch("fmus.native.compile.build", return_value={}),
    ):
        for number in range(seed, seed + count):
            draw = random.Random(number)
            kind = draw.choice([*good])
            change = draw.choice([bytes_changed, graph_changed, graph_changed])
            print(f"file {number}", file=sys.stderr, flush=True)  # the last one said is the one that crashed
            content = change(draw, good[kind])
            if hasattr(signal, "SIGALRM"):
                signal.alarm(SECONDS)
            try:
                accepted += read(content, Path(place), draw.choice(["native", "native", "python"]))
            except Exception as error:
                import traceback

                failures += 1
                frames = [
                    f for f in traceback.extract_tb(error.__traceback__) if "site-packages" not in f.filename
                ]
                where = " > ".join(f"{Path(f.filename).name}:{f.lineno}" for f in frames[-4:])
                text = f"{type(error).__name__}: {' '.join(str(error).split())[:160]} ({where})"
                if text not in kinds:
                    kinds.add(text)
                    print(f"file {number}, {kind}, {change.__name__}: {text}")
            finally:
                if hasattr(signal, "SIGALRM"):
                    signal.alarm(0)
    print(f"{count} files: {accepted} packed, {failures} not refused as they should be")
    return int(failures > 0)


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]), int(sys.argv[2])))
