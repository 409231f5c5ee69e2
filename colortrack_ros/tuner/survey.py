"""Tracks a whole recording, to propose labels."""

import time

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.chain import ColorTracker
from colortrack_ros.data import Detections
from colortrack_ros.data import Tracks
from colortrack_ros.sources import Source
from colortrack_ros.sources import SourceError
from colortrack_ros.tuner.settings import Settings
from colortrack_ros.tuner.workbench import WORK_SECONDS

SIGHTING = np.dtype([('track', 'i8'), ('box', 'f8', 4), ('measured', '?'), ('visible', 'f8')])
"""One track in one frame, or one object of a truth. box: u, v of its center, width and height [px];
that of the blob if it was measured, since a truth must not depend on the filter that it is used to
evaluate. visible: visible share, 0..1."""


class Survey:
    """Runs detector and tracker over all frames of a recording, a little at a time.

    :param source: of the frames, from the first one; closed at the end.
    :param settings: the current ones.
    :ivar frames: (N,) of dtype SIGHTING for each frame so far.
    :ivar done: whether all frames have been processed.
    """

    def __init__(self, source: Source, settings: Settings) -> None:
        self.frames: list[NDArray[np.void]] = []
        self.done = False
        self._source = source
        self._track = ColorTracker(settings.detector, settings.tracker)

    def work(self, seconds: float = WORK_SECONDS) -> bool:
        """Continue for at most that long.

        :returns: whether there is more to do.
        """
        end = time.monotonic() + seconds
        while not self.done and time.monotonic() < end:
            try:
                frame = self._source.read()
            except SourceError:
                continue
            if frame is None:
                self.close()
            else:
                tracks = self._track(frame)
                self.frames.append(_seen(tracks, self._track.detections))
        return not self.done

    def close(self) -> None:
        """Stop."""
        self.done = True
        self._source.close()


def _seen(tracks: Tracks, detections: Detections) -> NDArray[np.void]:
    rows, blobs = tracks.rows, detections.rows
    seen = np.zeros(len(rows), SIGHTING)
    seen['track'] = rows['track_id']
    seen['box'] = np.stack([rows[name] for name in ('u', 'v', 'box_w', 'box_h')], axis=1)
    seen['measured'] = rows['time_since_update'] == 0
    seen['visible'] = seen['measured']
    if len(blobs) and len(rows):
        away = np.hypot(*(rows[name][:, None] - blobs[name] for name in 'uv'))
        near = away.argmin(axis=1)
        inside = seen['measured'] & (away.min(axis=1) < np.hypot(rows['box_w'], rows['box_h']) / 2)
        blob = blobs[near[inside]]
        seen['box'][inside] = np.stack([blob[n] for n in ('u', 'v', 'box_w', 'box_h')], axis=1)
    return seen
