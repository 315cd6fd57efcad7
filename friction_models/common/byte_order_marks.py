"""Which Unicode encoding a text file says it has: the mark at its beginning, as spreadsheets and Windows write it."""

from __future__ import annotations

import codecs

#: The longer marks first: that of UTF-32 begins like one of UTF-16.
_MARKS = (
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
    (codecs.BOM_UTF8, "utf-8-sig"),
)


def marked_encoding(head: bytes) -> str:
    """Return the encoding that the first four bytes of a file name; UTF-8 where they name none.

    Examples
    --------
    >>> marked_encoding("mu".encode("utf-32")), marked_encoding("mu".encode("utf-16")), marked_encoding(b"mu")
    ('utf-32', 'utf-16', 'utf-8-sig')
    """
    return next((encoding for mark, encoding in _MARKS if head.startswith(mark)), "utf-8-sig")


def decoded(raw: bytes) -> str:
    """Return a text of UTF-8, or of UTF-16 or UTF-32 with a mark.

    Raises UnicodeDecodeError.

    Examples
    --------
    >>> decoded("µ".encode("utf-16")) == decoded("µ".encode()) == "µ"
    True
    """
    return raw.decode(marked_encoding(raw))
