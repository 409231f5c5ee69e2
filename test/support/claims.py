"""Pictures that are not what their headers say."""

from pathlib import Path
import struct
import zlib


def write_huge_png(path: Path, width: int = 40_000, height: int = 40_000) -> str:
    """A PNG of a hundred bytes whose header claims a size that no memory holds."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        checked = kind + content
        return struct.pack('>I', len(content)) + checked + struct.pack('>I', zlib.crc32(checked))

    header = struct.pack('>IIBBBBB', width, height, 8, 2, 0, 0, 0)
    body = chunk(b'IHDR', header) + chunk(b'IDAT', zlib.compress(bytes(9))) + chunk(b'IEND', b'')
    path.write_bytes(b'\x89PNG\r\n\x1a\n' + body)
    return str(path)
