"""Ways to damage what holds other files: FMU and SSP archives, folders; and ONNX, netCDF, NumPy and Parquet files."""

from __future__ import annotations

import io
import random
import re
import shutil
import warnings
import zipfile
from pathlib import Path

from tests.acceptance.hostile import archive, named
from tests.fmus.fuzz.onnx_damage import graph_changed

from .text_damage import BYTES, Damage, document, encoding, nested, table

ATTRIBUTES = (
    *(
        "",
        "x",
        "0",
        "-1",
        "1e308",
        "NaN",
        "INF",
        "99999999999999999999",
        "../../x",
        "/etc/passwd",
        "true",
        "2.0",
        "3.0",
    ),
    *(
        "4.0",
        "input",
        "output",
        "parameter",
        "independent",
        "calculated",
        "discrete",
        "constant",
        "a" * 10_000,
        "v_rel",
        "mu",
    ),
)


def members(draw: random.Random, content: bytes) -> bytes:
    """Remove, damage, double, rename or add a member of an archive."""
    with zipfile.ZipFile(io.BytesIO(content)) as opened:
        files = {n: opened.read(n) for n in opened.namelist()}
    name = draw.choice(list(files))
    match draw.randrange(6):
        case 0:
            del files[name]
        case 1 | 2:
            files[name] = by_suffix(draw, name, files[name])
        case 3:
            files[draw.choice((name.upper(), f"x/{name}", name + "x"))] = files.pop(name)
        case 4:
            more = draw.choice(
                (
                    "../escaped.txt",
                    "/escaped.txt",
                    "..\\escaped.txt",
                    "a/../../escaped.txt",
                    name,
                    name + "/x",
                )
            )
            with warnings.catch_warnings(action="ignore"):  # the same name twice, deliberately
                return archive(files, (named(more), b"gotcha"))
        case _:
            xml = next(
                (n for n in files if n.endswith((".ssd", "modelDescription.xml")) and "/" not in n), name
            )
            files[xml] = xml_changed(draw, files[xml])
    return archive(files)


def xml_changed(draw: random.Random, content: bytes) -> bytes:
    """Change attributes and elements of an XML text."""
    text = content.decode("utf-8", "replace")
    for _ in range(draw.choice((1, 1, 2, 5))):
        found = list(re.finditer(r'(\w+)="([^"]*)"', text))
        elements = list(re.finditer(r"<(\w+)[^<>]*/>", text))
        match draw.randrange(5):
            case 0 | 1 | 2 if found:
                at = draw.choice(found)
                text = text[: at.start(2)] + draw.choice(ATTRIBUTES) + text[at.end(2) :]
            case 3 if found:
                at = draw.choice(found)
                text = text[: at.start()] + text[at.end() :]
            case _ if elements:
                at = draw.choice(elements)
                text = text[: at.start()] + draw.choice(("", at[0] * 2, f"<{at[1]}>")) + text[at.end() :]
    return text.encode("utf-8", "replace")


def by_suffix(draw: random.Random, name: str, content: bytes) -> bytes:
    """Damage a file in a way that its kind of content invites."""
    return damaged(draw, name, content)[0]


def damaged(draw: random.Random, name: str, content: bytes) -> tuple[bytes, str]:
    """Damage a file; return what it holds then, and the name of the damage."""
    suffix = Path(name).suffix.lower()
    damages: list[Damage] = [*BYTES]
    if suffix in {".fmu", ".ssp", ".npz"}:
        damages += [members] * 10
    elif suffix == ".csv":
        damages += [table] * 12 + [encoding] * 2
    elif suffix in {".yaml", ".json"}:
        damages += [document] * 12 + [encoding, nested, nested]
    elif suffix in {".xml", ".ssd"}:
        damages += [xml_changed] * 8
    elif suffix == ".onnx":
        damages += [graph_changed] * 8
    damage = draw.choice(damages)
    return damage(draw, content), damage.__name__


def folder(draw: random.Random, place: Path, secret: Path) -> str:
    """Damage a folder in place; return what was done."""
    files = sorted(p for p in place.rglob("*") if p.is_file())
    file = draw.choice(files)
    name = file.relative_to(place).as_posix()
    match draw.randrange(12):
        case 0:
            file.unlink()
            return f"without {name}"
        case 1:
            file.unlink()
            file.mkdir()
            return f"{name} is a folder"
        case 2:
            file.unlink()
            file.symlink_to(draw.choice((secret, place / "nowhere", file)))
            return f"{name} is a link to {file.readlink().name}"
        case 3:
            shutil.rmtree(place)
            place.mkdir()
            return "empty"
        case 4:
            other = draw.choice(files)
            file.write_bytes(other.read_bytes())
            return f"{name} holds {other.name}"
        case 5:
            (
                place
                / draw.choice(("extra.csv", "x" * 200, "notes.txt", ".hidden", "points.csv", "levels.csv"))
            ).write_bytes(b"1\n")
            return "one file more"
    content, what = damaged(draw, name, file.read_bytes())
    file.write_bytes(content)
    return f"{name} damaged: {what}"
