"""Label images with fast access to their nonempty parts."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

WORD = 8
"""Bytes of a uint64, which are processed together."""


@dataclass
class LabelImage:
    """One byte for each pixel: 0 for none of the colors, k + 1 for color k.

    Rows are padded with zeros, by at least one byte, to whole words of eight. Runs therefore end
    with their row, and a search for content skips eight empty pixels at a time.

    :param padded: (H, stride) contiguous, 0 from column width on.
    :param width: of the picture [px].
    :param filled: (N,) ascending indices of the words that may contain labels, None if any may.
        Code that sets labels in other words must set it to None; code that clears labels may leave
        it.
    :param apart: whether it is known that no two colors are adjacent. Code that sets labels must
        reset it; code that clears labels may leave it.
    """

    padded: NDArray[np.uint8]
    width: int
    filled: NDArray[np.intp] | None = None
    apart: bool = False

    @classmethod
    def empty(cls, height: int, width: int) -> 'LabelImage':
        """An image whose pixels are not yet set."""
        padded = np.empty((height, (width // WORD + 1) * WORD), np.uint8)
        padded[:, width:] = 0
        return cls(padded, width)

    @classmethod
    def blank(cls, height: int, width: int, old: 'LabelImage | None') -> 'LabelImage':
        """An image without labels.

        :param old: an image that is no longer needed; if of the same size, its memory is reused.
        """
        if old and old.filled is not None and old.pixels.shape == (height, width):
            old.words[old.filled] = 0
            return cls(old.padded, width)
        image = cls.empty(height, width)
        image.padded[...] = 0
        return image

    @property
    def stride(self) -> int:
        """Width of the padded image [px]; positions refer to it."""
        return self.padded.shape[1]

    @cached_property
    def pixels(self) -> NDArray[np.uint8]:
        """(H, W) view without the padding."""
        return self.padded[:, : self.width]

    @cached_property
    def words(self) -> NDArray[np.uint64]:
        """(H stride / 8,) view."""
        return self.padded.reshape(-1).view(np.uint64)

    def strip(self, top: int, bottom: int) -> 'LabelImage':
        """A view of some of the rows."""
        return LabelImage(self.padded[top:bottom], self.width)

    def copy(self) -> 'LabelImage':
        """A copy of the image."""
        return LabelImage(self.padded.copy(), self.width, self.filled)

    def content(self) -> tuple[NDArray[np.intp], NDArray[np.uint8]]:
        """The words that are not empty.

        :returns: their indices, (N,) ascending, and a copy of their labels, (N, 8).
        """
        if self.filled is None:
            (filled,) = (self.words != 0).nonzero()
        else:
            filled = self.filled[self.words.take(self.filled) != 0]
        return filled, self.words.take(filled).view(np.uint8).reshape(-1, WORD)

    def row_groups(self, apart: int) -> list[tuple[int, int]]:
        """First row and one past the last of each group of rows; together they contain all labels.

        :param apart: least number of empty rows between two groups.
        """
        if self.filled is None:
            return [(0, len(self.padded))]
        if not len(self.filled):
            return []
        row = self.filled // (self.stride // WORD)
        (last,) = (row[1:] - row[:-1] > apart).nonzero()
        first = np.concatenate([row[:1], row[last + 1]])
        behind = np.concatenate([row[last], row[-1:]]) + 1
        return list(zip(first.tolist(), behind.tolist(), strict=True))

    def positions(self) -> NDArray[np.intp]:
        """(N,) positions of the labeled pixels, v stride + u."""
        filled, labels = self.content()
        labeled = np.flatnonzero(labels)
        return (filled * WORD)[labeled >> 3] + (labeled & 7)
