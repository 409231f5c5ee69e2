"""Records: named fields of many tracks, each field an array of its own."""

from collections.abc import Sequence
from typing import Any
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.columns import Columns
from colortrack_ros.columns import Selection

Fields = Sequence[tuple[Any, ...]]

Some = TypeVar('Some', bound='Records')


class Records(Columns, dict[str, NDArray[Any]]):
    """N rows of fields: ``records[name]`` is (N, ...), a view to read from and to write to.

    Fields of one type and shape share a block (F, N, ...). So each field is contiguous, whatever
    else is recorded, and rows are selected and joined in as many steps as there are blocks. The
    dictionary holds the views made so far.

    :param fields: names, types and shapes as for np.dtype.
    :param count: N; the fields are 0.
    """

    axis = 1
    block0: NDArray[Any]

    def __init__(self, fields: Fields, count: int = 0) -> None:
        blocks: dict[np.dtype[Any], list[str]] = {}
        for name, *of in fields:
            blocks.setdefault(np.dtype(tuple(of) if len(of) > 1 else of[0]), []).append(name)
        self._places = {}
        for i, (dtype, names) in enumerate(blocks.items()):
            vars(self)[f'block{i}'] = np.zeros((len(names), count), dtype)
            self._places.update({name: (f'block{i}', j) for j, name in enumerate(names)})

    def __len__(self) -> int:
        return self.block0.shape[1]

    def __reduce__(self) -> tuple[Any, ...]:
        """For copies and other processes: the views made so far are left out."""
        return _restored, (type(self), vars(self))

    @property
    def names(self) -> tuple[str, ...]:
        """Of the fields."""
        return tuple(self._places)

    def __missing__(self, name: str) -> NDArray[Any]:
        block, place = self._places[name]
        view: NDArray[Any] = vars(self)[block][place]
        dict.__setitem__(self, name, view)
        return view

    def __setitem__(self, name: str, values: Any) -> None:
        view = self[name]
        if values is not view:  # as it is in `records[name] += 1`
            view[...] = values

    def keep(self, rows: Selection) -> None:
        """Drop all other rows from this table."""
        super().keep(rows)
        self.clear()

    def extend(self: Some, other: Some) -> None:
        """Add the rows of another table below these."""
        super().extend(other)
        self.clear()

    def grown(self: Some, count: int) -> Some:
        """A table of these rows and so many more below them, whose fields are 0."""
        blocks, before = self.columns(), len(self)
        for name, block in blocks.items():
            more = np.zeros((len(block), before + count, *block.shape[2:]), block.dtype)
            more[:, :before] = block
            blocks[name] = more
        return self._of(blocks)

    def copy(self: Some) -> Some:
        """A table of the same rows, with memory of its own."""
        return self.take(np.arange(len(self)))

    def part(self: Some, rows: slice) -> Some:
        """A view of neighboring rows, to read from and to write to."""
        return self._of({name: block[:, rows] for name, block in self.columns().items()})

    def _of(self: Some, blocks: dict[str, NDArray[Any]]) -> Some:
        """A table of the same fields in other blocks."""
        table = type(self).__new__(type(self))
        vars(table).update(vars(self), **blocks)
        return table


def _restored(kind: type[Some], state: dict[str, Any]) -> Some:
    """The table that was copied, or came from another process."""
    table = kind.__new__(kind)
    vars(table).update(state)
    return table
