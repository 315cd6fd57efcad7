"""Hostile and damaged files: FMU archives made from a good one, and other files that commands take."""

from __future__ import annotations

import io
import stat
import struct
import zipfile
from pathlib import Path

SECRET = "the secret that must not be shown"
_DESCRIPTION = "modelDescription.xml"


def members(fmu: Path) -> dict[str, bytes]:
    """Return the files of an archive."""
    with zipfile.ZipFile(fmu) as archive:
        return {n: archive.read(n) for n in archive.namelist()}


def archive(files: dict[str, bytes], *more: tuple[zipfile.ZipInfo, bytes]) -> bytes:
    """Return a ZIP archive."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as made:
        for name, content in files.items():
            made.writestr(name, content)
        for member, content in more:
            made.writestr(member, content)
    return buffer.getvalue()


def named(name: str, mode: int = 0o644, system: int = 3) -> zipfile.ZipInfo:
    """Return a member whose name is written as it is."""
    member = zipfile.ZipInfo("x")
    member.filename = member.orig_filename = name
    member.create_system = system
    member.external_attr = mode << 16
    return member


def central(content: bytes, name: str) -> int:
    """Return where the entry of a member begins in the central directory."""
    at = content.index(b"PK\x01\x02")
    while content[at + 46 : at + 46 + len(name)] != name.encode():
        at = content.index(b"PK\x01\x02", at + 4)
    return at


def patched(content: bytes, at: int, *values: object) -> bytes:
    """Return `content` with numbers written at a place (a struct format and its values)."""
    form, *numbers = values
    changed = bytearray(content)
    struct.pack_into(str(form), changed, at, *numbers)
    return bytes(changed)


def archives(good: Path, secret: Path) -> dict[str, bytes]:
    """Return archives that are refused before anything in them is loaded."""
    files, whole = members(good), good.read_bytes()
    xml = files[_DESCRIPTION]
    entry = central(whole, _DESCRIPTION)
    found: dict[str, bytes] = {
        "empty": b"",
        "text": b"not an FMU at all\n",
        "gzip": b"\x1f\x8b\x08\x00" + bytes(60),
        "only_the_end_record": b"PK\x05\x06" + bytes(18),
        "end_record_with_nonsense": b"PK\x05\x06" + b"\xff" * 18,
        "no_description": archive({"readme.txt": b"hello"}),
        "description_is_a_folder": archive({f"{_DESCRIPTION}/x": b"hello"}),
    }
    for part in (0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.97):
        found[f"cut_at_{part}"] = whole[: int(part * len(whole))]
    for last in (1, 4, 21, 22, 30, 200):
        found[f"cut_by_{last}"] = whole[:-last]
    escapes = {
        "parent": "../escaped.txt", "deep_parent": "resources/../../escaped.txt", "absolute": "/tmp/escaped.txt",
        "backslash": "..\\escaped.txt", "drive": "C:escaped.txt", "drive_path": "C:\\escaped.txt",
        "share": "\\\\host\\escaped.txt", "nul": "resources/a\0../../escaped.txt", "dots": "..",
    }  # fmt: skip
    for name, path in escapes.items():
        found[f"escape_{name}"] = archive(files, (named(path), b"gotcha"))
        found[f"escape_{name}_dos"] = archive(files, (named(path, system=0), b"gotcha"))
    link = named("resources/link", stat.S_IFLNK | 0o777)
    found["symbolic_link"] = archive(
        files, (link, str(secret.parent).encode()), (named("resources/link/escaped.txt"), b"gotcha")
    )
    found["device"] = archive(files, (named("resources/device", stat.S_IFCHR | 0o666), b""))
    found["twice"] = archive(files, (named(_DESCRIPTION), xml))
    found["file_and_folder"] = archive(
        files, (named("resources/a"), b"file"), (named("resources/a/b"), b"below it")
    )
    found["long_name"] = archive(files, (named("resources/" + "a" * 5000), b""))
    found["many_levels"] = archive(files, (named("resources/" + "a/" * 3000 + "b"), b""))
    found["encrypted"] = patched(whole, entry + 8, "<H", 1)
    found["unknown_method"] = patched(whole, entry + 10, "<H", 77)
    found["bomb_by_its_own_word"] = patched(whole, entry + 24, "<I", 0xFFFFFFF0)
    found["many_files"] = archive(files | {f"resources/{k}": b"" for k in range(20_500)})
    big = archive(files | {f"resources/big{k}": b"a" for k in range(3)})
    for k in range(3):
        big = patched(big, central(big, f"resources/big{k}") + 24, "<I", 400_000_000)
    found["big_together"] = big
    zeros = archive(files | {_DESCRIPTION: bytes(30_000_000)})
    found["lying_size"] = patched(zeros, central(zeros, _DESCRIPTION) + 24, "<I", 1000)
    found["local_header_elsewhere"] = patched(whole, entry + 42, "<I", len(whole) - 100)
    found["overlap"] = patched(
        whole, central(whole, next(n for n in files if n != _DESCRIPTION)) + 42, "<I", 0
    )
    found |= {
        f"xml_{name}": archive(files | {_DESCRIPTION: content})
        for name, content in descriptions(xml, secret).items()
    }
    hidden = f'<!DOCTYPE x [<!ENTITY e SYSTEM "{secret.as_uri()}">]><x>&e;</x>'.encode()
    found["entity_in_terminals"] = archive(
        files | {"terminalsAndIcons/terminalsAndIcons.xml": hidden, "sources/buildDescription.xml": hidden}
    )
    return found


def descriptions(xml: bytes, secret: Path) -> dict[str, bytes]:
    """Return model descriptions that are no model descriptions, or ask for what they must not get."""
    head, start = xml[: xml.index(b"<fmiModelDescription")], xml[xml.index(b"<fmiModelDescription") :]

    def declared(entities: str, use: bytes) -> bytes:
        text = start.replace(b'description="', b'description="' + use, 1)
        return head + f"<!DOCTYPE fmiModelDescription [{entities}]>".encode() + text

    laughs = '<!ENTITY a0 "ha">' + "".join(
        f'<!ENTITY a{k + 1} "{f"&a{k};" * 10}">' for k in range(30)
    )  # 10 to the power of 30
    text = start.replace(b"<ModelVariables>", b"<ModelVariables>&e;", 1)
    external = f'<!DOCTYPE fmiModelDescription [<!ENTITY e SYSTEM "{secret.as_uri()}">]>'.encode()
    outside = f'<!DOCTYPE fmiModelDescription SYSTEM "{secret.as_uri()}">'.encode()
    identifier = xml[xml.index(b'modelIdentifier="') + 17 :].partition(b'"')[0]
    token = b'modelIdentifier="' + identifier + b'"'
    found = {
        "empty": b"",
        "cut": xml[: len(xml) // 2],
        "other": b"<svg/>",
        "text": b"fmiModelDescription",
        "not_utf8": xml.replace(b'description="', b'description="\xff\xfe\x80', 1),
        "nul": xml.replace(b'description="', b'description="\0', 1),
        "wrong_encoding": b'<?xml version="1.0" encoding="no-such-thing"?>' + start,
        "laughs": declared(laughs, b"&a30;"),
        "external": head + external + text,
        "external_in_attribute": declared(f'<!ENTITY e SYSTEM "{secret.as_uri()}">', b"&e;"),
        "parameter_entity": declared(f'<!ENTITY % e SYSTEM "{secret.as_uri()}"> %e;', b""),
        "outside_type": head + outside + start,
        "utf16_laughs": declared(laughs, b"&a30;").replace(b"UTF-8", b"UTF-16").decode().encode("utf-16"),
        "huge_attribute": xml.replace(b'description="', b'description="' + b"a" * 20_000_000, 1),
        "deep": head + b"<fmiModelDescription>" + b"<a>" * 100_000,
        "no_content": b'<fmiModelDescription fmiVersion="2.0"/>',
        "version_9": xml.replace(b'fmiVersion="2.0"', b'fmiVersion="9.0"'),
        "no_version": xml.replace(b'fmiVersion="2.0"', b""),
        "reference_is_text": xml.replace(b'valueReference="0"', b'valueReference="zero"'),
        "reference_is_huge": xml.replace(b'valueReference="0"', b'valueReference="99999999999999999999"'),
        "start_is_text": xml.replace(b' start="', b' start="five', 1),
        "start_is_nan": xml.replace(b' start="', b' start="NaN" nominal="', 1),
        "no_variables": xml[: xml.index(b"<ModelVariables>")]
        + b"<ModelVariables/>"
        + xml[xml.index(b"</ModelVariables>") + 17 :],
        "million_variables": xml.replace(
            b"<ModelVariables>", b"<ModelVariables>" + b'<ScalarVariable name="a"/>' * 1_000_000
        ),
    }
    for name, wrong in {
        "path": "../../x", "absolute": secret.with_suffix("").as_posix(), "empty": "", "backslash": "..\\x",
        "nul": "a&#10;b", "long": "a" * 5000,
    }.items():  # fmt: skip
        found[f"identifier_{name}"] = xml.replace(token, b'modelIdentifier="' + wrong.encode() + b'"')
    return found


def texts(secret: Path) -> dict[str, bytes]:
    """Return contents for YAML, CSV, JSON and ONNX files."""
    return {
        "empty": b"",
        "blank": b"\n\n   \n",
        "nul": bytes(1000),
        "not_utf8": b"\xff\xfe\x80\x81name: x\n",
        "list": b"- 1\n- 2\n",
        "number": b"7\n",
        "unclosed": b'{"a": [1, 2\n',
        "tabs": b"\tname: [\n",
        "aliases": b"a: &a [x,x,x,x,x,x,x,x,x]\n"
        + b"".join(
            f"{chr(98 + k)}: &{chr(98 + k)} [{','.join([f'*{chr(97 + k)}'] * 9)}]\n".encode()
            for k in range(12)
        ),
        "python_object": b"name: !!python/object/apply:os.system ['touch escaped.txt']\n",
        "deep": b"[" * 20_000,
        "deep_mapping": b"".join(b" " * k + b"a:\n" for k in range(2000)),
        "long_line": b"a" * 300_000,
        "pickle": b"\x80\x04cos\nsystem\n(S'touch escaped.txt'\ntR.",
        "quotes": b'a,"b\nc,d\n' * 3,
        "archive": archive({"../escaped.txt": b"gotcha"}),
        "html": b"<!DOCTYPE x [<!ENTITY e SYSTEM '" + secret.as_uri().encode() + b"'>]><x>&e;</x>",
    }
