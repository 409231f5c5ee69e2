"""Elements of EBML, the syntax of Matroska and WebM (RFC 8794)."""

from collections.abc import Iterator
import struct
from typing import BinaryIO

LONGEST_HEADER = 12
"""Maximum size of an element's kind and length [bytes]."""

SEARCHED_AT_ONCE = 1 << 20
"""Number of bytes to search at once. Assumed: it only bounds the memory."""


def header(head: bytes) -> tuple[int, int | None, int]:
    """Kind of an element, length of its content, and length of its header [bytes].

    :param head: the first bytes, LONGEST_HEADER if the file has as many.
    :returns: the length of the content is None if the element does not tell it.
    :raises ValueError: if no element can begin like this.
    """
    if not head or head[0] < 0x10:
        raise ValueError('no kind of an element')
    kind_size = 9 - head[0].bit_length()
    length, size = number(head[kind_size:])
    unknown = length == (1 << 7 * size) - 1
    return int.from_bytes(head[:kind_size], 'big'), None if unknown else length, kind_size + size


def number(data: bytes) -> tuple[int, int]:
    """A number whose first byte tells its size, and the size [bytes].

    :raises ValueError: if there is none.
    """
    size = 9 - data[0].bit_length() if data and data[0] else 0
    if not size or len(data) < size:
        raise ValueError('no length of an element')
    return int.from_bytes(data[:size], 'big') & (1 << 7 * size) - 1, size


def children(content: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield the kind and content of each element, up to the first broken one."""
    at = 0
    while at < len(content):
        try:
            kind, length, size = header(content[at : at + LONGEST_HEADER])
        except ValueError:
            return
        if length is None or at + size + length > len(content):
            return
        yield kind, content[at + size : at + size + length]
        at += size + length


def real(content: bytes) -> float:
    """A floating-point number; 0 if it is broken."""
    if len(content) not in (4, 8):
        return 0.0
    return float(struct.unpack('>f' if len(content) == 4 else '>d', content)[0])


def find(file: BinaryIO, pattern: bytes, start: int) -> int:
    """Place of a pattern at or after the start [bytes]; -1 if there is none."""
    while True:
        file.seek(start)
        chunk = file.read(SEARCHED_AT_ONCE)
        at = chunk.find(pattern)
        if at >= 0:
            return start + at
        if len(chunk) < SEARCHED_AT_ONCE:
            return -1
        start += SEARCHED_AT_ONCE - len(pattern) + 1
