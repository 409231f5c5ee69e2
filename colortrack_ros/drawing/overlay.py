"""Tracks drawn onto a picture.

Everything is a polyline with subpixel coordinates, computed in arrays.
"""

from collections.abc import Sequence
import colorsys

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import COASTING
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import TRACK_BOX
from colortrack_ros.data import Tracks
from colortrack_ros.drawing.trails import TRAIL_LENGTH
from colortrack_ros.drawing.trails import Trails
from colortrack_ros.ellipses import outlines

FRACTION_BITS = 4
"""Fractional bits of the coordinates that OpenCV draws (up to 16): 1/16 px is finer than its
antialiasing."""

DRAW_LIMIT = 20_000.0
"""Coordinates are clipped to this [px]: it is beyond any picture, and 2^4 times it fits OpenCV's
32-bit coordinates."""

FADE_STEPS = 10
"""Steps in which a trail fades, one polyline of five positions each. Chosen: the steps are hardly
visible."""

TENTATIVE_GRAY = (170, 170, 170)
"""Visible on a dark and on a light picture."""

GOLDEN_RATIO = 0.61803398875
"""Step of the hue between consecutive IDs [turns], (sqrt(5) - 1) / 2: hues of nearby IDs differ
clearly."""

LUMA = (0.114, 0.587, 0.299)
"""Weights of blue, green and red in the luma (ITU-R BT.601)."""

_CORNERS = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)])

BGR = tuple[int, int, int]


def draw_tracks(image: NDArray[np.uint8], tracks: Tracks, trails: Trails | None = None) -> None:
    """Draw trail, 95 % covariance ellipse, box or outline, and ID of each track, in place.

    Each confirmed track has its own color, coasting ones are dashed, and tentative ones are thin,
    gray, and without an ID.

    :param image: (H, W, 3) BGR, contiguous, writable.
    :param tracks: rows without NaN; an outline of NaN is not drawn.
    :param trails: updated with these tracks; None draws none.
    """
    rows = tracks.rows
    if len(rows) == 0:
        return
    scale = image.shape[0] / 720
    thickness = max(1, round(2 * scale))
    colors = [
        TENTATIVE_GRAY if row['state'] == TENTATIVE else track_color(int(row['track_id']))
        for row in rows
    ]
    if trails:
        of_id = dict(zip(rows['track_id'].tolist(), colors, strict=True))
        _draw_trails(image, trails, of_id, scale)
    shapes = list(_boxes(rows))
    for i, outline in enumerate(tracks.outlines):
        if np.isfinite(outline).all():
            shapes[i] = np.concatenate([outline, outline[:1]])
    ellipses = outlines(_centers(rows), rows['covariance'][:, :2, :2], 65)
    for row, box, ellipse, color in zip(rows, shapes, ellipses, colors, strict=True):
        width = 1 if row['state'] == TENTATIVE else thickness
        if row['state'] == COASTING:
            box, ellipse = _dashed(box, max(12, len(box) // 2)), _dashed(ellipse, 32)
        else:
            box, ellipse = box[None], ellipse[None]
        cv2.polylines(image, _fixed(ellipse), False, color, 1, cv2.LINE_AA, FRACTION_BITS)
        cv2.polylines(image, _fixed(box), False, color, width, cv2.LINE_AA, FRACTION_BITS)
        if row['state'] != TENTATIVE:
            _draw_label(image, str(row['track_id']), row, color, scale)


def track_color(track_id: int) -> BGR:
    """The color of a track: bright, constant over time, and unlike that of neighboring IDs."""
    hue = track_id * GOLDEN_RATIO % 1
    saturation = (0.75, 0.5, 0.95)[track_id % 3]
    red, green, blue = colorsys.hsv_to_rgb(hue, saturation, 1.0)
    return round(255 * blue), round(255 * green), round(255 * red)


def _boxes(rows: NDArray[np.void]) -> NDArray[np.float64]:
    """Return (N, 5, 2), the closed outlines of the boxes."""
    box = rows.view(TRACK_BOX)
    corner, size = box['corner'].astype(float), box['size'].astype(float)
    return corner[:, None] - 0.5 + _CORNERS * size[:, None]


def _centers(rows: NDArray[np.void]) -> NDArray[np.float64]:
    return np.stack([rows['u'], rows['v']], axis=1)


def _dashed(outline: NDArray[np.float64], dashes: int) -> NDArray[np.float64]:
    """Dashes of an outline (n, 2), all of equal length, (dashes, 2, 2)."""
    corners = np.linspace(0, 1, len(outline))
    ends = np.linspace(0, 1, 2 * dashes + 1)
    points = np.stack([np.interp(ends, corners, column) for column in outline.T], axis=1)
    return np.stack([points[:-1:2], points[1::2]], axis=1)


def _fixed(points: NDArray[np.float64]) -> Sequence[NDArray[np.int32]]:
    """Return points (m, n, 2) [px] as OpenCV draws them."""
    return list(
        np.rint(np.clip(points, -DRAW_LIMIT, DRAW_LIMIT) * (1 << FRACTION_BITS)).astype(np.int32)
    )


def _draw_trails(
    image: NDArray[np.uint8], trails: Trails, colors: dict[int, BGR], scale: float
) -> None:
    """Blend the trails into the picture; older parts are fainter."""
    painted, opacity = image.copy(), np.zeros(image.shape[:2], np.uint8)
    width = max(1, round(2.5 * scale))
    for track_id, points in zip(trails.ids.tolist(), trails.points, strict=True):
        begin = int(np.isnan(points[:, 0]).sum())
        for step in range(FADE_STEPS):
            start, stop = (TRAIL_LENGTH * s // FADE_STEPS for s in (step, step + 1))
            piece = _fixed(points[None, max(start - 1, begin) : stop])
            if piece[0].shape[0] > 1:
                faint = 255 * (step + 1) // FADE_STEPS
                cv2.polylines(
                    painted, piece, False, colors[track_id], width, cv2.LINE_AA, FRACTION_BITS
                )
                cv2.polylines(opacity, piece, False, faint, width, cv2.LINE_AA, FRACTION_BITS)
    v, u = np.nonzero(opacity)
    weight = opacity[v, u, None].astype(np.int32)
    mixed = image[v, u] * (255 - weight) + painted[v, u] * weight
    image[v, u] = mixed // 255


def _draw_label(
    image: NDArray[np.uint8], text: str, row: np.void, color: BGR, scale: float
) -> None:
    """Write the text on a plate above the box, but inside the picture; nothing for a box outside
    it.
    """
    height, width = image.shape[:2]
    left, top = row['box_u'] - 0.5, row['box_v'] - 0.5
    if not (-row['box_w'] < left < width and -row['box_h'] < top < height):
        return
    size, stroke, margin = max(0.4, 0.6 * scale), max(1, round(1.6 * scale)), round(3 * scale) + 1
    (w, h), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, size, stroke)
    x = int(np.clip(left, 0, max(0, width - w - 2 * margin)))
    y = int(np.clip(top - margin, h + 2 * margin, height))
    cv2.rectangle(image, (x, y - h - 2 * margin), (x + w + 2 * margin, y), color, cv2.FILLED)
    place = (x + margin, y - margin)
    ink = (0, 0, 0) if np.dot(color, LUMA) > 90 else (255, 255, 255)
    cv2.putText(image, text, place, cv2.FONT_HERSHEY_SIMPLEX, size, ink, stroke, cv2.LINE_AA)
