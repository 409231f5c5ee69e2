"""The detector as the textbook has it: every pixel in floating point, SciPy for the rest."""

import numpy as np
from scipy import ndimage

RED_GREEN_BLUE = {
    'bgr8': (2, 1, 0),
    'rgb8': (0, 1, 2),
    'bgra8': (2, 1, 0),
    'rgba8': (0, 1, 2),
    'mono8': (0, 0, 0),
}
D65 = np.array([0.950456, 1.0, 1.088754])
EIGHT = np.ones((3, 3))


def lab(rgb):
    """CIELAB of (..., 3) sRGB bytes, by the formulas of IEC 61966-2-1 and CIE 15."""
    v = rgb / 255.0
    linear = np.where(v > 0.04045, np.power((v + 0.055) / 1.055, 2.4), v / 12.92)
    matrix = np.array(
        [
            [0.412453, 0.357580, 0.180423],
            [0.212671, 0.715160, 0.072169],
            [0.019334, 0.119193, 0.950227],
        ]
    )
    t = np.einsum('ij,...j->...i', matrix, linear) / D65
    f = np.where(t > 216 / 24389, np.cbrt(t), (24389 / 27 * t + 16) / 116)
    return np.stack(
        [116 * f[..., 1] - 16, 500 * (f[..., 0] - f[..., 1]), 200 * (f[..., 1] - f[..., 2])], -1
    )


def rgb(frame):
    image = frame.image if frame.image.ndim == 3 else frame.image[..., None]
    return image[..., RED_GREEN_BLUE[frame.encoding]]


def distances(frame, colors):
    """(H, W, number of colors) of (2.1); of an ellipsoid, as if it were a sphere of tolerance."""
    difference = lab(rgb(frame))[..., None, :] - np.array([color.lab for color in colors])
    squares = [(difference[..., k, :] / color.axes) ** 2 for k, color in enumerate(colors)]
    return np.sqrt(np.sum(squares, axis=-1)).transpose(1, 2, 0) * [c.tolerance for c in colors]


def labels(frame, colors):
    """(2.2) for each color; the nearest of those in tolerance; 0 for none."""
    distance = distances(frame, colors)
    inside = distance < np.array([color.tolerance for color in colors])
    nearest = np.where(inside, distance, np.inf).argmin(axis=-1)
    return np.where(inside.any(axis=-1), nearest + 1, 0)


def is_decided(frame, colors, margin=1e-9):
    """Whether every pixel is far enough from each boundary for rounding not to matter."""
    distance = distances(frame, colors)
    tolerance = np.array([color.tolerance for color in colors])
    order = np.sort(distance, axis=-1)
    return (np.abs(distance - tolerance) > margin).all() and (
        np.diff(order, axis=-1) > margin
    ).all()


def blobs(mask, min_area=1, max_area=np.inf):
    """(area, u, v, left, top, width, height) of each 8-connected component, in raster order."""
    components, count = ndimage.label(mask, EIGHT)
    found = []
    for number in range(1, count + 1):
        v, u = np.nonzero(components == number)
        if min_area <= len(u) <= max_area:
            corner = (u.min(), v.min())
            size = (np.ptp(u) + 1, np.ptp(v) + 1)
            found.append((len(u), u.mean(), v.mean(), *corner, *size))
    return found


def erode(mask, size):
    """(2.4) with a square; what is outside of the picture does not erode."""
    return ndimage.binary_erosion(mask, np.ones((size, size)), border_value=1)


def open_(mask, size):
    """(2.6)."""
    return ndimage.binary_dilation(erode(mask, size), np.ones((size, size)))


def close(labels, count, size):
    """(2.7) of each color in turn, growing into what belongs to none."""
    element = np.ones((size, size))
    for label in range(1, count + 1):
        closed = erode(ndimage.binary_dilation(labels == label, element), size)
        labels[closed & (labels == 0)] = label
    return labels


def join(labels, inside):
    """Give each component the color of the largest larger one beside it that half of it is, too.

    :param labels: (H, W) the nearest color of those in tolerance.
    :param inside: (H, W, colors) which colors a pixel is in tolerance of.
    """
    parts = []
    for label in range(1, inside.shape[2] + 1):
        components, count = ndimage.label(labels == label, EIGHT)
        parts += [(label, components == number) for number in range(1, count + 1)]
    # Largest first; at equal area, in raster order of the first pixels.
    parts.sort(key=lambda part: (-part[1].sum(), np.flatnonzero(part[1])[0]))
    joined = labels.copy()
    final = []
    for label, part in parts:
        around = ndimage.binary_dilation(part, EIGHT)
        for k, (other, larger) in enumerate(parts[: len(final)]):
            if (around & larger).any() and inside[part, other - 1].mean() >= 0.5:
                label = final[k]
                break
        final.append(label)
        joined[part] = label
    return joined


def detect(frame, config):
    """The whole of Pegoretti 2021, 3.1.1: rows (area, u, v, left, top, w, h, color)."""
    inside = distances(frame, config.colors) < [color.tolerance for color in config.colors]
    labeled = join(labels(frame, config.colors), inside)
    labeled = close(labeled, len(config.colors), config.closing_size)
    found = []
    for color in range(len(config.colors)):
        mask = erode(labeled == color + 1, config.erosion_size)
        mask = open_(mask, config.opening_size)
        found += [(*row, color) for row in blobs(mask, config.min_area, config.max_area)]
    return sorted(found, key=lambda row: -row[0])
