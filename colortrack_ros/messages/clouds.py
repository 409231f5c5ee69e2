"""sensor_msgs/PointCloud2 <-> Detections, Tracks, and their outlines, in the layouts of data.py."""

import array
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import PointCloud2
from sensor_msgs.msg import PointField

from colortrack_ros.data import CORNER
from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import LOCATION
from colortrack_ros.data import OUTLINE_POINT
from colortrack_ros.data import TRACK
from colortrack_ros.data import TRACK_BOX
from colortrack_ros.data import Tracks
from colortrack_ros.messages.errors import MessageError
from colortrack_ros.messages.header import header_of
from colortrack_ros.messages.header import stamp_of
from colortrack_ros.messages.serialized import message_of_serialized

_DATATYPES = {
    'i1': PointField.INT8,
    'u1': PointField.UINT8,
    'i2': PointField.INT16,
    'u2': PointField.UINT16,
    'i4': PointField.INT32,
    'u4': PointField.UINT32,
    'f4': PointField.FLOAT32,
    'f8': PointField.FLOAT64,
}
_TYPE_NAMES = {datatype: name for name, datatype in _DATATYPES.items()}


def _fields_of(dtype: np.dtype[Any]) -> list[PointField]:
    fields = []
    for name in dtype.names or ():
        kind, offset = dtype.fields[name][:2]  # type: ignore[index]
        datatype = _DATATYPES[kind.base.str.lstrip('<|')]
        count = int(np.prod(kind.shape, dtype=int))
        fields.append(PointField(name=name, offset=offset, datatype=datatype, count=count))
    return fields


_FIELDS = {dtype: _fields_of(dtype) for dtype in (DETECTION, TRACK, OUTLINE_POINT, LOCATION)}


def cloud_of_detections(detections: Detections) -> PointCloud2:
    """One point for each detection."""
    return cloud_of_rows(detections.rows, detections.stamp, detections.frame_id)


def cloud_of_tracks(tracks: Tracks) -> PointCloud2:
    """One point for each track."""
    return cloud_of_rows(tracks.rows, tracks.stamp, tracks.frame_id)


def cloud_of_outlines(tracks: Tracks) -> PointCloud2:
    """One point for each point of each outline, in order, track by track."""
    outlines = tracks.outlines
    points = np.zeros(outlines.shape[:2], OUTLINE_POINT)
    points['track_id'] = tracks.rows['track_id'][: len(outlines), None]
    points['u'], points['v'] = outlines[..., 0], outlines[..., 1]
    known = np.isfinite(outlines).all(axis=2)
    return cloud_of_rows(points[known], tracks.stamp, tracks.frame_id)


def detections_of_cloud(message: PointCloud2) -> Detections:
    """The detections in a message, whose fields may have any order; other fields are ignored.

    :raises MessageError: a field is missing or has another type, or sizes do not agree.
    """
    rows = rows_of_cloud(message, DETECTION)
    return Detections(rows, stamp_of(message.header), message.header.frame_id)


def tracks_of_cloud(message: PointCloud2) -> Tracks:
    """The tracks in a message, whose fields may have any order; other fields are ignored.

    In recordings without the corners of the boxes, these are centered on the positions.

    :raises MessageError: a field is missing or has another type, or sizes do not agree.
    """
    rows = rows_of_cloud(message, TRACK)
    if len(rows) and not {*CORNER} <= {field.name for field in message.fields}:
        box = rows.view(TRACK_BOX)
        box['corner'] = np.stack([rows['u'], rows['v']], axis=1) - (box['size'] - 1) / 2
    return Tracks(rows, stamp_of(message.header), message.header.frame_id)


def detections_of_serialized_cloud(cdr: bytes) -> Detections:
    """The detections of a serialized message.

    :param cdr: as a subscription with ``raw=True`` hands it over.
    :raises MessageError: as :func:`detections_of_cloud`, and for bytes of something else.
    """
    return detections_of_cloud(message_of_serialized(cdr, PointCloud2))


def tracks_of_serialized_cloud(cdr: bytes) -> Tracks:
    """The tracks of a serialized message.

    :param cdr: as a subscription with ``raw=True`` hands it over.
    :raises MessageError: as :func:`tracks_of_cloud`, and for bytes of something else.
    """
    return tracks_of_cloud(message_of_serialized(cdr, PointCloud2))


def outlines_of_serialized_cloud(cdr: bytes) -> tuple[int, NDArray[np.void]]:
    """The stamp [ns] and points, (N,) of OUTLINE_POINT, of a serialized message of outlines.

    :param cdr: as a subscription with ``raw=True`` hands it over.
    :raises MessageError: as :func:`detections_of_serialized_cloud`, and for coordinates that are
        not finite.
    """
    message = message_of_serialized(cdr, PointCloud2)
    points = rows_of_cloud(message, OUTLINE_POINT)
    for name in ('u', 'v'):
        wrong = ~np.isfinite(points[name])
        if wrong.any():
            point = points[wrong][0]
            raise MessageError(
                f'outline of track {point["track_id"]}: expected finite coordinates, got {name} '
                f'{point[name]}'
            )
    return stamp_of(message.header), points


def tracks_with_outlines(tracks: Tracks, points: NDArray[np.void]) -> Tracks:
    """Add outlines to tracks; NaN if a track has none.

    :param points: (N,) of OUTLINE_POINT, in order along each outline.
    """
    points = points[np.argsort(points['track_id'], kind='stable')]
    wanted = tracks.rows['track_id']
    first = np.searchsorted(points['track_id'], wanted, side='left')
    counts = np.searchsorted(points['track_id'], wanted, side='right') - first
    longest = counts.max(initial=0)
    if longest == 0:
        return tracks
    # A shorter outline repeats its last point.
    steps = np.minimum(np.arange(longest), np.maximum(counts - 1, 0)[:, None])
    chosen = points[np.minimum(first[:, None] + steps, len(points) - 1)]
    outlines = np.stack([chosen['u'], chosen['v']], axis=2).astype(float)
    outlines[counts == 0] = np.nan
    return replace(tracks, outlines=outlines)


def cloud_of_rows(rows: NDArray[np.void], stamp: int, frame_id: str) -> PointCloud2:
    """One point for each row, (N,) of one of the dtypes of data.py."""
    data = array.array('B')
    data.frombytes(rows.tobytes())
    return PointCloud2(
        header=header_of(stamp, frame_id),
        height=1,
        width=len(rows),
        fields=_FIELDS[rows.dtype],
        is_bigendian=False,
        point_step=rows.itemsize,
        row_step=rows.itemsize * len(rows),
        data=data,
        is_dense=True,
    )


def rows_of_cloud(message: PointCloud2, dtype: np.dtype[Any]) -> NDArray[np.void]:
    """The points as (N,) of ``dtype``, a view of the message if the layout is the same.

    :raises MessageError: a field is missing or has another type, or sizes do not agree.
    """
    size = message.point_step * message.width * message.height
    if message.height != 1 and message.width * message.height:
        raise MessageError(f'point cloud of height {message.height}: expected 1')
    if len(message.data) != size or message.row_step < message.point_step * message.width:
        raise MessageError(
            f'point cloud data of {len(message.data)} bytes, row_step {message.row_step}: '
            f'expected {size}, {message.width} points of {message.point_step} bytes'
        )
    if message.width * message.height == 0:
        return np.zeros(0, dtype)
    same_layout = message.fields == _FIELDS[dtype] and message.point_step == dtype.itemsize
    if same_layout and not message.is_bigendian:
        return np.frombuffer(message.data, dtype)
    given = np.frombuffer(message.data, _dtype_of(message, dtype))
    rows = np.zeros(message.width, dtype)
    for name in given.dtype.names or ():
        rows[name] = given[name].reshape(rows[name].shape)
    return rows


def _dtype_of(message: PointCloud2, expected: np.dtype[Any]) -> np.dtype[Any]:
    """The layout of the message, restricted to the fields of ``expected``.

    :raises MessageError: one is missing, has another type, or reaches beyond the point.
    """
    order = '>' if message.is_bigendian else '<'
    given = {field.name: field for field in message.fields}
    names, formats, offsets = [], [], []
    for wanted in _FIELDS[expected]:
        field = given.get(wanted.name)
        if field is None and expected == TRACK and wanted.name in CORNER:
            continue
        if field is None:
            raise MessageError(f'point cloud without the field {wanted.name!r}')
        if (field.datatype, field.count) != (wanted.datatype, wanted.count):
            raise MessageError(
                f'point cloud field {field.name!r} of datatype {field.datatype} and count '
                f'{field.count}: expected {wanted.datatype} and {wanted.count}'
            )
        kind = np.dtype((order + _TYPE_NAMES[field.datatype], (field.count,)))
        if field.offset + kind.itemsize > message.point_step:
            raise MessageError(
                f'point cloud field {field.name!r} at offset {field.offset}: expected to end '
                f'within the point_step of {message.point_step}'
            )
        names.append(field.name)
        formats.append(kind)
        offsets.append(field.offset)
    return np.dtype(
        {
            'names': names,
            'formats': formats,
            'offsets': offsets,
            'itemsize': message.point_step,
        }
    )
