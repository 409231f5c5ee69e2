"""Tracks -> visualization_msgs/MarkerArray, serialized."""

import numpy as np
from numpy.typing import NDArray
from visualization_msgs.msg import Marker

from colortrack_ros.data import COASTING
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import Tracks
from colortrack_ros.ellipses import ellipses
from colortrack_ros.messages.marker_cdr import array_of
from colortrack_ros.messages.marker_cdr import MarkerKind
from colortrack_ros.messages.marker_cdr import Rows
from colortrack_ros.messages.marker_cdr import rows_of

Header = tuple[int, int, bytes]

ELLIPSE, ARROW, LABEL, OUTLINE = b'ellipse', b'velocity', b'id', b'outline'
"""Namespaces of the markers, one for each kind."""

ELLIPSE_SIGMAS = 2.0
"""Half axes of the ellipse, in standard deviations; the contract of the topic says 2."""

MEASURED_COLOR, COASTING_COLOR = (0.1, 0.8, 0.2, 0.8), (0.9, 0.7, 0.1, 0.5)
"""Colors of measured tracks and of coasting ones."""


class MarkerWriter:
    """Makes markers of confirmed and coasting tracks, and deletes those of tracks that are gone.

    Pixels become meters by ``scale``: x = scale * u, y = scale * v, z = 0 in the camera's frame.
    The first message deletes all: a tracker that was killed has left its markers.
    """

    def __init__(self) -> None:
        self._shown: set[int] = set()
        self._outlining = False  # of this tracker's tracks
        self._afresh = True

    def skip(self) -> None:
        """Note that the markers of this frame are not published: the next ones will replace all
        earlier ones.
        """
        self._afresh = True

    def write(self, tracks: Tracks, scale: float) -> bytes:
        """One ellipse, one arrow, and one text for each track, and its outline if it has one.

        :param tracks: after a frame; markers of tracks that are now absent are deleted.
        :param scale: m/px.
        :return: the message in CDR, as a publisher takes it and a bag holds it.
        """
        sec, nanosec = divmod(tracks.stamp, NANOSECONDS)
        header = sec, nanosec, tracks.frame_id.encode()
        markers: Rows = []
        if tracks.restarted or self._afresh:
            markers += rows_of(MarkerKind(header, action=Marker.DELETEALL), 1)
            self._shown.clear()
            self._afresh = False
        seen = tracks.rows['state'] != TENTATIVE
        rows, outlines = tracks.rows[seen], tracks.outlines
        self._outlining |= outlines.size > 0
        shown = set(rows['track_id'].tolist())
        markers += self._deleted(header, sorted(self._shown - shown))
        self._shown = shown
        if len(rows):
            markers += _added(header, rows, outlines[seen] if len(outlines) else None, scale)
        return array_of(markers)

    def _deleted(self, header: Header, gone: list[int]) -> Rows:
        """DELETE for all markers of tracks that are gone, track by track."""
        spaces = (ELLIPSE, ARROW, LABEL, OUTLINE)[: 3 + self._outlining]
        kinds = [MarkerKind(header, ns, action=Marker.DELETE) for ns in spaces]
        return _by_track([rows_of(kind, len(gone), id=gone) for kind in kinds])


def _by_track(kinds: list[Rows]) -> Rows:
    """Interleave: all kinds of the first track, all of the second, and so on."""
    return [marker for track in zip(*kinds, strict=True) for marker in track]


def _added(
    header: Header, rows: NDArray[np.void], outlines: NDArray[np.float64] | None, scale: float
) -> Rows:
    """The markers of N tracks, track by track.

    :param outlines: (N, P, 2) [px]; None where there are none.
    """
    count = len(rows)
    position, ahead = np.zeros((2, count, 3))
    position[:, 0], position[:, 1] = rows['u'] * scale, rows['v'] * scale
    ahead[:, 0], ahead[:, 1] = rows['du'] * scale, rows['dv'] * scale
    angle, major, minor = ellipses(rows['covariance'][:, :2, :2])
    size = np.maximum(rows['box_h'].astype(float) * scale, 1e-6)
    nothing = np.zeros(count)
    common = {
        'id': rows['track_id'],
        'color': np.where((rows['state'] == COASTING)[:, None], COASTING_COLOR, MEASURED_COLOR),
    }
    axes = 2 * ELLIPSE_SIGMAS * scale
    turn = np.stack([nothing, nothing, np.sin(angle / 2), np.cos(angle / 2)], -1)
    kinds = [
        rows_of(
            MarkerKind(header, ELLIPSE, Marker.CYLINDER), count,
            position=position, orientation=turn,
            scale=np.stack([axes * major, axes * minor, 0.01 * size], -1), **common,
        ),
        rows_of(
            MarkerKind(header, ARROW, Marker.ARROW, points=2), count,
            points=np.stack([position, position + ahead], axis=1),
            scale=np.stack([0.05 * size, 0.1 * size, nothing], -1), **common,
        ),
        _labels(header, rows, position, size, common),
    ]  # fmt: skip
    if outlines is not None:
        kinds.append(_outlines(header, outlines * scale, size, common))
    return _by_track(kinds)


def _outlines(
    header: Header,
    points: NDArray[np.float64],
    size: NDArray[np.float64],
    common: dict[str, NDArray],
) -> Rows:
    """Closed lines through points, (N, P, 2) [m]."""
    count, corners, _ = points.shape
    closed = np.zeros((count, corners + 1, 3))
    closed[..., :2] = np.concatenate([points, points[:, :1]], axis=1)
    kind = MarkerKind(header, OUTLINE, Marker.LINE_STRIP, points=corners + 1)
    width = np.array([0.02, 0.0, 0.0]) * size[:, None]
    return rows_of(kind, count, points=closed, scale=width, **common)


def _labels(
    header: Header,
    rows: NDArray[np.void],
    position: NDArray[np.float64],
    size: NDArray[np.float64],
    common: dict[str, NDArray],
) -> Rows:
    """Text markers of the IDs, grouped by number of digits; IDs ascend."""
    above = position - np.array([0.0, 0.75, 0.0]) * size[:, None]
    scale = np.array([0.0, 0.0, 0.5]) * size[:, None]
    texts = [str(i).encode() for i in rows['track_id'].tolist()]
    lengths = np.array([len(text) for text in texts])
    labels: Rows = []
    for length in np.unique(lengths):
        some = np.flatnonzero(lengths == length)
        labels += rows_of(
            MarkerKind(header, LABEL, Marker.TEXT_VIEW_FACING, text=int(length)), len(some),
            position=above[some], scale=scale[some], text=[texts[i] for i in some],
            **{name: values[some] for name, values in common.items()},
        )  # fmt: skip
    return labels
