"""The node that turns pictures into detections."""

from collections.abc import Callable
import threading
import time
from typing import Any

from rclpy.node import Node
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2

from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.messages import cloud_of_detections
from colortrack_ros.messages import frame_of_serialized_image
from colortrack_ros.messages import MessageError
from colortrack_ros.nodes.backlog import Backlog
from colortrack_ros.nodes.detector_parameters import build
from colortrack_ros.nodes.detector_parameters import DetectorSetup
from colortrack_ros.nodes.detector_parameters import TABLE
from colortrack_ros.nodes.health import Health
from colortrack_ros.nodes.parameters import declare
from colortrack_ros.nodes.runtime import run
from colortrack_ros.nodes.topics import publish_on
from colortrack_ros.nodes.topics import subscribe_to


class DetectorNode(Node):
    """Images in, one message of detections for each image that it works on out.

    :param deliver: called with the detections of each frame, after they are published.
    :param subscribe: whether images come from ``image_topic``, or by :meth:`process` alone.
    """

    def __init__(
        self,
        deliver: Callable[[Detections], object] = lambda _: None,
        *,
        subscribe: bool = True,
        **options: Any,
    ) -> None:
        super().__init__('detector', allow_undeclared_parameters=True, **options)
        self._lock = threading.Lock()
        setup = declare(self, TABLE, build, self._apply)
        self._detector = Detector(setup.config)
        self._deliver = deliver
        self._backlog: Backlog[bytes] = Backlog(setup.max_lag)
        self.health = Health(self, skipped=lambda: self._backlog.skipped)
        self._publisher = publish_on(self, PointCloud2, 'detections_topic')
        self._worker = threading.Thread(target=self._work, name='detector')
        if subscribe:
            subscribe_to(self, Image, 'image_topic', self._backlog.put, pictures=True)
            self._worker.start()

    def process(self, frame: Frame) -> None:
        """Detect, publish and deliver."""
        self.health.took_in()
        with self._lock:
            detections = self._detector.detect(frame)
        self._publisher.publish(cloud_of_detections(detections))
        self.health.gave_out(detections.stamp)
        self._deliver(detections)

    def _work(self) -> None:
        while (cdr := self._backlog.get()) is not None:
            start = time.monotonic()
            try:
                self.process(frame_of_serialized_image(cdr))
            except MessageError as error:
                self.health.refuse(str(error))
            self._backlog.took(time.monotonic() - start)

    def _apply(self, setup: DetectorSetup) -> None:
        with self._lock:
            self._detector.configure(setup.config)
        self._backlog.max_lag = setup.max_lag

    def close(self) -> None:
        """End the thread that works."""
        self._backlog.close()
        if self._worker.is_alive():
            self._worker.join()


def main() -> int:
    """Run the node."""
    return run(lambda _: [DetectorNode()])
