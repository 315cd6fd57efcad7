"""FMU archives: written so that equal content gives equal bytes, read without trusting them."""

from __future__ import annotations

import errno
import hashlib
import os
import re
import shutil
import stat
import unicodedata
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path, PurePosixPath

from lxml import etree

from friction_models.common import InputError, atomic_path

#: Limits on what is unpacked: bytes in all, bytes of an XML file, number of files, bytes of a path.
MAX_BYTES = 1024**3
MAX_DESCRIPTION_BYTES = 64 * 1024**2
MAX_FILES = 20_000
MAX_NAME = 240
#: Most elements of an XML file.
MAX_ELEMENTS = 1_000_000
_EARLIEST = (1980, 1, 1, 0, 0, 0)
#: Largest table of contents: MAX_FILES entries with paths of MAX_NAME bytes and some extra fields.
_MAX_TABLE = MAX_FILES * (46 + MAX_NAME + 100)
_RESERVED = re.compile(r"(con|prn|aux|nul|com[0-9]|lpt[0-9])(\..*)?", re.IGNORECASE)
_FORBIDDEN = re.compile(r'[\x00-\x1f\x7f<>:"|?*\\]')
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)


def content_guid(files: Mapping[str, bytes]) -> str:
    """Return a GUID that is a hash of names and contents.

    Examples
    --------
    >>> content_guid({"a.txt": b"mu"}) == content_guid({"a.txt": b"mu"}) != content_guid({"b.txt": b"mu"})
    True
    >>> content_guid({})
    '{e3b0c442-98fc-1c14-9afb-f4c8996fb924}'
    """
    digest = hashlib.sha256()
    for name in sorted(files):
        digest.update(f"{name}\0{len(files[name])}\0".encode())
        digest.update(files[name])
    h = digest.hexdigest()
    return f"{{{h[:8]}-{h[8:12]}-{h[12:16]}-{h[16:20]}-{h[20:32]}}}"


def write_archive(path: str | os.PathLike[str], files: Mapping[str, bytes]) -> Path:
    """Write an FMU with sorted members and a fixed date; the path appears only when it is complete.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> files = {"modelDescription.xml": b"<fmiModelDescription/>", "documentation/index.html": b"A law."}
    >>> with TemporaryDirectory() as place:
    ...     first = write_archive(Path(place) / "first.fmu", files).read_bytes()
    ...     second = write_archive(Path(place) / "second.fmu", files).read_bytes()
    >>> first == second
    True
    """
    target = Path(path)
    with atomic_path(target) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        for name in sorted(files, key=lambda n: (n != "modelDescription.xml", n)):
            member = zipfile.ZipInfo(name, _EARLIEST)
            member.compress_type = zipfile.ZIP_DEFLATED
            member.create_system = 3
            member.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            archive.writestr(member, files[name], compresslevel=9)
    return target


def read_members(path: str | os.PathLike[str]) -> dict[str, zipfile.ZipInfo]:
    """Check a ZIP archive from outside, before anything of it is unpacked; return the files in it.

    Raises InputError: no such file, not a ZIP archive, damaged, too large when unpacked, or a member that would be written
    outside the folder, is no plain file, or cannot exist beside the others everywhere.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     archive = write_archive(Path(place) / "any.zip", {"a.txt": b"mu", "b/c.txt": b""})
    ...     {name: member.file_size for name, member in read_members(archive).items()}
    {'a.txt': 2, 'b/c.txt': 0}
    """
    file = Path(path)
    if not file.is_file():
        what = "is a folder; allowed: an FMU file" if file.is_dir() else "no such FMU"
        raise InputError(f"{file}: {what}")
    with _readable(f"{file}: not an FMU: not a readable ZIP archive"):
        _check_table(file)
        with zipfile.ZipFile(file) as archive:
            members = archive.infolist()
    if len(members) > MAX_FILES:
        raise InputError(f"{file}: {len(members)} files in the archive, allowed: at most {MAX_FILES}")
    total = sum(m.file_size for m in members)
    if total > MAX_BYTES:
        raise InputError(f"{file}: unpacks to {total} bytes, allowed: at most {MAX_BYTES}")
    end = 0
    for member in sorted(members, key=lambda m: m.header_offset):
        if member.header_offset < end:
            raise InputError(
                f"{file}: member {member.filename[:60]!r} lies in another one, allowed: one after the other"
            )
        end = member.header_offset + 30 + len(member.orig_filename) + member.compress_size
    found: dict[str, zipfile.ZipInfo] = {}
    taken: set[str] = set()
    for member in members:
        _check_member(file, member)
        name = member.filename
        if member.is_dir():
            continue
        plain = _plain(name)
        if plain in taken:
            raise InputError(
                f"{file}: member {name!r} stands twice in the archive (maybe in other letters), allowed: once"
            )
        taken.add(plain)
        found[name] = member
    for name in found:
        for parent in PurePosixPath(name).parents:
            if _plain(str(parent)) in taken:
                raise InputError(
                    f"{file}: member {str(parent)!r} is a file and a folder, allowed: one of them"
                )
    return found


def read_archive(path: str | os.PathLike[str]) -> dict[str, zipfile.ZipInfo]:
    """Check an FMU archive from outside, before anything of it is unpacked or loaded; return the files in it.

    Raises InputError: what `read_members` refuses, or no model description.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     read_archive(write_archive(Path(place) / "no.fmu", {"../outside.txt": b""}))
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: ...
    """
    file = Path(path)
    found = read_members(file)
    if "modelDescription.xml" not in found:
        raise InputError(f"{file}: not an FMU: there is no modelDescription.xml in the archive")
    return found


def read_member(path: str | os.PathLike[str], name: str, limit: int = MAX_BYTES) -> bytes:
    """Return the content of one file of an archive that `read_members` has accepted.

    Raises InputError: damaged, missing, or larger than `limit` bytes.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     archive = write_archive(Path(place) / "any.zip", {"a.txt": b"mu"})
    ...     read_member(archive, "a.txt")
    b'mu'
    """
    with (
        _readable(f"{path}: member {name!r} is damaged and cannot be unpacked"),
        zipfile.ZipFile(path) as archive,
    ):
        size = archive.getinfo(name).file_size
        if size > limit:
            raise InputError(f"{path}: {name} is larger than {limit} bytes")
        return archive.read(name)


def parse_xml(content: bytes, where: str) -> etree._Element:
    """Return the root of an XML file, parsed without entities, document type, network and huge trees.

    `where` names archive and file in messages.
    Raises InputError: not XML, with a document type, or too large.

    Examples
    --------
    >>> parse_xml(b"<law><mu>0.1</mu></law>", "law.xml").findtext("mu")
    '0.1'
    >>> parse_xml(b"<law><mu>0.1</law>", "law.xml")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: law.xml is not readable XML ...
    """
    if len(content) > MAX_DESCRIPTION_BYTES:
        raise InputError(f"{where} is larger than {MAX_DESCRIPTION_BYTES} bytes")
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, dtd_validation=False, huge_tree=False
    )
    try:
        root = etree.fromstring(content, parser)
    except (etree.XMLSyntaxError, ValueError) as error:
        raise InputError(f"{where} is not readable XML ({_first(error)})") from None
    if root is None:
        raise InputError(f"{where} is not readable XML (it is empty)")
    if root.getroottree().docinfo.doctype or root.getroottree().docinfo.internalDTD is not None:
        raise InputError(f"{where} declares a document type, allowed: none")
    if sum(1 for _ in root.iter()) > MAX_ELEMENTS:
        raise InputError(f"{where} has more than {MAX_ELEMENTS} elements")
    return root


def xml_bytes(root: etree._Element) -> bytes:
    """Return an XML file, indented and without a date: equal trees give equal bytes."""
    return bytes(etree.tostring(root, pretty_print=True, xml_declaration=True, encoding="UTF-8"))


def read_description(path: str | os.PathLike[str]) -> etree._Element:
    """Return the root of modelDescription.xml; every XML file that importers parse is looked at.

    Raises InputError: damaged, not XML, with a document type, or not a model description.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     text = b'<fmiModelDescription fmiVersion="2.0" modelName="law"/>'
    ...     archive = write_archive(Path(place) / "law.fmu", {"modelDescription.xml": text})
    ...     read_description(archive).get("modelName")
    'law'
    """
    # Importers parse the XML files outside of these two folders: all of them must be harmless.
    names = [
        n
        for n in read_archive(path)
        if n.endswith(".xml") and not n.startswith(("resources/", "documentation/"))
    ]
    roots = {n: parse_xml(read_member(path, n, MAX_DESCRIPTION_BYTES), f"{path}: {n}") for n in names}
    root = roots["modelDescription.xml"]
    if root.tag != "fmiModelDescription":
        raise InputError(
            f"{path}: modelDescription.xml holds {str(root.tag)[:60]!r}, allowed: 'fmiModelDescription'"
        )
    return root


def unpack_members(path: str | os.PathLike[str], folder: str | os.PathLike[str]) -> Path:
    """Unpack a checked ZIP archive into `folder`: plain files and folders, never more than they declare.

    Raises InputError: anything that `read_members` refuses, or a damaged member.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     archive = write_archive(Path(place) / "any.zip", {"a.txt": b"mu", "b/c.txt": b"nu"})
    ...     folder = unpack_members(archive, Path(place) / "out")
    ...     sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*.txt"))
    ['a.txt', 'b/c.txt']
    """
    members = read_members(path)
    target = Path(folder)
    with _readable(f"{path}: the archive cannot be unpacked", target), zipfile.ZipFile(path) as archive:
        for name, member in members.items():
            place = target.joinpath(*PurePosixPath(name).parts)
            place.parent.mkdir(parents=True, exist_ok=True)
            # zipfile stops at the declared size, the sum of which is bounded, and compares checksums.
            with archive.open(member) as source, place.open("xb") as written:
                shutil.copyfileobj(source, written, 1024**2)
    return target


def check_content(path: str | os.PathLike[str]) -> None:
    """Read every member of an archive that `read_members` has accepted; raise InputError for a wrong checksum."""
    with _readable(f"{path}: the archive cannot be unpacked"), zipfile.ZipFile(path) as archive:
        damaged = archive.testzip()
    if damaged is not None:
        raise InputError(f"{path}: member {damaged!r} is damaged and cannot be unpacked")


@contextmanager
def _readable(problem: str, folder: Path | None = None) -> Iterator[None]:
    """Let what goes wrong with an archive be an `InputError`; that there is no room left in `folder` stays an `OSError`."""
    try:
        yield
    except InputError:
        raise
    except Exception as error:  # BadZipFile, zlib.error, OSError, EOFError and others are not one family
        if isinstance(error, OSError) and error.errno == errno.ENOSPC:
            raise OSError(error.errno, error.strerror, str(folder)) from None
        raise InputError(f"{problem} ({_first(error)})") from None


def _check_table(file: Path) -> None:
    """Refuse a table of contents that would take long to read, before `zipfile` reads it."""
    with file.open("rb") as stream:
        size = stream.seek(0, os.SEEK_END)
        stream.seek(max(0, size - 65_600))
        tail = stream.read()
    at = len(tail) - 22
    if at < 0 or tail[at : at + 4] != b"PK\x05\x06" or tail[-2:] != b"\0\0":
        at = tail.rfind(b"PK\x05\x06")
    if at < 0 or at + 22 > len(tail):
        raise InputError(f"{file}: not an FMU: not a readable ZIP archive (it has no table of contents)")
    length = int.from_bytes(tail[at + 12 : at + 16], "little")
    if length > _MAX_TABLE or tail[max(0, at - 20) : at].startswith(b"PK\x06\x07"):
        raise InputError(
            f"{file}: the table of contents is larger than {_MAX_TABLE} bytes or of the 64-bit kind, allowed: "
            f"at most {MAX_FILES} files and {MAX_BYTES} bytes"
        )


def _check_member(file: Path, member: zipfile.ZipInfo) -> None:
    name = member.orig_filename
    parts = name.removesuffix("/").split("/")
    if len(name.encode("utf-8", "replace")) > MAX_NAME:
        raise InputError(f"{file}: a member's path has more than {MAX_NAME} bytes ({name[:40]!r} ...)")
    if _FORBIDDEN.search(name) or name.startswith("/") or {"", ".", ".."} & set(parts):
        raise InputError(f"{file}: member {name!r} points outside the archive, allowed: plain relative paths")
    for part in parts:
        if _RESERVED.fullmatch(part) or part[-1] in " .":
            raise InputError(f"{file}: member {name!r} cannot exist on Windows, allowed: plain names")
    if member.flag_bits & 0x1:
        raise InputError(f"{file}: member {name!r} is encrypted, allowed: plain files")
    # Other methods unpack whole blocks at once, whatever size the table of contents declares.
    if member.compress_type not in _METHODS:
        raise InputError(
            f"{file}: member {name!r} is packed with method {member.compress_type}, allowed: stored or deflate"
        )
    kind = stat.S_IFMT(member.external_attr >> 16)
    if kind not in {0, stat.S_IFREG, stat.S_IFDIR}:
        raise InputError(f"{file}: member {name!r} is a link or a device, allowed: plain files")


def _plain(name: str) -> str:
    """Return the name as file systems without capital letters see it."""
    return unicodedata.normalize("NFC", name).casefold()


def _first(error: BaseException) -> str:
    return " ".join(str(error).split())[:200] or type(error).__name__
