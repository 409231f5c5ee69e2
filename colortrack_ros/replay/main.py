"""``replay``: detector and tracker over recordings, without a running ROS."""

from collections.abc import Sequence
import sys
import threading

from colortrack_ros.signals import on_ending_signals

NO_ROS = 'source a ROS installation, or make .venv/demo; without ROS, colortrack_ros.chain tracks'
"""What to do if rclpy is missing."""


def main(args: Sequence[str] | None = None) -> int:
    """Replay one recording or many.

    :return: the exit status: 0, even if a signal ended it early; 1 if it failed, the recording is
        damaged, or the tracks are not as expected.
    """
    stop = threading.Event()
    on_ending_signals(stop.set)
    try:
        # Not at the top: the import takes a second, and the signal handler should be installed by
        # then.
        from colortrack_ros.replay.command import replay
    except ModuleNotFoundError as error:
        # Bags hold ROS messages, and rcl reads the parameters, so replay needs ROS.
        need = NO_ROS if error.name == 'rclpy' else 'pip install rosbags rich'
        print(f'replay: {error}; {need}', file=sys.stderr)
        return 1
    return replay(sys.argv[1:] if args is None else args, stop)
