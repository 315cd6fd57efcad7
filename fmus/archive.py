"""FMU archives: written so that equal content gives equal bytes, read without trusting them."""

from __future__ import annotations

import hashlib
import os
import zipfile
from collections.abc import Mapping
from pathlib import Path, PurePosixPath

from lxml import etree

from friction_models.loads import InputError, atomic_path

#: Limits on what is unpacked: bytes in all, bytes of the model description, number of files.
MAX_BYTES = 1024**3
MAX_DESCRIPTION_BYTES = 64 * 1024**2
MAX_FILES = 20_000

_EARLIEST = (1980, 1, 1, 0, 0, 0)


def content_guid(files: Mapping[str, bytes]) -> str:
    """Return a GUID that is a hash of names and contents."""
    digest = hashlib.sha256()
    for name in sorted(files):
        digest.update(f"{name}\0{len(files[name])}\0".encode())
        digest.update(files[name])
    h = digest.hexdigest()
    return f"{{{h[:8]}-{h[8:12]}-{h[12:16]}-{h[16:20]}-{h[20:32]}}}"


def write_archive(path: str | os.PathLike[str], files: Mapping[str, bytes]) -> Path:
    """Write an FMU with sorted members and a fixed date; the path appears only when it is complete."""
    target = Path(path)
    with atomic_path(target) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        for name in sorted(files, key=lambda n: (n != "modelDescription.xml", n)):
            member = zipfile.ZipInfo(name, _EARLIEST)
            member.compress_type = zipfile.ZIP_DEFLATED
            member.create_system = 3
            member.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            archive.writestr(member, files[name], compresslevel=9)
    return target


def read_archive(path: str | os.PathLike[str]) -> dict[str, zipfile.ZipInfo]:
    """Check an FMU archive from outside, before anything of it is unpacked or loaded.

    Returns
    -------
    dict of str to ZipInfo
        The files in it.

    Raises
    ------
    InputError
        No such file, not a ZIP archive, damaged, too large when unpacked, a member that would be
        written outside the folder, or no model description.
    """
    file = Path(path)
    if not file.is_file():
        raise InputError(f"{file}: no such FMU")
    try:
        with zipfile.ZipFile(file) as archive:
            members = archive.infolist()
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError) as error:
        raise InputError(f"{file}: not an FMU: not a readable ZIP archive ({error})") from None
    if len(members) > MAX_FILES:
        raise InputError(f"{file}: {len(members)} files in the archive, allowed: at most {MAX_FILES}")
    total = sum(m.file_size for m in members)
    if total > MAX_BYTES:
        raise InputError(f"{file}: unpacks to {total} bytes, allowed: at most {MAX_BYTES}")
    for member in members:
        name = member.orig_filename
        parts = PurePosixPath(name).parts
        if "\\" in name or ":" in name or "\0" in name or name.startswith("/") or ".." in parts:
            raise InputError(
                f"{file}: member {name!r} points outside the archive, allowed: plain relative paths"
            )
        if member.flag_bits & 0x1:
            raise InputError(f"{file}: member {name!r} is encrypted, allowed: plain files")
    found = {m.filename: m for m in members if not m.is_dir()}
    if len(found) != len([m for m in members if not m.is_dir()]):
        raise InputError(f"{file}: a member stands twice in the archive, allowed: once")
    if "modelDescription.xml" not in found:
        raise InputError(f"{file}: not an FMU: there is no modelDescription.xml in the archive")
    if found["modelDescription.xml"].file_size > MAX_DESCRIPTION_BYTES:
        raise InputError(f"{file}: modelDescription.xml is larger than {MAX_DESCRIPTION_BYTES} bytes")
    return found


def read_member(path: str | os.PathLike[str], name: str) -> bytes:
    """Return the content of one file of an archive that `read_archive` has accepted."""
    try:
        with zipfile.ZipFile(path) as archive:
            return archive.read(name)
    except (zipfile.BadZipFile, OSError, ValueError, EOFError, NotImplementedError) as error:
        raise InputError(f"{path}: member {name!r} is damaged ({error})") from None
    except Exception as error:  # zlib.error, lzma and others are not one family
        raise InputError(f"{path}: member {name!r} cannot be unpacked ({error})") from None


def read_description(path: str | os.PathLike[str]) -> etree._Element:
    """Return the root of modelDescription.xml, parsed without entities, DTD and network.

    Raises
    ------
    InputError
        Damaged, not XML, with a document type, or not a model description.
    """
    read_archive(path)
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False)
    try:
        root = etree.fromstring(read_member(path, "modelDescription.xml"), parser)
    except etree.XMLSyntaxError as error:
        raise InputError(f"{path}: modelDescription.xml is not readable XML ({error.msg})") from None
    if root.getroottree().docinfo.doctype:
        raise InputError(f"{path}: modelDescription.xml declares a document type, allowed: none")
    if root.tag != "fmiModelDescription":
        raise InputError(f"{path}: modelDescription.xml holds {root.tag!r}, allowed: 'fmiModelDescription'")
    return root


def unpack(path: str | os.PathLike[str], folder: str | os.PathLike[str]) -> Path:
    """Unpack a checked FMU into `folder`.

    Raises
    ------
    InputError
        Anything that `read_description` refuses, or a damaged member.
    """
    read_description(path)
    target = Path(folder)
    try:
        with zipfile.ZipFile(path) as archive:
            archive.extractall(target)
    except Exception as error:  # BadZipFile, zlib.error, OSError: the archive is damaged, or the disk full
        raise InputError(f"{path}: the archive cannot be unpacked ({error})") from None
    return target
