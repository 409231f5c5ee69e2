"""``replay``: detector and tracker over a recording, without a running ROS."""

from collections.abc import Sequence
import signal
import sys
import threading


def main(args: Sequence[str] | None = None) -> int:
    """Replay a recording.

    :return: the exit status: 0, also when a signal has ended it early; 1 when it could not be done,
        or its tracks are not the expected ones.
    """
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    try:
        # Not at the top: it takes a second, in which a signal should find its handler.
        from colortrack_ros.replay.run import replay
    except ModuleNotFoundError as error:
        print(f'replay: {error}; pip install rosbags rich', file=sys.stderr)
        return 1
    return replay(sys.argv[1:] if args is None else args, stop)
