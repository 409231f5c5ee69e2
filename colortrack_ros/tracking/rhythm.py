"""Rhythm: whether the detector finds something in every second, third ... frame alone."""

TIMES = 2
"""Times in a row that as many empty frames as before have to come between two with detections.
Assumed: among clutter of 0.4 detections a frame, where most are empty, they do once in 65."""

LONGEST_PAUSE = 4
"""Most empty frames between two with detections. Assumed: what is seen more rarely may be anywhere
in between."""


class Rhythm:
    """Learns how many empty frames come between two with detections.

    A detector may work on every second picture and publish an empty message for the others, or see
    lamps that flash. What it finds is then missed half of the time, but never when it looks.
    """

    def __init__(self) -> None:
        self._empty, self._usual, self._alike, self._pauses = 0, 0, 0, False

    def is_pause(self, count: int, *, again: bool = False) -> bool:
        """Take the next frame; return whether it is empty as frames usually are at this point.

        :param count: of its detections.
        :param again: these are more of the same frame, which remains what it was.
        """
        if not again:
            self._pauses = self._take(count)
        return self._pauses

    def _take(self, count: int) -> bool:
        if not count:
            self._empty += 1
            return self._alike >= TIMES and self._empty <= self._usual
        if self._empty or self._usual:
            alike = self._empty == self._usual <= LONGEST_PAUSE
            self._alike = self._alike + 1 if alike else 0
            self._empty, self._usual = 0, self._empty
        return False
