"""The data that rooms exchange: Frame, Detections, Tracks, Locations; and the base class of tables.

Pixel coordinates are (u, v): u to the right, v down, the center of the top left pixel is (0, 0).
Times are integer nanoseconds, so the same stamps give bit-identical results.

The rows of Detections, Tracks and Locations have the memory layout of the point clouds that carry
them (little-endian, fixed offsets), so a message takes a single copy of the array's bytes.
"""

from dataclasses import dataclass
from dataclasses import field
from typing import Any
from typing import ClassVar
from typing import Protocol
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Indices = NDArray[np.intp]

NANOSECONDS = 1_000_000_000
"""In a second."""

ENCODINGS = {'bgr8': 3, 'rgb8': 3, 'bgra8': 4, 'rgba8': 4, 'mono8': 1}
"""Bytes per pixel of the image encodings (as named in sensor_msgs/image_encodings) that store a
color or a gray level for every pixel; for the others see encodings.py."""

DETECTION = np.dtype(
    {
        'names': [
            'u', 'v', 'cov_uu', 'cov_uv', 'cov_vv',
            'area', 'box_u', 'box_v', 'box_w', 'box_h', 'score', 'color',
        ],
        'formats': ['<f8'] * 5 + ['<f4'] * 6 + ['<u4'],
        'offsets': [0, 8, 16, 24, 32, 40, 44, 48, 52, 56, 60, 64],
        'itemsize': 72,
    }
)  # fmt: skip
"""One blob.

u, v: centroid [px]; cov_uu, cov_uv, cov_vv: measurement covariance of the centroid [px^2];
area: number of pixels, m00; box_u, box_v, box_w, box_h: bounding box, top left corner and size
[px]; score: 0..1, 1 when every pixel is exactly the reference color; color: index into the
detector's colors.
"""

TRACK = np.dtype(
    {
        'names': [
            'u', 'v', 'du', 'dv', 'covariance', 'track_id', 'color', 'state',
            'age', 'time_since_update', 'hits', 'area', 'box_w', 'box_h', 'score', 'box_u', 'box_v',
        ],
        'formats': (
            ['<f8'] * 4 + [('<f8', (4, 4)), '<u4', '<u4', 'u1', '<f4', '<f4', '<u4'] + ['<f4'] * 6
        ),
        'offsets': [0, 8, 16, 24, 32, 160, 164, 168, 172, 176, 180, 184, 188, 192, 196, 200, 204],
        'itemsize': 208,
    }
)  # fmt: skip
"""One live track.

u, v: estimated position [px]; du, dv: estimated velocity [px/s]; covariance: posterior covariance
of (u, v, du, dv); track_id: from 1, never used twice in a run; color: of the track; state:
TENTATIVE, CONFIRMED or COASTING; age: since the first detection [s]; time_since_update: since the
last detection [s], 0 when measured in this frame; hits: number of detections assigned to it; area,
box_w, box_h: of the last detection of this object alone, not of a blob of several [px]; score:
0..1, existence confidence; box_u, box_v: top left corner of that box, which lies around the
estimated position as it lay around the detection's centroid [px].
"""

CORNER = ('box_u', 'box_v')
"""Fields of the top left corner of a box."""

DETECTION_BOX, TRACK_BOX = (
    np.dtype({'names': ['corner', 'size'], 'formats': [kind] * 2, 'offsets': at, 'itemsize': size})
    for kind, at, size in ((('<f4', 2), [44, 52], 72), (('<f4', 2), [200, 188], 208))
)
"""Boxes as views of these rows, (N, 2) by axis: top left corner, and size [px]."""

LOCATION = np.dtype(
    {
        'names': [
            'x', 'y', 'z', 'vx', 'vy', 'vz', 'covariance', 'track_id', 'color', 'state',
            'diameter', 'time_since_update', 'score',
        ],
        'formats': (
            ['<f4'] * 6 + [('<f8', (6, 6)), '<u4', '<u4', 'u1', '<f4', '<f4', '<f4']
        ),
        'offsets': [0, 4, 8, 12, 16, 20, 24, 312, 316, 320, 324, 328, 332],
        'itemsize': 336,
    }
)  # fmt: skip
"""One object in the world.

x, y, z: its center in a fixed frame [m]; vx, vy, vz: its velocity there [m/s]; covariance:
posterior covariance of (x, y, z, vx, vy, vz); track_id, color, state: as in TRACK; diameter: [m],
0 when not known; time_since_update: since the last measurement [s]; score: 0..1, existence
confidence.
"""

OUTLINE_POINT = np.dtype([('track_id', '<u4'), ('u', '<f4'), ('v', '<f4')])
"""One point of a track's closed outline: ID of the track, and position [px]."""

TENTATIVE, CONFIRMED, COASTING = 0, 1, 2
"""Values of a track's state: not yet confirmed; confirmed; confirmed but not measured in this
frame."""


@dataclass(frozen=True)
class Frame:
    """A picture and the time it was taken.

    :param image: uint8, (H, W, channels), or (H, W) for one channel, or (3 H / 2, W) for nv12 and
        nv21; rows may be padded (a strided view).
    :param encoding: a key of ENCODINGS, or of LAYOUTS in encodings.py.
    :param stamp: time of the exposure [ns].
    :param frame_id: the camera's coordinate frame.
    :param full_range: the luma of YUV goes from 0 to 255, not from 16 to 235.
    """

    image: NDArray[np.uint8]
    encoding: str = 'bgr8'
    stamp: int = 0
    frame_id: str = ''
    full_range: bool = False


class Viewpoint(Protocol):
    """The pose of the camera when a picture is taken."""

    def shows(self, pixels: Floats, reach: Floats) -> Bools:
        """Whether any part of each object would be inside the picture, (N,).

        :param pixels: (N, 2) in the picture, or outside it [px].
        :param reach: (N, 2, 2) extent of each object toward lower and higher coordinates, by axis
            [px].
        """

    def nearness(self, pixels: Floats, feet: Floats) -> Floats:
        """Inverse distance of objects on the ground, (N,) [1/m]; 0 for distant ones.

        :param pixels: (N, 2) their centers in the picture [px].
        :param feet: (N, 2) their lowest points [px].
        """

    def moved(self, pixels: Floats, since: Any, nearness: Floats) -> tuple[Floats, Floats, Floats]:
        """Where this picture shows stationary points that an earlier picture shows.

        :param pixels: (N, 2) in the earlier picture, or outside it [px].
        :param since: the Viewpoint of the earlier picture.
        :param nearness: (N,) inverse distances from the camera at that time [1/m].
        :return: (N, 2), in this picture or outside it [px], the Jacobian, (N, 2, 2), and the
            inverse distances now, (N,).
        """


@dataclass(frozen=True)
class Detections:
    """The blobs of one frame, largest area first.

    :param rows: (N,) of dtype DETECTION.
    :param stamp: of the frame [ns].
    :param frame_id: of the frame.
    :param image_size: width and height of the picture [px]; 0 if unknown.
    :param viewpoint: of the camera; None if unknown.
    """

    rows: NDArray[np.void] = field(default_factory=lambda: np.zeros(0, DETECTION))
    stamp: int = 0
    frame_id: str = ''
    image_size: tuple[int, int] = (0, 0)
    viewpoint: Viewpoint | None = None


@dataclass(frozen=True)
class Tracks:
    """The live tracks after one frame, ascending track_id.

    :param rows: (N,) of dtype TRACK.
    :param stamp: of the frame [ns].
    :param frame_id: of the frame.
    :param restarted: why the tracker restarted with this frame and dropped all tracks; empty if it
        did not.
    :param outlines: (N, P, 2) points u, v along the closed outline of each track [px]; (0, 0, 2)
        from trackers without outlines.
    """

    rows: NDArray[np.void] = field(default_factory=lambda: np.zeros(0, TRACK))
    stamp: int = 0
    frame_id: str = ''
    restarted: str = ''
    outlines: Floats = field(default_factory=lambda: np.zeros((0, 0, 2)))


@dataclass(frozen=True)
class Locations:
    """The objects in the world after one frame, ascending track_id.

    :param rows: (N,) of dtype LOCATION.
    :param stamp: of the picture, or the time to which they are predicted [ns].
    :param frame_id: the fixed frame.
    """

    rows: NDArray[np.void] = field(default_factory=lambda: np.zeros(0, LOCATION))
    stamp: int = 0
    frame_id: str = ''


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
