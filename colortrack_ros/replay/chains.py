"""The chain of the nodes over a recording: every stage runs immediately and skips nothing."""

from collections.abc import Callable
from typing import Any

from colortrack_ros.chain import ColorChain
from colortrack_ros.chain import ImageChain
from colortrack_ros.chain import track_pair
from colortrack_ros.contours import ContourTracker
from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.data import Tracks
from colortrack_ros.detection import Detector
from colortrack_ros.flow.pairing import Pair
from colortrack_ros.flow.stage import Stage
from colortrack_ros.node_kit.image_tracker import ImageTracker
from colortrack_ros.nodes.tracker import TrackerSetup
from colortrack_ros.replay.recordings import Item
from colortrack_ros.replay.setup import Setup
from colortrack_ros.replay.viewpoints import RecordedViewpoints
from colortrack_ros.replay.viewpoints import WithViewpoints
from colortrack_ros.tracking import Tracker
from colortrack_ros.windows import WindowTracker

IMAGE_TRACKERS: dict[str, Callable[[Any], ImageTracker]] = {
    'window_tracker': lambda setup: WindowTracker(setup.config, setup.targets),
    'contour_tracker': lambda setup: ContourTracker(setup.config, setup.targets),
}
"""Trackers of pictures, by the name of the node that publishes the tracks; ``tracker`` takes
detections."""


def make_chain(
    setup: Setup,
    detected: Callable[[Detections, Item], object],
    tracked: Callable[[Tracks, Item], object],
    drop: Callable[[str], object],
    warn: Callable[[str], object],
    viewpoints: RecordedViewpoints | None = None,
) -> ColorChain | ImageChain:
    """The chain that the nodes of this setup form; the context of each frame is its item.

    :param detected: takes the detections of an item.
    :param tracked: takes the tracks after an item.
    :param drop: takes the reason why an item came too late.
    :param warn: takes what detector and tracker tell of each picture, empty if all is well.
    :param viewpoints: of the pictures, if the tracker needs them.
    """
    detection: Stage[Frame, Detections] | None = None
    if setup.detector:
        detector = Detector(setup.detector.config)
        detection = Stage(detector.detect, drop)
        detection.configure(setup.detector.intake.order)
        detection.then(lambda *_: warn(detector.trouble))
        detection.then(detected)
    if isinstance(setup.tracker, TrackerSetup):
        assert detection
        of_detections = Tracker(setup.tracker.config)
        of_detections.screening.refuse = warn
        tracking = Stage(of_detections.update, drop)
        tracking.configure(setup.tracker.order)
        tracking.then(tracked)
        taker = WithViewpoints(tracking, viewpoints, warn) if viewpoints else tracking
        return ColorChain(detection, taker)
    tracker = IMAGE_TRACKERS[setup.node](setup.tracker)
    pictures: Stage[Frame, Frame] = Stage(lambda frame: frame, drop)
    pictures.configure(setup.tracker.intake.order)
    pairs: Stage[Pair, Tracks] = Stage(lambda pair: track_pair(tracker, pair), drop)
    pairs.then(lambda *_: warn(tracker.trouble))
    pairs.then(tracked)
    return ImageChain(pictures, pairs, detects=detection is not None, detection=detection)
