"""The node that draws tracks onto pictures."""

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import Tracks
from colortrack_ros.drawing import draw_tracks
from colortrack_ros.drawing import Trails
from colortrack_ros.encodings import writable_bgr
from colortrack_ros.messages import frame_of_serialized_image
from colortrack_ros.messages import image_of_frame
from colortrack_ros.messages import outlines_of_serialized_cloud
from colortrack_ros.messages import tracks_of_serialized_cloud
from colortrack_ros.messages import tracks_with_outlines
from colortrack_ros.node_kit.diagnostics import Health
from colortrack_ros.node_kit.diagnostics import WARN
from colortrack_ros.node_kit.intake import full_range
from colortrack_ros.node_kit.managed import ManagedNode
from colortrack_ros.node_kit.node_setup import NodeSetup
from colortrack_ros.node_kit.runtime import run
from colortrack_ros.node_kit.topics import PictureQueueConfig
from colortrack_ros.node_kit.topics import publish_on
from colortrack_ros.node_kit.topics import subscribe_to
from colortrack_ros.node_kit.topics import topic_name
from colortrack_ros.parameters import part

MOST_UNPAIRED = 30
"""How many pictures may wait for their tracks, and tracks for their picture: a second at 30 Hz, the
depth of the queue of images."""

TOLD_AFTER = 150
"""How many pictures, or tracks, on end without the other are told: 5 s at 30 Hz. Assumed: a
detector that starts along with the camera is there by then."""


@dataclass(frozen=True)
class OverlaySetup(NodeSetup):
    """The parameters of the overlay node."""

    image_topic: str = topic_name('camera/image_raw', 'the pictures')
    tracks_topic: str = topic_name('tracks', 'the tracks')
    outlines_topic: str = topic_name('', 'outlines that are drawn as well; empty: none')
    overlay_topic: str = topic_name(
        'overlay/image_raw', 'the pictures with the tracks drawn on them'
    )
    yuv_full_range: bool = full_range()
    pictures: PictureQueueConfig = part(PictureQueueConfig)


class OverlayNode(ManagedNode[OverlaySetup]):
    """Takes images and tracks, and publishes one Image for each pair with the same stamp.

    With ``outlines_topic``, tracks wait for their outlines.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__('overlay', OverlaySetup, **options)

    def configure(self) -> None:
        """Create the publisher and the subscriptions."""
        setup = self.setup
        self._trails = Trails()
        self._frames: dict[int, Frame] = {}
        self._tracks: dict[int, Tracks] = {}
        self._outlines: dict[int, NDArray[np.void]] = {}
        self._unpaired = 0
        self.health = Health(self)
        self._publisher = publish_on(self, Image, setup.overlay_topic)
        subscribe_to(self, Image, setup.image_topic, self._take_image, self.health.refuse)
        subscribe_to(self, PointCloud2, setup.tracks_topic, self._take_tracks, self.health.refuse)
        if setup.outlines_topic:
            subscribe_to(
                self, PointCloud2, setup.outlines_topic, self._take_outlines, self.health.refuse
            )

    def _take_image(self, cdr: bytes) -> None:
        frame = frame_of_serialized_image(cdr)
        frame = dataclasses.replace(frame, full_range=self.setup.yuv_full_range)
        self._take(self._frames, frame.stamp, frame)

    def _take_tracks(self, cdr: bytes) -> None:
        tracks = tracks_of_serialized_cloud(cdr)
        self._take(self._tracks, tracks.stamp, tracks)

    def _take_outlines(self, cdr: bytes) -> None:
        stamp, points = outlines_of_serialized_cloud(cdr)
        self._take(self._outlines, stamp, points)

    def _take(self, waiting: dict, stamp: int, item: Any) -> None:
        if not self.active:
            return
        self.health.took_in()
        waiting[stamp] = item
        outlined = stamp in self._outlines or not self.setup.outlines_topic
        if stamp in self._frames and stamp in self._tracks and outlined:
            tracks = self._tracks.pop(stamp)
            if stamp in self._outlines:
                tracks = tracks_with_outlines(tracks, self._outlines.pop(stamp))
            self._paint(self._frames.pop(stamp), tracks)
        while len(waiting) > MOST_UNPAIRED:
            waiting.pop(next(iter(waiting)))
            self._unpaired += 1
        if self._unpaired >= TOLD_AFTER:
            self.health.note(self._difference(), level=WARN)

    def _difference(self) -> str:
        """Why nothing is drawn: the newest stamp on each topic."""
        ends: dict[str, dict[int, Any]] = {
            self.setup.image_topic: self._frames,
            self.setup.tracks_topic: self._tracks,
        }
        if self.setup.outlines_topic:
            ends[self.setup.outlines_topic] = self._outlines
        newest = [
            f'{self.resolve_topic_name(topic)} '
            + (f'at {next(reversed(waiting)) / NANOSECONDS:.3f} s' if waiting else 'nothing')
            for topic, waiting in ends.items()
        ]
        return (
            'nothing is drawn: pictures and tracks have no stamps in common, or come too late for '
            f'each other; the last on {", on ".join(newest)}'
        )

    def _paint(self, frame: Frame, tracks: Tracks) -> None:
        self._unpaired = 0
        self.health.note('')
        self._trails.update(tracks)
        if self._publisher.get_subscription_count() == 0:
            return
        image = writable_bgr(frame)
        draw_tracks(image, tracks, self._trails)
        picture = dataclasses.replace(frame, image=image, encoding='bgr8')
        self._publisher.publish(image_of_frame(picture))
        self.health.gave_out(frame.stamp)


def main() -> int:
    """Run the node."""
    return run(lambda _: [OverlayNode()])
