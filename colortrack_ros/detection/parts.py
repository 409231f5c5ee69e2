"""Detections of several objects in one blob."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.columns import whole_rows
from colortrack_ros.data import Bools
from colortrack_ros.data import DETECTION
from colortrack_ros.data import Floats
from colortrack_ros.detection.templates import BlobTemplate
from colortrack_ros.detection.templates import Fit

LEAST_VISIBLE = 0.1
"""Least visible share of an object for its place to be known. Assumed."""

MOST_UNEXPLAINED = 0.15
"""Largest share of a blob that its fitted objects may leave unexplained, plus one pixel along the
side of a square of its area, for the outline. Assumed."""

FIT_ERROR, SHAPE_ERROR = 0.2, 0.01
"""Standard deviations of a fitted center, per axis: [squares of the fit], and [side of a square of
its area over the visible share]. For rendered balls of 6 to 54 px, visible by a tenth or
completely, it was 0.10 to 0.53 px; objects that turn look less alike."""


def seen_of(fit: Fit, templates: list[BlobTemplate], area: int) -> tuple[Floats, Bools]:
    """(K,) visible share of each object, and whether that is enough to locate it.

    It is not enough for any if the objects do not explain the blob.

    :param area: of the blob [px].
    """
    areas = np.array([template.area for template in templates])
    outline = np.sqrt(area)
    share = np.minimum(fit.visible / areas, 1.0)
    visible = fit.visible >= np.maximum(LEAST_VISIBLE * areas, outline)
    return share, visible & (fit.unexplained <= MOST_UNEXPLAINED * area + outline)


def rows_of(
    row: NDArray[np.void], fit: Fit, templates: list[BlobTemplate], visible: Bools
) -> NDArray[np.void]:
    """Rows of the visible objects in one blob, with row (1,): at their places, as large as alone.

    If none is visible, the blob's row remains, and each object may be anywhere inside it.
    """
    if not visible.any():
        return inside(row, templates)
    rows = whole_rows(row).repeat(visible.sum()).view(DETECTION)
    for new, i in zip(rows, visible.nonzero()[0].tolist(), strict=True):
        template, center = templates[i], fit.center[i]
        new['u'], new['v'] = center
        unlike = SHAPE_ERROR * template.side * template.area / max(fit.visible[i], 1.0)
        covariance = template.covariance + np.eye(2) * ((FIT_ERROR * fit.step) ** 2 + unlike**2)
        new['cov_uu'], new['cov_uv'], _, new['cov_vv'] = covariance.reshape(4)
        new['area'] = template.area
        new['box_u'], new['box_v'] = center + template.box[:2]
        new['box_w'], new['box_h'] = template.box[2:]
    return rows


def inside(row: NDArray[np.void], templates: list[BlobTemplate]) -> NDArray[np.void]:
    """The row of a blob, (1,), with inseparable objects, each anywhere inside its box.

    The distribution is uniform: the variance per axis is a twelfth of the square of the free space.
    """
    least = np.min([template.box[2:] for template in templates], axis=0)
    row = row.copy()
    for axis, name in enumerate(('u', 'v')):
        room = max(float(row[f'box_{"wh"[axis]}'][0] - least[axis]), 0.0)
        row[f'cov_{name}{name}'] += room**2 / 12
    return row


def replaced(rows: NDArray[np.void], parts: dict[int, NDArray[np.void]]) -> NDArray[np.void]:
    """Replace some rows by others, largest area first."""
    kept = np.delete(whole_rows(rows), list(parts))
    together = np.concatenate([kept, *map(whole_rows, parts.values())])
    return together[np.argsort(-together.view(DETECTION)['area'], kind='stable')].view(DETECTION)
