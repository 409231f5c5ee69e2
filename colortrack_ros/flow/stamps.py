"""Notices stamps that stand still, as of drivers that do not fill them in."""

OF_ONE_MOMENT = 10
"""Messages on end with one stamp that may be of one moment, as those of several detectors. Chosen:
a third of a second of pictures."""


NO_TIME = 100_000
"""Time [ns] in which nothing moves: no camera takes 10,000 pictures a second. Numbers of pictures,
milliseconds and microseconds in place of nanoseconds are below."""


class StampWatch:
    """Counts the messages that have the stamp of the one before, or nearly."""

    def __init__(self) -> None:
        self._last, self._count = 0, 0

    def see(self, stamp: int) -> str:
        """Return what is wrong since more than OF_ONE_MOMENT messages; empty if nothing is.

        :param stamp: of the next message [ns].
        """
        self._count = self._count + 1 if abs(stamp - self._last) < NO_TIME else 1
        self._last = stamp
        if self._count <= OF_ONE_MOMENT:
            return ''
        return (
            f'the stamps stand still at {stamp / 1e9:.3f} s: time is that of the headers, so '
            'nothing moves; let the driver fill in header.stamp'
        )
