"""The base class of tables: dataclasses whose arrays share their rows."""

from typing import Any
from typing import ClassVar
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Bools
from colortrack_ros.data import Indices

Selection = Bools | Indices
"""Rows of a table: a mask, or indices."""

Table = TypeVar('Table', bound='Columns')


class Columns:
    """Base of dataclasses whose arrays share their rows: one for each object, track, and so on.

    Fields that are arrays or Columns are columns. All others, such as the width of a picture,
    belong to the whole table and are left unchanged.
    """

    axis: ClassVar[int] = 0
    """The axis of the arrays along which the rows lie."""

    def columns(self) -> dict[str, Any]:
        """The columns by name."""
        return {k: v for k, v in vars(self).items() if isinstance(v, (np.ndarray, Columns))}

    def __len__(self) -> int:
        for column in vars(self).values():
            if isinstance(column, np.ndarray):
                return int(column.shape[self.axis])
            if isinstance(column, Columns):
                return len(column)
        raise TypeError(f'{type(self).__name__} has no columns')

    def take(self: Table, rows: Selection) -> Table:
        """A table of the selected rows, in that order."""
        table = type(self).__new__(type(self))
        vars(table).update(self._chosen(rows))
        return table

    def keep(self, rows: Selection) -> None:
        """Keep only these rows."""
        vars(self).update(self._chosen(rows))

    def extend(self: Table, other: Table) -> None:
        """Append the rows of another table."""
        theirs = vars(other)
        for name, column in self.columns().items():
            if isinstance(column, Columns):
                column.extend(theirs[name])
            else:
                vars(self)[name] = join(column, theirs[name], self.axis)

    def put(self: Table, rows: Selection, other: Table) -> None:
        """Replace some rows by those of another table.

        :param rows: (K,) or a mask with K True, the rows to replace.
        :param other: K rows.
        """
        theirs = vars(other)
        for name, column in self.columns().items():
            if isinstance(column, Columns):
                column.put(rows, theirs[name])
            else:
                whole_rows(column)[(slice(None),) * self.axis + (rows,)] = whole_rows(theirs[name])

    def _chosen(self, rows: Selection) -> dict[str, Any]:
        """All fields by name, with only the selected rows of columns."""
        index, axis = rows.nonzero()[0] if rows.dtype.kind == 'b' else rows, self.axis
        chosen = dict(vars(self))
        for name, column in chosen.items():
            if isinstance(column, np.ndarray):
                chosen[name] = column.take(index, axis)
            elif isinstance(column, Columns):
                chosen[name] = column.take(index)
        return chosen


def whole_rows(table: NDArray[Any]) -> NDArray[Any]:
    """A view of structured rows as raw bytes: NumPy then copies rows whole, not field by field.

    Arrays without fields, or with fields of objects, are returned unchanged.
    """
    in_one_piece = table.dtype.names and not table.dtype.hasobject
    return table.view((np.void, table.itemsize)) if in_one_piece else table


def join(table: NDArray[Any], below: NDArray[Any], axis: int = 0) -> NDArray[Any]:
    """Concatenate two arrays of the same type by rows."""
    rows = np.concatenate([whole_rows(table), whole_rows(below)], axis=axis)
    return rows.view(table.dtype) if table.dtype.names else rows
