"""Keeps the table of colors from picture to picture."""

from functools import lru_cache

from colortrack_ros.detection.color_table import ColorTable
from colortrack_ros.detection.color_table import FEW_CELLS
from colortrack_ros.detection.reference import ReferenceColor


class KeptTable:
    """The color table of one user.

    :param is_fixed: whether the colors never change: the table is shared by all with the same.
    :param threads: as for :class:`ColorTable`.
    """

    def __init__(self, is_fixed: bool, threads: int) -> None:
        self._is_fixed, self._threads = is_fixed, threads
        self._own: ColorTable | None = None

    def of(self, colors: tuple[ReferenceColor, ...]) -> ColorTable:
        """The table of these colors; one that is not fixed takes them, as many as before."""
        if self._is_fixed:
            return _shared(colors, self._threads)
        if self._own is None:
            self._own = ColorTable(colors, self._threads, FEW_CELLS)
        else:
            self._own.take(colors)
        return self._own


@lru_cache(maxsize=4)
def _shared(colors: tuple[ReferenceColor, ...], threads: int) -> ColorTable:
    """Cached tables: a configuration with the same colors applies without delay."""
    return ColorTable(colors, threads)
