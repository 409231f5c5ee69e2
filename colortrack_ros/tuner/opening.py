"""Opens the footage that the command line names."""

from pathlib import Path

from colortrack_ros.bags import is_bag
from colortrack_ros.sources import open_source
from colortrack_ros.sources.stream import without_secrets
from colortrack_ros.tuner.footage import CameraFootage
from colortrack_ros.tuner.footage import Footage
from colortrack_ros.tuner.footage import RecordedFootage
from colortrack_ros.tuner.running import RunningNodes


def open_footage(
    spec: str, running: RunningNodes, *, rate: float = 0.0, topic: str = ''
) -> Footage:
    """Open a topic of images, a bag, or a source of the camera node.

    :param rate: frames per second, if the recording does not give it [Hz].
    :param topic: of the images in a bag; empty for the only one.
    :raises SourceError: it cannot be opened.
    """
    path = Path(spec)
    if spec.startswith('/') and not path.exists():
        return running.footage(spec)
    if is_bag(path):
        # Not at the top: only bags need ROS messages.
        from colortrack_ros.replay.pictures_of_bag import BagSource

        return RecordedFootage(spec, lambda: BagSource(path, topic))
    source = open_source(spec, rate)
    if source.live:
        return CameraFootage(without_secrets(spec), source)
    source.close()
    return RecordedFootage(spec, lambda: open_source(spec, rate))
