"""Whether a MATLAB file of level 5 is made as it must be, before SciPy reads it.

SciPy's compiled reader believes the tags of a file: one that is spoiled ends the process, and with it
whatever can be said about the file. Format: MathWorks, "MAT-File Format", R2023b, chapter 1.
"""

from __future__ import annotations

import io
import math
import struct
import zlib
from collections.abc import Callable, Iterator

HEADER = 128  # bytes
MATRIX, COMPRESSED = 14, 15
PLAIN = {1, 2, 3, 4, 5, 6, 7, 9, 12, 13, 16, 17, 18}
CELL, STRUCT, OBJECT, SPARSE = 1, 2, 3, 5
ARRAYS = range(4, 16)  # characters, sparse and full arrays of numbers
COMPLEX = 0x800
SMALL = 4  # bytes that stand in the tag itself
DEEPEST = 64  # structs within one another: no log is, and SciPy calls itself for each; assumed
MOST_DIMENSIONS = 32  # that SciPy reads
CHUNK = 1 << 20  # bytes
Read = Callable[[int], bytes]  # so many bytes, or fewer where there are no more


class _Inflated:
    """The bytes of a compressed element, a piece at a time."""

    def __init__(self, packed: bytes) -> None:
        self._inflate, self._packed = zlib.decompressobj(), packed

    def read(self, count: int) -> bytes:
        """The next bytes, fewer at the end."""
        found = b""
        while len(found) < count:
            piece = self._inflate.decompress(self._packed, count - len(found))
            self._packed = self._inflate.unconsumed_tail
            if not piece:
                break
            found += piece
        return found


def check_mat(content: bytes) -> None:
    """Walk through the elements of a file; files of level 4 have none.

    Raises:
        ValueError: If an element is not what its place demands.
    """
    try:
        _check_elements(content)
    except (struct.error, zlib.error) as error:
        raise ValueError(str(error)) from error


def _check_elements(content: bytes) -> None:
    if len(content) < HEADER or 0 in content[:4]:
        return
    order = "<" if content[126:128] == b"IM" else ">"
    file = io.BytesIO(content)
    file.seek(HEADER)
    while file.tell() + 8 <= len(content):
        kind, size = struct.unpack(f"{order}II", file.read(8))
        body = file.read(size)
        if kind == COMPRESSED:
            read: Read = _Inflated(body).read
            kind, size = struct.unpack(f"{order}II", _exactly(read, 8))
        else:
            read = io.BytesIO(body).read
        if kind != MATRIX:
            raise ValueError(f"an element of type {kind} where an array must be")
        _check_matrix(read, order, size, 0)


def _check_matrix(read: Read, order: str, size: int, depth: int) -> None:
    if size == 0:  # an empty cell or field
        return
    if depth > DEEPEST:
        raise ValueError(f"arrays are more than {DEEPEST} deep within one another")
    flags = struct.unpack(f"{order}II", _plain(read, order, 8))[0]
    kind = flags & 0xFF
    dimensions = _numbers(read, order)
    if len(dimensions) < 2 or min(dimensions) < 0:
        raise ValueError(f"an array of dimensions {dimensions}")
    count = math.prod(dimensions)
    _plain(read, order)  # its name
    if kind in ARRAYS:
        for _ in range((3 if kind == SPARSE else 1) + bool(flags & COMPLEX)):
            _plain(read, order)
    elif kind in (CELL, STRUCT, OBJECT):
        if kind == OBJECT:
            _plain(read, order)
        count *= _fields(read, order) if kind != CELL else 1
        for _ in range(count):
            _check_nested(read, order, depth)
    # What is left are function handles and objects of classes, whose layout is not published.


def _check_nested(read: Read, order: str, depth: int) -> None:
    kind, size = struct.unpack(f"{order}II", _exactly(read, 8))
    if kind != MATRIX:
        raise ValueError(f"an element of type {kind} where an array must be")
    _check_matrix(read, order, size, depth + 1)


def _fields(read: Read, order: str) -> int:
    """How many fields a struct has."""
    longest = struct.unpack(f"{order}i", _plain(read, order, SMALL))[0]
    names = sum(len(piece) for piece in _pieces(read, order))
    if longest <= 0:
        raise ValueError(f"names of fields of {longest} letters")
    return names // longest


def _numbers(read: Read, order: str) -> tuple[int, ...]:
    """The whole numbers of an element."""
    found = _plain(read, order, SMALL * MOST_DIMENSIONS)
    return struct.unpack(f"{order}{len(found) // SMALL}i", found)


def _plain(read: Read, order: str, most: int | None = None) -> bytes:
    """What an element holds that is no array; nothing if it may be of any length."""
    pieces = _pieces(read, order)
    if most is None:
        for _ in pieces:
            pass
        return b""
    found = b"".join(pieces)
    if len(found) > most:
        raise ValueError(f"an element of {len(found)} bytes where at most {most} can be")
    return found


def _pieces(read: Read, order: str) -> Iterator[bytes]:
    """What the next element holds, a piece at a time; what is read then is the one behind it."""
    tag = _exactly(read, 8)
    kind, size = struct.unpack(f"{order}II", tag)
    small = kind >> 16
    kind &= 0xFFFF if small else 0xFFFFFFFF
    if kind not in PLAIN or small > SMALL:
        raise ValueError(f"an element of type {kind} and {small or size} bytes")
    if small:
        yield tag[4 : 4 + small]
        return
    for start in range(0, size, CHUNK):
        yield _exactly(read, min(CHUNK, size - start))
    _exactly(read, -size % 8)


def _exactly(read: Read, count: int) -> bytes:
    found = read(count)
    if len(found) < count:
        raise ValueError("the file ends within an element")
    return found
