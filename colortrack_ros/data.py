"""The data that rooms exchange: Frame, Detections, Tracks, Locations.

Pixel coordinates are (u, v): u to the right, v down, the center of the top left pixel is (0, 0).
Times are integer nanoseconds, so the same stamps give bit-identical results.

The rows of Detections, Tracks and Locations have the memory layout of the point clouds that carry
them (little-endian, fixed offsets), so a message takes a single copy of the array's bytes.
"""

from dataclasses import dataclass
from dataclasses import field
import reprlib
from typing import Any
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from numpy.typing import NDArray

from colortrack_ros.given import given_for_each
from colortrack_ros.given import given_size
from colortrack_ros.given import given_table

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
area: number of pixels, m00, of small things what an erosion leaves; box_u, box_v, box_w, box_h:
bounding box, top left corner and size [px]; score: 0..1, 1 when every pixel is exactly the
reference color; color: index into the detector's colors.
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

    @classmethod
    def from_points(
        cls,
        points: ArrayLike,
        stamp: int = 0,
        *,
        sigma: ArrayLike = 0.0,
        scores: ArrayLike = 1.0,
        colors: ArrayLike = 0,
        image_size: tuple[int, int] = (0, 0),
    ) -> 'Detections':
        """Points that a detector of your own has found.

        :param points: (N, 2) u, v [px].
        :param stamp: of the frame [ns].
        :param sigma: standard deviation on each axis, of all or (N,) of each [px]; 0 if unknown,
            and the tracker learns it.
        :param scores: 0..1, of all or (N,) of each.
        :param colors: classes, from 0, of all or (N,) of each; objects keep theirs.
        :param image_size: width and height of the picture [px]; 0 if unknown.
        :raises ValueError: an array has another shape, or values that make no sense.
        """
        z = given_table(points, 'points', ('u', 'v'))
        rows = np.zeros(len(z), DETECTION)
        rows['u'], rows['v'] = z.T
        rows['cov_uu'] = rows['cov_vv'] = given_for_each(sigma, 'sigma', len(z)) ** 2
        rows['score'] = given_for_each(scores, 'scores', len(z))
        given = given_for_each(colors, 'colors', len(z))
        if not np.all((given == np.floor(given)) & (given < 1 << 32)):
            shown = reprlib.repr(colors)
            raise ValueError(f'colors: expected whole numbers below 2^32, got {shown}')
        rows['color'] = given
        return cls(rows, stamp, image_size=given_size(image_size))

    @classmethod
    def from_boxes(
        cls,
        boxes: ArrayLike,
        stamp: int = 0,
        *,
        scores: ArrayLike = 1.0,
        colors: ArrayLike = 0,
        image_size: tuple[int, int] = (0, 0),
    ) -> 'Detections':
        """Boxes that a network has found.

        :param boxes: (N, 4) left, top, right, bottom edge [px], counted from the edge of the
            picture, as networks do: its first pixel is from 0 to 1.
        :param stamp, scores, colors, image_size: see from_points().
        :raises ValueError: an array has another shape, or these are no edges in pixels.
        """
        edges = given_table(boxes, 'boxes', ('left', 'top', 'right', 'bottom'))
        corner, size = edges[:, :2], edges[:, 2:] - edges[:, :2]
        if np.any(size < 0):
            raise ValueError(
                'boxes: expected left, top, right, bottom, got a right edge left of '
                'the left one, or a bottom above the top: is it width and height?'
            )
        if len(edges) and edges.max() <= 1:
            raise ValueError(
                'boxes: expected pixels, got 0..1: multiply by width and height of the picture'
            )
        center = corner + (size - 1) / 2
        found = cls.from_points(center, stamp, scores=scores, colors=colors, image_size=image_size)
        sides = found.rows.view(DETECTION_BOX)
        sides['corner'], sides['size'] = corner, size
        found.rows['area'] = np.pi / 4 * size.prod(axis=1)
        return found


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
