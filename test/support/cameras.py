"""Pictures as cameras of every kind encode them, written out from the definitions."""

import numpy as np

from colortrack_ros.data import Frame

LUMA, BLUE, RED = np.array([0.299, 0.587, 0.114]), 1.772, 1.402
"""ITU-R BT.601: Y of R, G, B; B - Y and R - Y at the ends of U and V."""

PATTERNS = {
    'bayer_rggb8': (0, 1, 1, 2), 'bayer_bggr8': (2, 1, 1, 0),
    'bayer_gbrg8': (1, 2, 0, 1), 'bayer_grbg8': (1, 0, 2, 1),
}  # fmt: skip
"""Channels, red 0 to blue 2, of the four pixels of a Bayer pattern in reading order."""


def yuv_of(rgb, *, full_range=False):
    """(..., 3) Y, U, V of (..., 3) red, green, blue, rounded."""
    luma = rgb @ LUMA
    chroma = np.stack([(rgb[..., 2] - luma) / BLUE, (rgb[..., 0] - luma) / RED], -1)
    if not full_range:
        luma, chroma = 16 + luma * 219 / 255, chroma * 224 / 255
    yuv = np.concatenate([luma[..., None], 128 + chroma], -1)
    return np.rint(yuv).clip(0, 255).astype(np.uint8)


def encode(bgr, encoding, *, full_range=False):
    """A frame of the picture (H, W, 3), height and width even."""
    rgb = bgr[..., ::-1].astype(float)
    height, width = rgb.shape[:2]
    if encoding in PATTERNS:
        image = np.empty((height, width), np.uint8)
        for k, channel in enumerate(PATTERNS[encoding]):
            image[k // 2 :: 2, k % 2 :: 2] = rgb[k // 2 :: 2, k % 2 :: 2, channel]
    elif encoding in ('yuyv', 'uyvy'):
        yuv = yuv_of(rgb, full_range=full_range)
        pairs = rgb.reshape(height, width // 2, 2, 3).mean(axis=2)
        chroma = yuv_of(pairs, full_range=full_range)[..., 1:].reshape(height, width)
        image = np.stack([yuv[..., 0], chroma][:: 1 if encoding == 'yuyv' else -1], axis=-1)
    elif encoding in ('nv12', 'nv21'):
        yuv = yuv_of(rgb, full_range=full_range)
        fours = rgb.reshape(height // 2, 2, width // 2, 2, 3).mean(axis=(1, 3))
        chroma = yuv_of(fours, full_range=full_range)[..., 1:][
            ..., :: 1 if encoding == 'nv12' else -1
        ]
        image = np.concatenate([yuv[..., 0], chroma.reshape(height // 2, width)])
    else:
        order = {'bgr8': (2, 1, 0), 'rgb8': (0, 1, 2), 'bgra8': (2, 1, 0, 0), 'rgba8': (0, 1, 2, 0)}
        image = np.rint(rgb @ LUMA) if encoding == 'mono8' else rgb[..., order[encoding]]
    return Frame(np.ascontiguousarray(image, np.uint8), encoding, full_range=full_range)
