"""Reads serialized messages without copying their large fields."""

import struct

from colortrack_ros.data import NANOSECONDS


class CdrError(ValueError):
    """The bytes end too early, or do not form the field that is read."""


class Reader:
    """The fields of a message in their order, from its bytes in CDR (OMG DDS-XTYPES 1.3, 7.4).

    :param cdr: with the encapsulation header of four bytes, from which alignment counts.
    """

    def __init__(self, cdr: bytes) -> None:
        if len(cdr) < 4 or cdr[0] != 0 or cdr[1] > 1:
            raise CdrError(f'encapsulation {bytes(cdr[:2]).hex()}: expected 0000 or 0001')
        self._cdr, self._at = memoryview(cdr), 4
        self._order = '>' if cdr[1] == 0 else '<'
        self._uint32 = struct.Struct(self._order + 'I')

    def uint32(self) -> int:
        """A uint32."""
        at = (self._at + 3) & ~3
        if at + 4 > len(self._cdr):
            raise CdrError(f'it ends at byte {len(self._cdr)}')
        self._at = at + 4
        number: int = self._uint32.unpack_from(self._cdr, at)[0]
        return number

    def count(self, least: int) -> int:
        """Number of elements of a sequence, of at least so many bytes each."""
        number = self.uint32()
        left = len(self._cdr) - self._at
        if number * least > left:
            raise CdrError(f'{number} elements in {left} bytes: expected at least {least} for each')
        return number

    def doubles(self, count: int) -> tuple[float, ...]:
        """So many float64, one after the other."""
        self._at = (self._at - 4 + 7 & ~7) + 4
        return struct.unpack(f'{self._order}{count}d', self._take(8 * count))

    def byte(self) -> int:
        """A uint8 or bool."""
        return self._take(1)[0]

    def string(self) -> str:
        """A string."""
        try:
            return str(self._take(self.uint32()), 'utf-8').rstrip('\0')
        except UnicodeDecodeError as error:
            raise CdrError(f'a string that is not UTF-8: {error}') from error

    def bytes_(self) -> memoryview:
        """A sequence of uint8, a view."""
        return self._take(self.uint32())

    def stamp(self) -> int:
        """A builtin_interfaces/Time [ns]."""
        seconds = (self.uint32() ^ 1 << 31) - (1 << 31)  # an int32
        nanosec = self.uint32()
        if nanosec >= NANOSECONDS:
            raise CdrError(f'a stamp with {nanosec} ns, expected less than {NANOSECONDS}')
        return seconds * NANOSECONDS + nanosec

    def header(self) -> tuple[int, str]:
        """A std_msgs/Header: its stamp [ns] and frame_id."""
        return self.stamp(), self.string()

    def end(self) -> None:
        """Refuse bytes behind the last field, but for the padding of CDR, up to three."""
        left = len(self._cdr) - self._at
        if left > 3:
            raise CdrError(f'{left} bytes more than its fields have')

    def _take(self, size: int) -> memoryview:
        if self._at + size > len(self._cdr):
            raise CdrError(f'{size} bytes at byte {self._at} of {len(self._cdr)}')
        self._at += size
        return self._cdr[self._at - size : self._at]
