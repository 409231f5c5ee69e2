"""Queue of tracks that wait for detections, depths, and camera pose of their picture."""

from collections import deque
from collections.abc import Callable
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import Tracks
from colortrack_ros.world.poses import TransformError
from colortrack_ros.world.poses import WENT_BACK
from colortrack_ros.world.view import View

LONGEST_WAIT = WENT_BACK
"""Longest wait [s] for odometry and other inputs, which robots send at 10 Hz or more. A pose that
is later still is of no use: it counts as one of a time that has gone back."""

MAX_DETECTIONS, MAX_DEPTHS = 300, 30
"""Most detections and depth pictures kept while waiting for their tracks: at 60 Hz, 5 s and 0.5 s.
Depths of a second at 1920x1080 would be 500 MB; detections are a few kB. Chosen."""

SAME = 0.02
"""Largest difference between the stamps of a picture and its depths [s]: half a frame at 25 Hz,
which cameras without synchronization are apart."""

SLOWEST = 2.0
"""Time without depths [s] after which a depth camera that sent some is taken to have stopped: those
that are thinned out to 1 Hz have not. Chosen."""

NO_DEPTH = 'depth_topic, or its stamps, are wrong, or it is slower'
"""Why a picture has no depths, if none were refused."""

Release = Callable[[Tracks, Detections, View, NDArray[np.float32] | None], object]


class Waiting:
    """Releases pictures in order once all their inputs are there.

    :param view_at: returns the view of the camera at a time [ns]; raises TransformError.
    :param release: takes the inputs of one picture.
    :param refuse: takes the reason why a picture is dropped.
    :param clock: arrival time [s].
    :ivar needs_depth: whether pictures wait for depths.
    """

    def __init__(
        self,
        view_at: Callable[[int], View],
        release: Release,
        refuse: Callable[[str], object],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.needs_depth = False
        self._view_at, self._release, self._refuse, self._clock = view_at, release, refuse, clock
        self._pictures: deque[tuple[Tracks, float]] = deque()
        self._detections: dict[int, Detections] = {}
        self._depths: dict[int, NDArray[np.float32]] = {}
        self._depth_came: float | None = None  # or has been waited for since [s]
        self._no_depth = NO_DEPTH

    def put_tracks(self, tracks: Tracks) -> None:
        """Add the tracks of the next picture."""
        now = self._clock()
        if self._depth_came is None:
            self._depth_came = now
        self._pictures.append((tracks, now))
        self.look()

    def put_detections(self, detections: Detections) -> None:
        """Add the detections of a picture."""
        _keep(self._detections, detections.stamp, detections, MAX_DETECTIONS)
        self.look()

    def put_depth(self, stamp: int, depth: NDArray[np.float32]) -> None:
        """Add depths, (H, W) [m]; they come in order."""
        _keep(self._depths, stamp, depth, MAX_DEPTHS)
        self._depth_came, self._no_depth = self._clock(), NO_DEPTH
        self.look()

    def refuse_depth(self, reason: str) -> None:
        """Tell with the pictures that lack depths why those that came are of no use."""
        self._no_depth = reason

    def look(self) -> None:
        """Release complete pictures, and drop those that have waited too long."""
        while self._pictures:
            tracks, arrived = self._pictures[0]
            # a clock that goes back is another one: nothing more will come
            over = not 0 <= self._clock() - arrived <= LONGEST_WAIT
            reason, later = self._try(tracks, over)
            if reason and later and not over:
                return
            self._pictures.popleft()
            if reason:
                self._refuse(reason)

    def _try(self, tracks: Tracks, over: bool) -> tuple[str, bool]:
        """Release a picture, or return what it lacks and whether that may still come."""
        stamp = tracks.stamp
        if stamp not in self._detections:
            return f'no detections came for the tracks of {stamp / NANOSECONDS:.3f} s', True
        depth = self._depth_at(stamp)
        if self.needs_depth and depth is None and not (over or self._missed_depth(stamp)):
            return 'no depths', True
        try:
            view = self._view_at(stamp)
        except TransformError as error:
            return str(error), error.later
        if self.needs_depth and depth is None:
            self._refuse(
                f'no depth picture came within {SAME} s of the picture of '
                f'{stamp / NANOSECONDS:.3f} s: {self._no_depth}'
            )
        self._release(tracks, self._detections.pop(stamp), view, depth)
        return '', False

    def _depth_at(self, stamp: int) -> NDArray[np.float32] | None:
        near = min(self._depths, key=lambda other: abs(other - stamp), default=None)
        if near is None or abs(near - stamp) > SAME * NANOSECONDS:
            return None
        return self._depths[near]

    def _missed_depth(self, stamp: int) -> bool:
        """Whether waiting for depths of a time [ns] is in vain.

        Later ones have come, or none for too long, as where method fused has no depth camera.
        """
        newest, now = next(reversed(self._depths), stamp), self._clock()
        since = 0.0 if self._depth_came is None else now - self._depth_came
        longest = SLOWEST if self._depths else LONGEST_WAIT
        return newest > stamp + SAME * NANOSECONDS or not 0 <= since <= longest


def _keep(waiting: dict[int, Any], stamp: int, item: Any, most: int) -> None:
    waiting.pop(stamp, None)  # the newest is the last, also in a bag that loops
    waiting[stamp] = item
    if len(waiting) > most:
        waiting.pop(next(iter(waiting)))
