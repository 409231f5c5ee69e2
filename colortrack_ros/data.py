"""The words that all rooms share: Frame, Detections, Tracks.

Pixel coordinates are (u, v): u to the right, v down, the center of the top left pixel is (0, 0).
Time is an integer number of nanoseconds, so that the same stamps give the same results to the bit.

The rows of :class:`Detections` and :class:`Tracks` have the memory layout of the point clouds that
carry them (little-endian, fixed offsets), so a message is one copy of the array's bytes.
"""

from dataclasses import dataclass
from dataclasses import field

import numpy as np
from numpy.typing import NDArray

NANOSECONDS = 1_000_000_000

ENCODINGS = {'bgr8': 3, 'rgb8': 3, 'bgra8': 4, 'rgba8': 4, 'mono8': 1}
"""Image encodings (names of sensor_msgs/image_encodings) and their bytes a pixel."""

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
            'age', 'time_since_update', 'hits', 'area', 'box_w', 'box_h', 'score',
        ],
        'formats': (
            ['<f8'] * 4 + [('<f8', (4, 4)), '<u4', '<u4', 'u1', '<f4', '<f4', '<u4'] + ['<f4'] * 4
        ),
        'offsets': [0, 8, 16, 24, 32, 160, 164, 168, 172, 176, 180, 184, 188, 192, 196],
        'itemsize': 208,
    }
)  # fmt: skip
"""One live track.

u, v: estimated position [px]; du, dv: estimated velocity [px/s]; covariance: posterior covariance
of (u, v, du, dv); track_id: from 1, never used twice in a run; color: of the track; state:
TENTATIVE, CONFIRMED or COASTING; age: since the first detection [s]; time_since_update: since the
last detection [s], 0 when measured in this frame; hits: number of detections taken; area, box_w,
box_h: of the last detection [px]; score: 0..1, existence confidence.
"""

TENTATIVE, CONFIRMED, COASTING = 0, 1, 2


@dataclass(frozen=True)
class Frame:
    """A picture and when it was taken.

    :param image: uint8, (H, W, channels), or (H, W) for mono8; rows may be padded (a strided view).
    :param encoding: a key of ENCODINGS.
    :param stamp: time of the exposure [ns].
    :param frame_id: the camera's coordinate frame.
    """

    image: NDArray[np.uint8]
    encoding: str = 'bgr8'
    stamp: int = 0
    frame_id: str = ''


@dataclass(frozen=True)
class Detections:
    """The blobs of one frame, largest area first.

    :param rows: (N,) of dtype DETECTION.
    :param stamp: of the frame [ns].
    :param frame_id: of the frame.
    """

    rows: NDArray[np.void] = field(default_factory=lambda: np.zeros(0, DETECTION))
    stamp: int = 0
    frame_id: str = ''


@dataclass(frozen=True)
class Tracks:
    """The live tracks after one frame, ascending track_id.

    :param rows: (N,) of dtype TRACK.
    :param stamp: of the frame [ns].
    :param frame_id: of the frame.
    :param restarted: why the tracker started afresh with this frame, dropping every earlier
        track; empty when it did not.
    :param outlines: (N, P, 2) points u, v along the closed outline of each track [px]; (0, 0, 2)
        from trackers that know none.
    """

    rows: NDArray[np.void] = field(default_factory=lambda: np.zeros(0, TRACK))
    stamp: int = 0
    frame_id: str = ''
    restarted: str = ''
    outlines: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 0, 2)))


def time_passed(last: int | None, stamp: int, max_dt: float) -> tuple[float, str]:
    """Tell how a tracker goes from one frame to the next.

    :param last: stamp of the last frame [ns], None before the first.
    :param stamp: of the next frame [ns].
    :param max_dt: a longer jump starts afresh [s].
    :return: dt [s], 0 for a first frame; and why to start afresh, empty if not.
    """
    dt = 0.0 if last is None else (stamp - last) / NANOSECONDS
    if dt < 0:
        return 0.0, f'the stamp went back by {-dt:.6f} s'
    if dt > max_dt:
        return 0.0, f'the stamp jumped ahead by {dt:.6f} s, max_dt is {max_dt:g} s'
    return dt, ''
