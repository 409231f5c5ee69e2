"""Size of the pictures in the middle of a video, from what their codec says of it.

OpenCV tells the first size only; it scales or cuts pictures of another size.
"""

from collections.abc import Callable
from collections.abc import Iterator
import struct

import cv2

from colortrack_ros.sources.capture import open_file

Size = tuple[int, int]
"""Width and height [px]."""

HEAD_BYTES = 1 << 14
"""Number of bytes at the beginning of a picture among which its size is. Assumed: it only bounds
the time of each picture."""

LARGEST_SIDE = 16384
"""Largest width and height that are believed [px]. Assumed: twice the side of the largest square
picture that is read."""

HIGH_PROFILES = (44, 83, 86, 100, 110, 118, 122, 128, 134, 135, 138, 139, 244)
"""Profiles of H.264 whose headers tell the sampling of the colors."""


class SizeWatch:
    """Reads a video's compressed pictures, to be called once for each picture that is read.

    :ivar first: size of the first picture that tells it [px]; (0, 0) if none has told it yet.
    :ivar now: size of the current picture [px].
    """

    first: Size = (0, 0)
    now: Size = (0, 0)

    def __init__(self, path: str) -> None:
        self._parse: Callable[[bytes], Size | None] | None = None
        self._capture = open_file(path)
        self._is_raw = self._capture.set(cv2.CAP_PROP_FORMAT, -1)

    def __str__(self) -> str:
        """What they change from and to."""
        return '{}x{} to {}x{}'.format(*self.first, *self.now)

    @property
    def changed(self) -> bool:
        """Whether the current size is not the first."""
        return self.now != self.first

    def step(self) -> None:
        """Go on to the next picture."""
        if not self._is_raw or not self._capture.grab():
            return
        read, packet = self._capture.retrieve()
        if not read or packet is None:
            return
        size = self._size(packet.ravel()[:HEAD_BYTES].tobytes())
        if size is not None:
            self.first = self.first if any(self.first) else size
            self.now = size

    def _size(self, packet: bytes) -> Size | None:
        """Size of a picture if it tells it; the first that does tells which codec it is."""
        for parse in CODECS if self._parse is None else [self._parse]:
            try:
                size = parse(packet)
            except (IndexError, struct.error):
                continue
            if size is not None and 0 < min(size) <= max(size) <= LARGEST_SIDE:
                self._parse = parse
                return size
        return None

    def close(self) -> None:
        """Close the file."""
        self._capture.release()


class Bits:
    """Reads numbers from bits, the first bit of each byte is the highest.

    :raises IndexError: at the end.
    """

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 0

    def take(self, count: int) -> int:
        """The next bits, as a number."""
        value = 0
        for at in range(self._at, self._at + count):
            value = value << 1 | (self._data[at >> 3] >> (7 - (at & 7)) & 1)
        self._at += count
        return value

    def exp_golomb(self) -> int:
        """The next number in the exponential code of Golomb, without a sign."""
        zeros = 0
        while not self.take(1):
            zeros += 1
        return (1 << zeros) - 1 + self.take(zeros)

    def skip_codes(self, count: int) -> None:
        """Skip numbers in the exponential code of Golomb; a sign makes no difference."""
        for _ in range(count):
            self.exp_golomb()


def _units(packet: bytes) -> Iterator[bytes]:
    """The units after each start code, of H.264, HEVC, or MPEG-2."""
    if packet.lstrip(b'\0')[:1] == b'\1' and packet[:2] == b'\0\0':
        yield from packet.split(b'\0\0\1')[1:]


def _h264(packet: bytes) -> Size | None:
    """ITU-T H.264, 7.3.2.1: sequence parameter set."""
    found = [unit for unit in _units(packet) if unit and unit[0] & 0x9F == 7]
    if not found:
        return None
    bits = Bits(found[-1].replace(b'\0\0\3', b'\0\0')[1:])
    profile, _, _, chroma = bits.take(8), bits.take(16), bits.exp_golomb(), 1
    if profile in HIGH_PROFILES:
        chroma = bits.exp_golomb()
        bits.take(chroma == 3)
        bits.skip_codes(2)
        bits.take(1)
        if bits.take(1):
            _skip_scaling(bits, 12 if chroma == 3 else 8)
    bits.skip_codes(1)
    order = bits.exp_golomb()
    if order == 0:
        bits.skip_codes(1)
    elif order == 1:
        bits.take(1)
        bits.skip_codes(2)
        bits.skip_codes(bits.exp_golomb())
    bits.skip_codes(1)
    bits.take(1)
    width, height = bits.exp_golomb() + 1, bits.exp_golomb() + 1
    fields = 1 - bits.take(1)
    bits.take(1 + fields)
    across, down = _sampling(chroma)
    left, right, top, bottom = _window(bits)
    return (
        16 * width - across * (left + right),
        16 * height * (1 + fields) - down * (1 + fields) * (top + bottom),
    )


def _skip_scaling(bits: Bits, lists: int) -> None:
    """H.264, 7.3.2.1.1.1: scaling lists."""
    for k in range(lists):
        last, following = 8, 8
        for _ in range((16 if k < 6 else 64) * bits.take(1)):
            if following:
                code = bits.exp_golomb()
                following = (last + ((code + 1) // 2 if code % 2 else -(code // 2))) % 256
            last = following or last


def _sampling(chroma: int) -> Size:
    """Pixels of brightness per pixel of color, across and down."""
    return (2 if chroma in (1, 2) else 1, 2 if chroma == 1 else 1)


def _window(bits: Bits) -> tuple[int, int, int, int]:
    """What is cut off left, right, above and below."""
    if not bits.take(1):
        return 0, 0, 0, 0
    return bits.exp_golomb(), bits.exp_golomb(), bits.exp_golomb(), bits.exp_golomb()


def _hevc(packet: bytes) -> Size | None:
    """ITU-T H.265, 7.3.2.2: sequence parameter set."""
    units = list(_units(packet))
    found = [unit for unit in units if unit[:2] == b'\x42\1']
    if not found or units[0][1] != 1:
        return None
    bits = Bits(found[-1].replace(b'\0\0\3', b'\0\0')[2:])
    bits.take(4)
    layers = bits.take(3)
    bits.take(1 + 88 + 8)
    told = [(bits.take(1), bits.take(1)) for _ in range(8 if layers else 0)]
    for profile, level in told[:layers]:
        bits.take(88 * profile + 8 * level)
    bits.skip_codes(1)
    chroma = bits.exp_golomb()
    bits.take(chroma == 3)
    width, height = bits.exp_golomb(), bits.exp_golomb()
    across, down = _sampling(chroma)
    left, right, top, bottom = _window(bits)
    return width - across * (left + right), height - down * (top + bottom)


def _mpeg2(packet: bytes) -> Size | None:
    """ISO/IEC 13818-2, 6.2.2.1: sequence header; in MPEG-4, a picture follows the same code."""
    unit, following, *_ = [*_units(packet), b'', b'']
    if unit[:1] != b'\xb3' or following[:1] not in (b'\xb2', b'\xb5', b'\xb8', b'\x00'):
        return None
    return unit[1] << 4 | unit[2] >> 4, (unit[2] & 15) << 8 | unit[3]


def _jpeg(packet: bytes) -> Size | None:
    """ITU-T T.81, B.2.2: frame header."""
    at = 2
    while packet[:2] == b'\xff\xd8':
        marker, kind, length = struct.unpack_from('>BBH', packet, at)
        if marker != 0xFF:
            return None
        if 0xC0 <= kind <= 0xCF and kind not in (0xC4, 0xC8, 0xCC):
            height, width = struct.unpack_from('>HH', packet, at + 5)
            return width, height
        at += 2 + length
    return None


def _vp8(packet: bytes) -> Size | None:
    """RFC 6386, 9.1: header of a key frame."""
    if packet[0] & 1 or packet[3:6] != b'\x9d\x01\x2a':
        return None
    width, height = struct.unpack_from('<HH', packet, 6)
    return width & 0x3FFF, height & 0x3FFF


def _vp9(packet: bytes) -> Size | None:
    """VP9 bitstream specification, 6.2: uncompressed header of a key frame."""
    bits = Bits(packet)
    marker, profile = bits.take(2), bits.take(1) | bits.take(1) << 1
    if marker != 2 or bits.take(1 + (profile == 3)) or bits.take(1):
        return None
    bits.take(2)
    if bits.take(24) != 0x498342:
        return None
    bits.take(profile >= 2)
    spaces = bits.take(3)
    bits.take((spaces != 7) + (3 if spaces != 7 else 1) * (profile in (1, 3)))
    return bits.take(16) + 1, bits.take(16) + 1


CODECS = (_jpeg, _mpeg2, _hevc, _h264, _vp8, _vp9)
