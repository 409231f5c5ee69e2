"""Serializes many markers as a visualization_msgs/MarkerArray, in arrays.

One message object costs 0.1 ms, so the markers of 500 tracks would cost more than their picture.
Markers of one kind differ only in numbers: they are rows of one array whose dtype has the fields of
a serialized Marker (OMG DDS-XTYPES 1.3, 7.4). The padding before a double depends on whether a
marker begins at a multiple of eight bytes or four after it, so each is made for both.
"""

from collections.abc import Iterable
import functools
import struct
from typing import Any
from typing import NamedTuple

import numpy as np

Rows = list[tuple[bytes, bytes]]
"""Serialized markers, both for an offset of a multiple of 8 bytes and for one of 4 bytes more."""


class MarkerKind(NamedTuple):
    """The fields that all markers of a kind share.

    :param header: sec, nanosec and frame_id.
    :param ns: namespace.
    :param type: and action, as in visualization_msgs/Marker.
    :param points: number of them.
    :param text: number of its bytes.
    """

    header: tuple[int, int, bytes]
    ns: bytes = b''
    type: int = 0
    action: int = 0
    points: int = 0
    text: int = 0


def rows_of(kind: MarkerKind, count: int, **columns: Any) -> Rows:
    """N markers of a kind, serialized.

    :param columns: values of fields by name, (N, ...) or one for all.
    """
    if not count:
        return []
    columns['sec'], columns['nanosec'], columns['frame_id'] = kind.header
    columns.update(ns=kind.ns, type=kind.type, action=kind.action, points_count=kind.points)
    lengths = len(kind.header[2]), len(kind.ns), kind.points, kind.text
    phases = []
    for phase in (0, 4):
        dtype = _dtype(*lengths, phase)
        rows = np.zeros(count, dtype)
        rows['orientation'] = 0.0, 0.0, 0.0, 1.0
        for name in dtype.names or ():
            if name.endswith('_length'):
                rows[name] = dtype[name.removesuffix('_length')].itemsize
        for name, values in columns.items():
            rows[name] = values
        raw, size = rows.tobytes(), dtype.itemsize
        phases.append([raw[i : i + size] for i in range(0, len(raw), size)])
    return list(zip(*phases, strict=True))


def array_of(markers: Iterable[tuple[bytes, bytes]]) -> bytes:
    """The message with these markers, in order."""
    parts, at, count = [], 4, 0
    for marker in markers:
        parts.append(bytes(-at % 4))
        at += -at % 4
        parts.append(marker[at % 8 // 4])
        at += len(parts[-1])
        count += 1
    return b'\x00\x01\x00\x00' + struct.pack('<I', count) + b''.join(parts)


@functools.lru_cache
def _dtype(frame_id: int, ns: int, points: int, text: int, phase: int) -> 'np.dtype[Any]':
    """The fields and offsets of a Marker that begins at a multiple of 8 bytes plus phase.

    Making one takes longer than all else that is done for a few markers.

    :param frame_id, ns, text: number of their bytes; points: number of them.
    """
    vectors = [('points', '<f8', (points, 3))] if points else []
    fields = [
        *[('sec', '<i4'), ('nanosec', '<u4'), *_string('frame_id', frame_id)],
        *[*_string('ns', ns), ('id', '<i4'), ('type', '<i4'), ('action', '<i4')],
        *[('position', '<f8', 3), ('orientation', '<f8', 4), ('scale', '<f8', 3)],
        *[('color', '<f4', 4), ('lifetime', '<i4', 2), ('frame_locked', 'u1')],
        *[('points_count', '<u4'), *vectors, ('colors_count', '<u4'), *_string('texture_resource')],
        *[('texture_stamp', '<i4', 2), *_string('texture_frame_id'), *_string('texture_format')],
        *[('texture_count', '<u4'), ('uv_count', '<u4'), *_string('text', text)],
        *[*_string('mesh_resource'), *_string('mesh_filename'), ('mesh_count', '<u4')],
        *[('mesh_use_embedded_materials', 'u1')],
    ]
    offsets, at = [], phase
    for field in fields:
        item = np.dtype(field[1:]) if len(field) > 2 else np.dtype(field[1])
        at += -at % (1 if item.kind == 'S' else item.base.itemsize)
        offsets.append(at - phase)
        at += item.itemsize
    names, formats = [f[0] for f in fields], [f[1:] if len(f) > 2 else f[1] for f in fields]
    return np.dtype(
        {'names': names, 'formats': formats, 'offsets': offsets, 'itemsize': at - phase}
    )


def _string(name: str, length: int = 0) -> list[tuple[Any, ...]]:
    """A string: its length, including the terminating zero, then its bytes."""
    return [(f'{name}_length', '<u4'), (name, f'S{length + 1}')]
