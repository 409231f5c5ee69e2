"""Placing of a contour's nodes along an outline."""

import numpy as np

from colortrack_ros.contours.spline import SEGMENT_POINTS
from colortrack_ros.contours.spline import Spline
from colortrack_ros.data import Floats

PHASES = 8
"""Number of starting points that are tried for equally spaced nodes. Assumed; see FIRST_STEP."""

MAX_ROUNDS = 40
"""Most moves of nodes, to bound the time of what takes longest in a frame. With half of them the
IDF1 of the real clip `onebyone` falls from 0.98 to 0.89 (``benchmark/real_contours.py``)."""

FIRST_STEP, LAST_STEP, LEAST_SPACING = 0.4, 0.02, 0.25
"""First and last step of a move, and least distance of nodes, in units of their spacing. Half and
twice these values, and those of PHASES and MAX_ROUNDS, change the mean squared error by 0.01 px^2
at most on `silhouette` and `approach` (``benchmark/contours.py --constants placing.PHASES
placing.MAX_ROUNDS ...``)."""

CENTROID_WEIGHT = 4.0
"""Weight of the centroid's error relative to the curve's: the centroid is what is published. Half
and twice the value make the mean squared errors of `silhouette` and `approach` 0.021 and 0.048
instead of 0.064 px^2, 0.031 and 0.020 instead of 0.023 (``benchmark/contours.py --constants
placing.CENTROID_WEIGHT``)."""

TIE = 1e-9
"""Costs with a smaller relative difference are equal. On symmetrical outlines, the last digit,
which libraries round differently, would otherwise choose between two solutions."""


def equally_spaced(points: Floats, spline: Spline) -> Floats:
    """Return nodes, (n, 2) [px], equally spaced along an outline, with a positive area.

    :param points: (P, 2) of a closed polygon [px], in either sense.
    """
    return _Outline(points, spline).nodes(np.arange(spline.count) / spline.count)


def along_outline(points: Floats, spline: Spline) -> tuple[Floats, float]:
    """Return nodes, (n, 2) [px], on an outline, such that the curve follows it as well as possible.

    They start equally spaced, and are then moved along the outline, one at a time, as long as that
    reduces the squared distances of curve and centroid.

    :param points: (P, 2) of a closed polygon [px], in either sense.
    :return: nodes in the sense from u to v, which makes the area positive, and the RMS distance of
        the curve from the outline [px].
    """
    outline, n = _Outline(points, spline), spline.count
    tried = np.arange(n) / n + np.arange(PHASES)[:, None] / PHASES / n
    cost = outline.cost(tried)
    place, least, step = tried[_first_least(cost)], cost.min(), FIRST_STEP
    for _ in range(MAX_ROUNDS):
        tried = place + np.concatenate([np.eye(n), -np.eye(n)]) * step / n
        gap = np.diff(np.concatenate([tried, tried[:, :1] + 1], axis=1), axis=1)
        cost = np.where(gap.min(axis=1) < LEAST_SPACING / n, np.inf, outline.cost(tried))
        if cost.min() < least * (1 - TIE):
            place, least = tried[_first_least(cost)], cost.min()
        elif step < LAST_STEP:
            break
        else:
            step /= 2
    nodes = outline.nodes(place)
    misfit = np.sqrt(outline.squared_distance(place[None], nodes[None])[0])
    return nodes, float(misfit)


def _first_least(cost: Floats) -> int:
    """Return the index of the least cost, the first of ties."""
    return int(np.argmax(cost <= cost.min() * (1 + TIE)))


class _Outline:
    """A closed polygon; places on it are fractions of its length, modulo 1."""

    def __init__(self, points: Floats, spline: Spline) -> None:
        after = np.roll(points, -1, axis=0)
        cross = points[:, 0] * after[:, 1] - points[:, 1] * after[:, 0]
        twice = cross.sum()
        arm = ((points + after) * cross[:, None]).sum(axis=0)
        self._center = arm / (3 * twice) if twice else points.mean(axis=0)
        points = points if twice >= 0 else points[::-1]
        points = np.concatenate([points, points[:1]])
        self._points = points[:, 0] + 1j * points[:, 1]  # both coordinates in one search
        way = np.linalg.norm(np.diff(points, axis=0), axis=1)
        self._way = np.concatenate([[0.0], np.cumsum(way)])
        self._spline = spline

    def nodes(self, place: Floats) -> Floats:
        """Return points, (..., 2), at places, (...)."""
        found = np.interp((place % 1.0) * self._way[-1], self._way, self._points)
        return np.stack([found.real, found.imag], axis=-1)

    def cost(self, place: Floats) -> Floats:
        """Return the cost, (K,), of curves through nodes at places (K, n): distance and
        centroid.
        """
        nodes = self.nodes(place)
        off = np.square(self._spline.center(nodes) - self._center).sum(axis=1)
        far = self.squared_distance(place, nodes)
        return far + CENTROID_WEIGHT * np.where(np.isnan(off), np.inf, off)

    def squared_distance(self, place: Floats, nodes: Floats) -> Floats:
        """Return the mean squared distance, (K,) [px^2], of curves through nodes at places (K, n).

        A node is the middle of its segment; the curve between two nodes is compared with the
        outline between their places.
        """
        t = (np.arange(SEGMENT_POINTS) + 0.5) / SEGMENT_POINTS - 0.5
        before = np.concatenate([place[:, -1:] - 1, place[:, :-1]], axis=1)
        after = np.concatenate([place[:, 1:], place[:, :1] + 1], axis=1)
        side = np.where(t < 0, (place - before)[..., None], (after - place)[..., None])
        wanted = self.nodes((place[..., None] + t * side).reshape(len(place), -1))
        curve = self._spline.outline(nodes)
        return np.asarray(np.square(curve - wanted).sum(axis=2).mean(axis=1))
