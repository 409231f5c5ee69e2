"""Tracks -> visualization_msgs/MarkerArray."""

import math

from geometry_msgs.msg import Point
from geometry_msgs.msg import Quaternion
from geometry_msgs.msg import Vector3
import numpy as np
from numpy.typing import NDArray
from std_msgs.msg import ColorRGBA
from std_msgs.msg import Header
from visualization_msgs.msg import Marker
from visualization_msgs.msg import MarkerArray

from colortrack_ros.data import COASTING
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import Tracks
from colortrack_ros.messages.header import header_of

ELLIPSE, VELOCITY, LABEL, OUTLINE = 'ellipse', 'velocity', 'id', 'outline'
"""Namespaces of the markers, one for each kind."""

ELLIPSE_SIGMAS = 2.0
"""Half axes of the ellipse, in standard deviations; 2 by the contract of the topic."""


class MarkerWriter:
    """Markers of the confirmed and coasting tracks, and the removal of those that have gone.

    Pixels become meters by ``scale``: x = scale * u, y = scale * v, z = 0 in the camera's frame.
    """

    def __init__(self) -> None:
        self._shown: set[int] = set()
        self._outlining = False  # of this tracker's tracks

    def write(self, tracks: Tracks, scale: float) -> MarkerArray:
        """One ellipse, one arrow and one text for each track, and its outline where it has one.

        :param tracks: after a frame; a track that was written before and is absent is deleted.
        :param scale: m/px.
        """
        header = header_of(tracks.stamp, tracks.frame_id)
        markers = []
        if tracks.restarted:
            markers.append(Marker(header=header, action=Marker.DELETEALL))
            self._shown.clear()
        seen = tracks.rows['state'] != TENTATIVE
        rows = tracks.rows[seen]
        known = len(tracks.outlines) > 0
        outlines = list(tracks.outlines[seen]) if known else [None] * len(rows)
        self._outlining |= tracks.outlines.size > 0
        shown = set(rows['track_id'].tolist())
        for gone in sorted(self._shown - shown):
            spaces = (ELLIPSE, VELOCITY, LABEL, OUTLINE)[: 3 + self._outlining]
            markers += [
                Marker(header=header, ns=ns, id=gone, action=Marker.DELETE) for ns in spaces
            ]
        self._shown = shown
        for row, outline in zip(rows, outlines, strict=True):
            markers += _markers(header, row, outline, scale)
        return MarkerArray(markers=markers)


def _markers(
    header: Header, row: np.void, outline: NDArray[np.float64] | None, scale: float
) -> list[Marker]:
    position = Point(x=float(row['u']) * scale, y=float(row['v']) * scale)
    ahead = Point(x=position.x + float(row['du']) * scale, y=position.y + float(row['dv']) * scale)
    angle, major, minor = _ellipse(row['covariance'][:2, :2])
    color = ColorRGBA(r=0.1, g=0.8, b=0.2, a=0.8)
    if row['state'] == COASTING:
        color = ColorRGBA(r=0.9, g=0.7, b=0.1, a=0.5)
    size = max(float(row['box_h']) * scale, 1e-6)

    def marker(ns: str, kind: int, scale_of: Vector3) -> Marker:
        return Marker(
            header=header, ns=ns, id=int(row['track_id']), type=kind, scale=scale_of, color=color
        )

    ellipse = marker(
        ELLIPSE,
        Marker.CYLINDER,
        Vector3(
            x=2 * ELLIPSE_SIGMAS * major * scale,
            y=2 * ELLIPSE_SIGMAS * minor * scale,
            z=0.01 * size,
        ),
    )
    ellipse.pose.position = position
    ellipse.pose.orientation = Quaternion(z=math.sin(angle / 2), w=math.cos(angle / 2))
    arrow = marker(VELOCITY, Marker.ARROW, Vector3(x=0.05 * size, y=0.1 * size, z=0.0))
    arrow.points = [position, ahead]
    label = marker(LABEL, Marker.TEXT_VIEW_FACING, Vector3(z=0.5 * size))
    label.pose.position = Point(x=position.x, y=position.y - 0.75 * size)
    label.text = str(int(row['track_id']))
    if outline is None:
        return [ellipse, arrow, label]
    strip = marker(OUTLINE, Marker.LINE_STRIP, Vector3(x=0.02 * size))
    closed = np.concatenate([outline, outline[:1]]) * scale
    strip.points = [Point(x=x, y=y) for x, y in closed.tolist()]
    return [ellipse, arrow, label, strip]


def _ellipse(covariance: NDArray[np.float64]) -> tuple[float, float, float]:
    """Angle [rad] of the major axis, and the standard deviations along both axes [px]."""
    values, vectors = np.linalg.eigh(covariance)
    minor, major = np.sqrt(np.maximum(values, 0.0))
    return math.atan2(vectors[1, 1], vectors[0, 1]), float(major), float(minor)
