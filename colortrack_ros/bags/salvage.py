"""Reads recordings that were cut short by a crash, a full disk, or a broken copy."""

from collections.abc import Iterator
import contextlib
import io
from pathlib import Path
import struct
from typing import Any
from typing import BinaryIO

import apsw
from rosbags.rosbag2.storage_mcap import decompress
from rosbags.rosbag2.storage_mcap import read_exact
from rosbags.rosbag2.storage_mcap import read_string

from colortrack_ros.bags.bag_file import BagFile
from colortrack_ros.bags.bag_file import Topic
from colortrack_ros.bags.portable import PortableFile

MAGIC = b'\x89MCAP0\r\n'
RECORD = struct.Struct('<BQ')
"""Opcode and length of each record of MCAP (https://mcap.dev/spec)."""
CLOSING = frozenset((0x00, 0x02, 0x0F))
"""Opcodes that end the messages: none, as in what a computer that lost power did not write; footer,
data end."""
FOOTER = RECORD.pack(0x02, 20) + bytes(20) + MAGIC
"""Footer of a file without an index, which makes readers scan the file."""
CHUNK = 0x06
"""Opcode of a chunk, a record that holds others."""
UNCOMPRESSED = 37, bytes(4), 49
"""Offset of the compression in a chunk, its value for none, and the offset of the chunk's records:
after opcode, length, two times, size, checksum, compression, and size."""
PRIVATE = b'\x80'
"""Opcode of a private record, which readers skip."""
SKIPPED = RECORD.pack(PRIVATE[0], UNCOMPRESSED[2] - RECORD.size)
"""Header of a private record, which readers skip, as long as the header of such a chunk."""


def salvage(path: Path) -> BagFile:
    """Open the part of an .mcap or .db3 file that can still be read.

    :raises Exception: nothing of it can be read; the type depends on the library.
    """
    return CutDatabase(path) if path.suffix == '.db3' else PortableFile(CutMcap(path))


class CutMcap:
    """The complete records of an .mcap file with a footer added; a path to rosbags."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.suffix, self.exists, self.is_dir = path.suffix, path.exists, path.is_dir

    def __str__(self) -> str:
        return str(self._path)

    def open(self, *_: Any) -> BinaryIO:
        """The file."""
        return io.BufferedReader(_Mended(self._path.open('rb')))


class _Mended(io.RawIOBase):
    """A file whose last records are missing, completed by the footer of a file without an index.

    Readers skip its broken chunks.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file, self._at = file, 0
        chunks, end = _walk(file, len(MAGIC))
        parts = [(at, PRIVATE) for at in chunks if not _is_whole(file, at)]
        last = (end, FOOTER)
        file.seek(end)
        head = file.read(UNCOMPRESSED[2])
        where, none, inner = UNCOMPRESSED
        if len(head) == inner and head[0] == CHUNK and head[where:][:4] == none:
            parts.append((end, SKIPPED))
            last = (_walk(file, end + inner)[1], FOOTER)
        self._replaced = [*parts, last]

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        last, footer = self._replaced[-1]
        self._at = offset + {io.SEEK_SET: 0, io.SEEK_CUR: self._at}.get(whence, last + len(footer))
        return self._at

    def readinto(self, buffer: Any) -> int:
        content = self._next(len(buffer))
        buffer[: len(content)] = content
        self._at += len(content)
        return len(content)

    def _next(self, size: int) -> bytes:
        """The bytes from here up to the next part that is replaced."""
        for start, content in self._replaced:
            if self._at < start:
                self._file.seek(self._at)
                return self._file.read(min(size, start - self._at))
            if self._at < start + len(content):
                return content[self._at - start :][:size]
        return b''

    def close(self) -> None:
        self._file.close()
        super().close()


def _walk(file: BinaryIO, at: int) -> tuple[list[int], int]:
    """Offsets of the chunks from an offset on, and that of the end of the last complete record.

    Records that end the messages do not count.
    """
    chunks: list[int] = []
    size = file.seek(0, io.SEEK_END)
    while True:
        file.seek(at)
        head = file.read(RECORD.size)
        if len(head) < RECORD.size:
            return chunks, at
        code, length = RECORD.unpack(head)
        if code in CLOSING or at + RECORD.size + length > size:
            return chunks, at
        if code == CHUNK:
            chunks.append(at)
        at += RECORD.size + length


def _is_whole(file: BinaryIO, at: int) -> bool:
    """Whether the chunk at an offset holds what was written."""
    file.seek(at)
    _, length = RECORD.unpack(file.read(RECORD.size))
    record = io.BytesIO(file.read(length))
    try:
        _, _, size, crc = struct.unpack('<QQQI', read_exact(record, 28))
        compression = read_string(record)
        record.seek(8, io.SEEK_CUR)
        inside = decompress(record.read(), compression, size, crc)
    except Exception:  # the libraries raise all kinds of errors
        return False
    return _walk(io.BytesIO(inside), 0)[1] == len(inside)  # not all chunks have a checksum


class _WholePages(apsw.VFS):
    """Files without the incomplete page at their end, which SQLite would fill with zeros."""

    NAME = 'colortrack_ros_whole_pages'

    def __init__(self) -> None:
        super().__init__(self.NAME, '')

    def xOpen(self, name: Any, flags: list[int]) -> apsw.VFSFile:
        return _WholePagesFile('', name, flags)


class _WholePagesFile(apsw.VFSFile):
    def xFileSize(self) -> int:
        written = int.from_bytes(self.xRead(2, 16), 'big')
        page = 1 << 16 if written == 1 else max(written, 1)  # https://sqlite.org/fileformat.html
        size: int = super().xFileSize()
        return size // page * page


PAGES = _WholePages()
"""Registered with SQLite as long as this object lives."""


class CutDatabase:
    """The rows of a .db3 file up to the first page that is missing."""

    def __init__(self, path: Path) -> None:
        uri, flags = path.absolute().as_uri(), apsw.SQLITE_OPEN_READONLY | apsw.SQLITE_OPEN_URI
        if path.with_name(f'{path.name}-wal').exists():  # with messages that are not in it yet
            self._database = apsw.Connection(uri, flags=flags)
        else:
            self._database = apsw.Connection(f'{uri}?immutable=1', flags=flags, vfs=PAGES.NAME)
        # Without it, SQLite refuses a file that is shorter than its header says.
        self._database.execute('PRAGMA writable_schema=ON')
        kinds = self._database.execute('SELECT id, name, type FROM topics').fetchall()
        self._numbers = {(name, kind): number for number, name, kind in kinds}
        times: dict[int, list[int]] = {number: [] for number, *_ in kinds}
        for number, time, _ in self._rows():
            times[number].append(time)
        known = [time for some in times.values() for time in some]
        self.duration = max(known, default=0) - min(known, default=0)
        self.topics = [
            Topic(name, kind, len(times[number])) for number, name, kind in kinds if times[number]
        ]

    def _rows(self) -> Iterator[tuple[int, int, bytes]]:
        """Topic, log time and content of each message, up to the first page that is missing."""
        with contextlib.suppress(apsw.Error):
            # Not in the order of the index, whose pages may be missing.
            yield from self._database.execute(
                'SELECT topic_id, timestamp, data FROM messages NOT INDEXED'
            )

    def messages(self, topic: Topic) -> Iterator[tuple[int, bytes]]:
        """Log time [ns] and serialized content of each message of a topic, as recorded."""
        wanted = self._numbers.get((topic.name, topic.kind))
        return ((time, cdr) for number, time, cdr in self._rows() if number == wanted)

    def close(self) -> None:
        """Let go of the file."""
        self._database.close()
