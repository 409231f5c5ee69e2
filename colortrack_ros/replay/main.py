"""``replay``: detector and tracker over recordings, without a running ROS."""

from collections.abc import Sequence
import sys
import threading

from colortrack_ros.signals import on_ending_signals


def main(args: Sequence[str] | None = None) -> int:
    """Replay one recording or many.

    :return: the exit status: 0, even if a signal ended it early; 1 if it failed, the recording is
        damaged, or the tracks are not as expected.
    """
    stop = threading.Event()
    on_ending_signals(stop.set)
    # Not at the top: the import takes a second, and the signal handler should be installed by then.
    from colortrack_ros.replay.command import replay

    return replay(sys.argv[1:] if args is None else args, stop)
