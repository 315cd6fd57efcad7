"""Where a friction model comes from, as metadata inside its FMU after the SSP Traceability specification.

Version 1.0-rc.2, a release candidate: a Simulation Resource Meta Data file (SRMD) at the place that the specification names for FMUs.
It says what the model card says: data and their digest, which tests were held out, errors, domain, versions, author. The same model gives the
same bytes: the time is that of the variable ``SOURCE_DATE_EPOCH`` and is left out without it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Mapping

from lxml import etree

from friction_models.common.build_time import build_time

from ..archive.content import xml_bytes
from ..interface.friction_source import FrictionSource

PATH = "extra/org.ssp-standard.ssp-traceability.srmd/resourceMetaData.srmd"
#: Version of the format that the file declares.
VERSION = "1.0.0-rc.2"
SRMD = "http://ssp-standard.org/SSPTraceability1/SimulationResourceMetaData"
STC = "http://ssp-standard.org/SSPTraceability1/SSPTraceabilityCommon"
#: Whose words the keywords are.
KIND = "org.tribofmu.friction-model"
_ERRORS = ("rmse", "mae", "bias", "tests", "points")


def traceability_files(source: FrictionSource) -> dict[str, bytes]:
    """Return the metadata by their path in the archive; empty for a model without a card.

    Raises InputError: ``SOURCE_DATE_EPOCH`` is no number of seconds.

    Examples
    --------
    >>> source = FrictionSource(b"", "law.onnx", card={"data": {"points": 3, "tests": 1}})
    >>> b'keyword="data.points"' in traceability_files(source)[PATH]
    True
    """
    if not source.card:
        return {}
    head = about(source.name, str(source.card.get("author") or ""))
    root = etree.Element(f"{{{SRMD}}}SimulationResourceMetaData", head, nsmap={"srmd": SRMD, "stc": STC})
    classify(root, KIND, facts(source))
    return {PATH: xml_bytes(root)}


def about(name: str, author: str) -> dict[str, str]:
    """Return the attributes that every file of metadata begins with.

    Raises InputError: ``SOURCE_DATE_EPOCH`` is no number of seconds.

    Examples
    --------
    >>> about("law", "A. Maker")["author"]
    'A. Maker'
    """
    head = {"version": VERSION, "name": text_of(name), "generationTool": "tribofmu"}
    if author:
        head["author"] = text_of(author)
    if when := build_time():
        head["generationDateAndTime"] = when.strftime("%Y-%m-%dT%H:%M:%SZ")
    return head


def classify(parent: etree._Element, kind: str, entries: Iterable[tuple[str, str]]) -> None:
    """Write keywords and values below an element; `kind` says whose words they are."""
    group = etree.SubElement(parent, f"{{{STC}}}Classification", {"type": kind})
    for keyword, value in entries:
        etree.SubElement(group, f"{{{STC}}}ClassificationEntry", {"keyword": text_of(keyword)}).text = value


def facts(source: FrictionSource) -> Iterator[tuple[str, str]]:
    """Yield keyword and value of everything that the card of a model records, and of its domain."""
    card = source.card
    yield "model.family", source.family
    yield "model.formula", source.formula
    yield "model.onnx.sha256", hashlib.sha256(source.original or source.onnx).hexdigest()
    data, splits = _part(card, "data"), _part(card, "splits")
    for key in ("points", "tests", "synthetic"):
        if key in data:
            yield f"data.{key}", text_of(data[key])
    for key, value in _part(data, "provenance").items():
        yield f"data.provenance.{key}", text_of(value)
    if digests := _part(splits, "digests"):
        lines = "".join(f"{test} {digest}\n" for test, digest in sorted(digests.items()))
        yield "data.sha256", hashlib.sha256(lines.encode()).hexdigest()
    for key, value in splits.items():
        if key != "digests":
            yield f"split.{key}", words_of(value)
    for role, measures in _part(card, "errors").items():
        if isinstance(measures, Mapping):
            for key in _ERRORS:
                if key in measures:
                    yield f"error.{role}.{key}", text_of(measures[key])
    for key, value in _part(card, "diagnosis").items():
        yield f"diagnosis.{key}", words_of(value)
    history = card.get("refinement")
    for k, entry in enumerate(history if isinstance(history, list) else []):
        for key, value in entry.items() if isinstance(entry, Mapping) else ():
            if isinstance(value, Mapping):
                for name in _ERRORS:
                    if name in value:
                        yield f"refinement.{k + 1}.{key}.{name}", text_of(value[name])
            elif value:
                yield f"refinement.{k + 1}.{key}", words_of(value)
    made = _part(card, "map")
    for name, entry in (("of", made.get("of")), ("remaining", made.get("remaining"))):
        for key, value in entry.items() if isinstance(entry, Mapping) else ():
            yield f"map.{name}.{key.replace(' ', '_')}", text_of(value)
    for load, (lower, upper) in source.domain.items():
        yield f"domain.{load}", f"{lower:g} {upper:g}"
    for load in source.absent:
        yield f"domain.{load}", "not measured"
    for package, version in _part(card, "versions").items():
        yield f"version.{package}", text_of(version)


def _part(whole: Mapping[str, object], name: str) -> dict[str, object]:
    """Return a part of a card; cards of others may hold anything."""
    found = whole.get(name)
    return dict(found) if isinstance(found, Mapping) else {}


def text_of(value: object) -> str:
    """Return a value as text that XML can hold.

    Examples
    --------
    >>> text_of(True), text_of(0.1234567890), text_of("a\\x00b"), text_of(None)
    ('true', '0.123457', 'ab', 'not recorded')
    """
    if value is None:
        return "not recorded"
    text = f"{value:.6g}" if isinstance(value, float) else str(value)
    if isinstance(value, bool):
        text = text.lower()
    return "".join(c for c in text if c.isprintable())


def words_of(value: object) -> str:
    """Return a value as `text_of` does, the entries of a list side by side."""
    return " ".join(map(text_of, value)) if isinstance(value, list) else text_of(value)
