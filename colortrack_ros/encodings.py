"""Converts camera encodings, YUV and Bayer, to RGB."""

from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import ENCODINGS
from colortrack_ros.data import Frame
from colortrack_ros.stamps import require_stamp


class Layout(NamedTuple):
    """The memory layout of an encoding.

    :param channels: bytes per pixel in a row.
    :param even: required divisors of width and height, if pixels share their chroma.
    :param has_chroma_plane: whether a chroma plane with half as many rows follows the luma plane.
    """

    channels: int
    even: tuple[int, int] = (1, 1)
    has_chroma_plane: bool = False

    def rows(self, height: int) -> int:
        """Number of byte rows in a picture."""
        return height * 3 // 2 if self.has_chroma_plane else height

    def shape(self, height: int, width: int) -> tuple[int, ...]:
        """Shape of the array that holds a picture."""
        shape = self.rows(height), width
        return shape if self.channels == 1 else (*shape, self.channels)


YUV422 = {'yuyv': cv2.COLOR_YUV2BGR_YUY2, 'uyvy': cv2.COLOR_YUV2BGR_UYVY}
YUV420 = {'nv12': cv2.COLOR_YUV2BGR_NV12, 'nv21': cv2.COLOR_YUV2BGR_NV21}
YUV = {**YUV422, **YUV420}
BAYER = {
    # OpenCV names a pattern after the second and third pixel of the second row.
    'bayer_rggb8': cv2.COLOR_BayerBG2BGR,
    'bayer_bggr8': cv2.COLOR_BayerRG2BGR,
    'bayer_gbrg8': cv2.COLOR_BayerGR2BGR,
    'bayer_grbg8': cv2.COLOR_BayerGB2BGR,
}

LAYOUTS = {
    **{name: Layout(channels) for name, channels in ENCODINGS.items()},
    **dict.fromkeys(YUV422, Layout(2, (2, 1))),
    **dict.fromkeys(YUV420, Layout(1, (2, 2), has_chroma_plane=True)),
    **dict.fromkeys(BAYER, Layout(1)),
}
"""All encodings that a frame can have."""

_TO_BGR = {
    'rgb8': cv2.COLOR_RGB2BGR,
    'bgra8': cv2.COLOR_BGRA2BGR,
    'rgba8': cv2.COLOR_RGBA2BGR,
    'mono8': cv2.COLOR_GRAY2BGR,
    **YUV422,
    **YUV420,
    **BAYER,
}


def size_of(frame: Frame) -> tuple[int, int]:
    """Height and width of a frame's picture [px]."""
    rows, width = frame.image.shape[:2]
    return (rows * 2 // 3 if LAYOUTS[frame.encoding].has_chroma_plane else rows), width


def check(frame: Frame) -> None:
    """Raise ValueError if a frame's encoding is unknown or does not match its picture, or if this
    is no frame, no picture, or no stamp.
    """
    if not isinstance(frame, Frame):
        raise ValueError(
            f'expected a Frame, got {type(frame).__name__}; of a picture it is Frame(picture, '
            'stamp=nanoseconds)'
        )
    if not isinstance(frame.image, np.ndarray):
        why = '; cv2.imread gives it for a file that it cannot read' * (frame.image is None)
        raise ValueError(
            f'image: expected an array of uint8, got {type(frame.image).__name__}{why}'
        )
    require_stamp(frame.stamp)
    if frame.encoding not in LAYOUTS:
        raise ValueError(f'encoding: expected one of {list(LAYOUTS)}, got {frame.encoding!r}')
    layout, shape = LAYOUTS[frame.encoding], frame.image.shape
    if not (shape[2:] == (layout.channels,) or (len(shape) == 2 and layout.channels == 1)):
        raise ValueError(
            f'image.shape: expected (height, width, {layout.channels}) for {frame.encoding}, '
            f'got {shape}'
        )
    (height, width), (wide, high) = size_of(frame), layout.even
    if shape[0] != layout.rows(height) or width % wide or height % high:
        raise ValueError(
            f'image.shape: expected {"3/2 times an even height" if high > 1 else "any height"} '
            f'and an even width for {frame.encoding}, got {shape}'
        )
    if frame.image.dtype != np.uint8:
        raise ValueError(f'image.dtype: expected uint8, got {frame.image.dtype}')


def plain(frame: Frame) -> Frame:
    """The frame in an encoding of ENCODINGS, with RGB or gray levels at each pixel.

    A frame that already has one is returned as it is. OpenCV does the conversion: YUV by ITU-R
    BT.601, Bayer patterns by bilinear interpolation.
    """
    if frame.encoding in ENCODINGS:
        return frame
    return replace(frame, image=_converted(frame), encoding='bgr8')


def writable_bgr(frame: Frame) -> NDArray[np.uint8]:
    """A copy of the frame's picture to draw on, (H, W, 3) BGR."""
    return frame.image.copy() if frame.encoding == 'bgr8' else _converted(frame)


def is_yuv(frame: Frame) -> bool:
    """Whether a frame has limited-range YUV, which :func:`to_bgr` converts."""
    return frame.encoding in YUV and not frame.full_range


def to_bgr(image: NDArray[np.uint8], encoding: str) -> NDArray[np.uint8]:
    """(H, W, 3) BGR of a nonempty picture; YUV must have limited range."""
    return np.asarray(cv2.cvtColor(image, _TO_BGR[encoding]), np.uint8)


def bgr_at(frame: Frame, row: NDArray[np.intp], column: NDArray[np.intp]) -> NDArray[np.uint8]:
    """(..., 3) single pixels of a limited-range YUV picture, converted as in :func:`plain`."""
    if not row.size:
        return np.zeros((*row.shape, 3), np.uint8)
    luma, u, v = yuv_planes(frame)
    shared = row // (len(luma) // len(u)), column // 2
    y = luma[row, column]
    pairs = np.stack([y, u[shared], y, v[shared]], axis=-1).reshape(1, -1, 2)
    return to_bgr(pairs, 'yuyv')[0, ::2].reshape(*row.shape, 3)


def _converted(frame: Frame) -> NDArray:
    if not frame.image.size:
        return np.zeros((*size_of(frame), 3), np.uint8)
    if frame.full_range and frame.encoding in YUV:
        return cv2.cvtColor(_full_chroma(frame), cv2.COLOR_YCrCb2BGR)
    return to_bgr(frame.image, frame.encoding)


def _full_chroma(frame: Frame) -> NDArray:
    """(H, W, 3) luma, red and blue chroma (Y, V, U) of each pixel of a YUV picture."""
    luma, u, v = yuv_planes(frame)
    height, width = luma.shape
    below, beside = height // len(u), width // u.shape[1]
    return np.dstack([luma, *(c.repeat(below, 0).repeat(beside, 1) for c in (v, u))])


def yuv_planes(frame: Frame) -> tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.uint8]]:
    """Luma, (H, W), and U and V, each shared by two or four pixels, of a YUV picture: views."""
    image, (height, width) = frame.image, size_of(frame)
    if frame.encoding in YUV422:
        luma, chroma = (0, 1) if frame.encoding == 'yuyv' else (1, 0)
        return image[..., luma], image[:, ::2, chroma], image[:, 1::2, chroma]
    u, v = (0, 1) if frame.encoding == 'nv12' else (1, 0)
    image = image.reshape(-1, width)
    return image[:height], image[height:, u::2], image[height:, v::2]
