"""The node that follows targets by what they look like."""

import threading
import time
from typing import Any

import numpy as np
from rclpy.node import Node
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import MarkerArray

from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.messages import cloud_of_tracks
from colortrack_ros.messages import detections_of_serialized_cloud
from colortrack_ros.messages import frame_of_serialized_image
from colortrack_ros.messages import MarkerWriter
from colortrack_ros.messages import MessageError
from colortrack_ros.nodes.backlog import Backlog
from colortrack_ros.nodes.health import Health
from colortrack_ros.nodes.live_parameters import declare
from colortrack_ros.nodes.pairing import Pair
from colortrack_ros.nodes.pairing import Pairing
from colortrack_ros.nodes.runtime import run
from colortrack_ros.nodes.topics import publish_on
from colortrack_ros.nodes.topics import subscribe_to
from colortrack_ros.nodes.window_tracker_parameters import build
from colortrack_ros.nodes.window_tracker_parameters import TABLE
from colortrack_ros.nodes.window_tracker_parameters import WindowTrackerSetup
from colortrack_ros.windows import WindowTracker


class WindowTrackerNode(Node):
    """Images in, one message of tracks and one of markers for each that it works on out.

    :param subscribe: whether images come from ``image_topic``, or by :meth:`process` alone.
    """

    def __init__(self, *, subscribe: bool = True, **options: Any) -> None:
        super().__init__('window_tracker', allow_undeclared_parameters=True, **options)
        self._lock = threading.Lock()
        self._setup: WindowTrackerSetup = declare(self, TABLE, build, self._apply)
        self._tracker = WindowTracker(self._setup.config, self._setup.targets)
        self._markers, self._pairing, self._alive = MarkerWriter(), Pairing(), 0
        self._backlog: Backlog[Pair] = Backlog()
        self.health = Health(
            self,
            skipped=lambda: self._backlog.skipped,
            tracks=lambda: self._alive,
            refused_targets=lambda: self._tracker.refused,
        )
        self._backlog.max_lag = self._setup.max_lag
        self._tracks_publisher = publish_on(self, PointCloud2, self._setup.tracks_topic)
        self._markers_publisher = publish_on(self, MarkerArray, self._setup.markers_topic)
        self._detects = self._setup.detections_topic != ''
        self._worker = threading.Thread(target=self._work, name='window_tracker')
        if subscribe:
            subscribe_to(self, Image, self._setup.image_topic, self._take_image)
            self._worker.start()
        if subscribe and self._detects:
            topic = self._setup.detections_topic
            subscribe_to(self, PointCloud2, topic, self._take_detections)

    def process(self, frame: Frame, detections: Detections | None = None) -> None:
        """Track and publish."""
        self.health.took_in()
        with self._lock:
            if detections is not None:
                names = ('box_u', 'box_v', 'box_w', 'box_h')
                self._tracker.offer(np.stack([detections.rows[n] for n in names], axis=1))
            tracks = self._tracker.update(frame)
        self._alive = len(tracks.rows)
        if tracks.restarted:
            self.get_logger().warning(f'The tracker started afresh: {tracks.restarted}')
        self._tracks_publisher.publish(cloud_of_tracks(tracks))
        self._markers_publisher.publish(self._markers.write(tracks, self._setup.marker_scale))
        self.health.gave_out(tracks.stamp)

    def _take_image(self, cdr: bytes) -> None:
        try:
            frame = frame_of_serialized_image(cdr)
        except MessageError as error:
            return self.health.refuse(str(error))
        return self._put(self._pairing.put_frame(frame) if self._detects else [(frame, None)])

    def _take_detections(self, cdr: bytes) -> None:
        try:
            self._put(self._pairing.put_detections(detections_of_serialized_cloud(cdr)))
        except MessageError as error:
            self.health.refuse(str(error))

    def _put(self, pairs: list[Pair]) -> None:
        for pair in pairs:
            self._backlog.put(pair)

    def _work(self) -> None:
        while (pair := self._backlog.get()) is not None:
            start = time.monotonic()
            self.process(*pair)
            self._backlog.took(time.monotonic() - start)

    def _apply(self, setup: WindowTrackerSetup) -> None:
        with self._lock:
            if setup.targets != self._setup.targets:
                self._tracker.start(setup.targets)
                self._tracker.targets = np.array(setup.targets).reshape(-1, 4)
            self._tracker.configure(setup.config)
            self._setup = setup
        self._backlog.max_lag = setup.max_lag

    def close(self) -> None:
        """End the thread that works."""
        self._backlog.close()
        if self._worker.is_alive():
            self._worker.join()


def main() -> int:
    """Run the node."""
    return run(lambda _: [WindowTrackerNode()])
