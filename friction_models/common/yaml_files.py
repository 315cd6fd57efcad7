"""YAML files from anywhere: size and depth are limited before anything is built, and errors are one sentence."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

import yaml

from .byte_order_marks import decoded
from .errors import InputError, check_readable

#: Largest file, where its reader allows no less.
MAX_BYTES = 4_000_000
#: Deepest nesting of a file.
MAX_DEPTH = 8


def read_yaml(file: Path, most: int = MAX_BYTES, allowed: str = "a YAML file") -> Any:
    """Return what a YAML file of at most so many bytes holds; `allowed` says what it should be.

    Raises InputError: what `check_readable` refuses, neither UTF-8 nor UTF-16 or UTF-32 with a mark, not YAML, nested deeper than `MAX_DEPTH`, a key that stands twice, an alias
    (aliases may grow without bound), or a number that no float holds.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     file = Path(place) / "system.yaml"
    ...     _ = file.write_text("{stop_time: 0.5, components: {friction: {fmu: friction.fmu}}}")
    ...     read_yaml(file)
    {'stop_time': 0.5, 'components': {'friction': {'fmu': 'friction.fmu'}}}
    """
    check_readable(file, most, allowed)
    try:
        text = decoded(file.read_bytes())
        _check_events(text, str(file))
        loader = yaml.SafeLoader(text)
        node = loader.get_single_node()
        _check_keys(node, str(file))
        content = None if node is None else loader.construct_document(node)
        _check_numbers(content, str(file))
        return content
    except InputError:
        raise
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        raise InputError(f"{file}: not YAML ({' '.join(str(error).split())[:200]})") from None


def _check_numbers(value: Any, where: str) -> None:
    """Refuse whole numbers that no float holds."""
    if isinstance(value, dict | list):
        for item in (*value, *value.values()) if isinstance(value, dict) else value:
            _check_numbers(item, where)
    elif isinstance(value, int) and abs(value) > sys.float_info.max:
        raise InputError(
            f"{where}: a number of {len(str(value))} digits, allowed: up to {sys.float_info.max:.1e}"
        )


def _check_events(text: str, where: str) -> None:
    depth = 0
    for event in yaml.parse(text, Loader=yaml.SafeLoader):
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if isinstance(event, yaml.AliasEvent):
            raise InputError(f"{where}: holds an alias (*name), allowed: plain keys and values")
        if depth > MAX_DEPTH:
            raise InputError(f"{where}: nested deeper than {MAX_DEPTH} levels, allowed: at most that")


def _check_keys(node: yaml.Node | None, where: str) -> None:
    """Refuse a key that stands twice: YAML would keep the last one and say nothing."""
    if isinstance(node, yaml.SequenceNode):
        for child in node.value:
            _check_keys(child, where)
    if not isinstance(node, yaml.MappingNode):
        return
    seen: set[str] = set()
    for key, value in node.value:
        if isinstance(key, yaml.ScalarNode):
            if key.value in seen:
                line = key.start_mark.line + 1
                raise InputError(
                    f"{where}: key {key.value!r} stands twice, again in line {line}; allowed: once"
                )
            seen.add(key.value)
        _check_keys(value, where)


def number_without_point(value: Any) -> Any:
    """Return the number that a text such as ``2e-3`` is, anything else as it is: YAML 1.1 wants a point and a sign in it.

    Examples
    --------
    >>> [number_without_point(v) for v in ("2e-3", "1.5e3", "16MnCr5", 7)]
    [0.002, 1500.0, '16MnCr5', 7]
    """
    written = isinstance(value, str) and re.fullmatch(r"[+-]?\d+(\.\d*)?[eE][+-]?\d+", value)
    return float(value) if written else value
