"""Camera: projects points to pixels and pixels to rays, by K and D of CameraInfo.

The optical frame is that of REP-103: x right, y down, z forward. Pixels (u, v) are measured from
the center of the top left pixel.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.world.lens import Lens
from colortrack_ros.world.lens import LENSES
from colortrack_ros.world.lens import WIDEST

AT_BORDER = 32
"""Points on each side of the picture at which the field of view of the lens is evaluated.
Chosen."""


FARTHEST_ASIDE = 1.5
"""Farthest principal point from the middle of the picture, in widths and heights: one of a picture
cut from the corner of a larger one, with K of its own, is outside by as much at most. Assumed."""


class CalibrationError(ValueError):
    """A calibration is impossible for any camera, or missing."""


class SensorPart(Protocol):
    """sensor_msgs/RegionOfInterest."""

    x_offset: int
    y_offset: int
    width: int
    height: int


class Calibration(Protocol):
    """The fields of sensor_msgs/CameraInfo that the camera needs."""

    width: int
    height: int
    distortion_model: str
    d: Sequence[float]
    k: Sequence[float]
    p: Sequence[float]
    binning_x: int
    binning_y: int
    roi: SensorPart


@dataclass(frozen=True, eq=False)
class CameraModel:
    """A camera with a lens.

    :param K: (3, 3) camera matrix [px].
    :param lens: its distortion model.
    :param width, height: of the pictures [px].
    """

    K: Floats
    lens: Lens
    width: int
    height: int

    @classmethod
    def of(
        cls,
        width: int,
        height: int,
        k: ArrayLike,
        d: ArrayLike = (),
        distortion_model: str = 'plumb_bob',
    ) -> 'CameraModel':
        """Create the camera of a calibration.

        :param k: 9 numbers, the rows of the camera matrix.
        :param d: distortion coefficients, as many as the model takes; none: no distortion.
        :raises CalibrationError: the calibration is invalid; the message says why.
        """
        K: Floats = np.asarray(k, float).reshape(-1)
        D: Floats = np.asarray(d, float).reshape(-1)
        for name, values, count in (('K', K, 9), ('D', D, D.size)):
            if values.size != count or not np.isfinite(values).all():
                expected = f'{count} finite numbers'
                raise CalibrationError(
                    f'calibration with {name} {values.tolist()}: expected {expected}'
                )
        _refuse_impossible(K.reshape(3, 3), width, height)
        return cls(K.reshape(3, 3), _lens(distortion_model, D), width, height)

    @classmethod
    def of_info(cls, info: Calibration, rectified: bool = False) -> 'CameraModel':
        """Create the camera of a CameraInfo: K is of the full sensor, the picture may be a part.

        :param rectified: whether the pictures are rectified: P is their camera matrix, without
            distortion.
        :raises CalibrationError: see :meth:`of`.
        """
        if rectified:
            camera = cls.of(info.width, info.height, _rectified(info))
        else:
            camera = cls.of(info.width, info.height, info.k, info.d, info.distortion_model)
        roi = info.roi
        size = np.array([roi.width or info.width, roi.height or info.height])
        if roi.x_offset + size[0] > info.width or roi.y_offset + size[1] > info.height:
            raise CalibrationError(
                f'roi of {size[0]}x{size[1]} pixels at {roi.x_offset}, {roi.y_offset}: expected a '
                f'part of the {info.width}x{info.height} pixels that CameraInfo is of'
            )
        x, y = max(info.binning_x, 1), max(info.binning_y, 1)
        part = np.diag([1 / x, 1 / y, 1.0])
        # the center of a binned pixel is midway between those of its first and last
        part[:2, 2] = [-(roi.x_offset + (x - 1) / 2) / x, -(roi.y_offset + (y - 1) / 2) / y]
        width, height = -(-size // [x, y])
        return cls(part @ camera.K, camera.lens, int(width), int(height))

    def project(self, points: Floats) -> Floats:
        """Project points to pixels.

        :param points: (N, 3) in the optical frame [m].
        :return: (N, 2), inside the picture or outside; NaN for points that the lens does not see.
        """
        return self.linearized(points)[0]

    def linearized(self, points: Floats) -> tuple[Floats, Floats]:
        """Project as :meth:`project`, and return the Jacobian of pixels by points, (N, 2, 3)."""
        seen, J = self.lens.distort(points)
        return seen @ self.K[:2, :2].T + self.K[:2, 2], self.K[:2, :2] @ J

    def rays(self, pixels: Floats) -> Floats:
        """Return the rays of pixels.

        :param pixels: (N, 2) u, v.
        :return: (N, 3) unit vectors in the optical frame; NaN where the lens shows nothing.
        """
        return self.lens.undistort(self.flat(pixels))

    @cached_property
    def reach(self) -> float:
        """Radius from the center that the picture covers and the lens sees [focal lengths]."""
        share = np.linspace(0, 1, AT_BORDER)
        along, zero = np.concatenate([share, share]), np.repeat([0.0, 1.0], AT_BORDER)
        border = np.concatenate([np.stack([along, zero], 1), np.stack([zero, along], 1)])
        flat = self.flat(border * [self.width, self.height])
        radius = np.hypot(flat[:, 0], flat[:, 1])
        seen = np.isfinite(self.lens.undistort(flat)).all(axis=1)
        return float(radius[seen].max()) if seen.any() else float(radius.min()) / 2

    def flat(self, pixels: Floats) -> Floats:
        """Map pixels, (N, 2), to the image plane of the lens [focal lengths]."""
        (fx, skew), fy = self.K[0, :2], self.K[1, 1]
        y = (pixels[:, 1] - self.K[1, 2]) / fy
        x = (pixels[:, 0] - self.K[0, 2] - skew * y) / fx
        return np.stack([x, y], axis=1)

    def unproject(self, pixels: Floats, depth: Floats) -> Floats:
        """Return the points at a depth, as measured by depth cameras.

        :param pixels: (N, 2); depth: (N,) along the optical axis, z [m].
        :return: (N, 3) in the optical frame.
        """
        rays = self.rays(pixels)
        return np.asarray(rays * (depth / rays[:, 2])[:, None])

    def contains(self, pixels: Floats) -> Bools:
        """Whether pixels, (N, 2), are inside the picture."""
        inside = (pixels >= -0.5) & (pixels < [self.width - 0.5, self.height - 0.5])
        return np.asarray(inside[:, 0] & inside[:, 1])


def _refuse_impossible(K: Floats, width: int, height: int) -> None:
    """Refuse camera matrices, (3, 3), that no camera has with pictures of a size [px].

    :raises CalibrationError: the message says why.
    """
    if K[0, 0] <= 0 or K[1, 1] <= 0 or K[2].tolist() != [0, 0, 1] or K[1, 0] != 0:
        raise CalibrationError(
            f'calibration with K {K.ravel().tolist()}: expected [fx, s, cx, 0, fy, cy, 0, 0, '
            '1] with fx and fy above 0 (all zeros: the camera has not been calibrated)'
        )
    if width <= 0 or height <= 0:
        raise CalibrationError(f'calibration of {width}x{height} pixels: expected a picture')
    if max(width / K[0, 0], height / K[1, 1]) > 2 * WIDEST:
        raise CalibrationError(
            f'calibration with fx {K[0, 0]:g}, fy {K[1, 1]:g} px of {width}x{height} pixels: '
            f'expected focal lengths above {1 / (2 * WIDEST):g} of the picture (1: the camera '
            'has not been calibrated)'
        )
    aside = np.abs(K[:2, 2] / (width, height) - 0.5)
    if not K[:2, 2].any() or aside.max() > FARTHEST_ASIDE:
        raise CalibrationError(
            f'calibration with cx {K[0, 2]:g}, cy {K[1, 2]:g} px of {width}x{height} pixels: '
            'expected the principal point near the middle of the picture'
        )


def _rectified(info: Calibration) -> Floats:
    """Return the camera matrix of rectified pictures, (3, 3).

    :raises CalibrationError: it is that of the second camera of a pair, whose P is in the frame of
        the first.
    """
    P: Floats = np.asarray(info.p, float).reshape(3, 4)
    if P[:, 3].any():
        raise CalibrationError(
            f'rectified pictures with P {P.ravel().tolist()}, whose fourth column is not 0: '
            'expected those of the left camera of the pair, in whose frame P is'
        )
    return P[:, :3]


def _lens(model: str, D: Floats) -> Lens:
    """Return the lens of a distortion model and its coefficients."""
    if not D.any() and (not model or model == 'plumb_bob' or not D.size):
        return LENSES['plumb_bob'](D[:0]) if model != 'equidistant' else LENSES[model](np.zeros(4))
    kind = LENSES.get(model)
    if kind is None:
        raise CalibrationError(f'distortion_model {model!r}: expected one of {", ".join(LENSES)}')
    if D.size not in kind.counts:
        expected = ' or '.join(str(count) for count in kind.counts)
        raise CalibrationError(
            f'distortion_model {model} with {D.size} coefficients: expected {expected}'
        )
    if D[12:].any():
        raise CalibrationError(f'distortion_model {model}: the sensor is tilted; expected 0, 0')
    return kind(D)
