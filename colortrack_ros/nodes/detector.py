"""The node that turns pictures into detections."""

from collections.abc import Callable
import dataclasses
import threading
import time
from typing import Any

from rclpy.node import Node
from sensor_msgs.msg import CompressedImage
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import SetBool
from std_srvs.srv import Trigger

from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.messages import cloud_of_detections
from colortrack_ros.messages import frame_of_serialized_compressed_image
from colortrack_ros.messages import frame_of_serialized_image
from colortrack_ros.messages import image_of_frame
from colortrack_ros.messages import MessageError
from colortrack_ros.nodes.backlog import Backlog
from colortrack_ros.nodes.clocks import lacks_clock
from colortrack_ros.nodes.clocks import seconds_of
from colortrack_ros.nodes.detector_parameters import build
from colortrack_ros.nodes.detector_parameters import DetectorSetup
from colortrack_ros.nodes.detector_parameters import TABLE
from colortrack_ros.nodes.health import Health
from colortrack_ros.nodes.live_parameters import declare
from colortrack_ros.nodes.order import IDLE
from colortrack_ros.nodes.order import Order
from colortrack_ros.nodes.runtime import run
from colortrack_ros.nodes.topics import publish_on
from colortrack_ros.nodes.topics import subscribe_to

READERS = {
    'raw': (Image, '{}', frame_of_serialized_image),
    'compressed': (CompressedImage, '{}/compressed', frame_of_serialized_compressed_image),
}
"""For each value of image_transport the message, its topic and what reads it."""


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
        self._backlog: Backlog[bytes] = Backlog()
        self._setup: DetectorSetup = declare(self, TABLE, build, self._apply)
        self._detector = Detector(self._setup.config)
        self._deliver = deliver
        self._paused = False
        self.health = Health(self, skipped=lambda: self._backlog.skipped)
        self._order: Order[Frame] = Order(self.process, self.health.refuse, seconds_of(self))
        self._apply(self._setup)
        self._publisher = publish_on(self, PointCloud2, self._setup.detections_topic)
        self._debug_publisher = publish_on(self, Image, self._setup.debug_topic)
        self.create_service(SetBool, '~/pause', self._pause)
        self.create_service(Trigger, '~/learn_background', self._learn_background)
        self._worker = threading.Thread(target=self._work, name='detector')
        if subscribe:
            kind, name, self._read = READERS[self._setup.image_transport]
            subscribe_to(self, kind, name.format(self._setup.image_topic), self._receive)
            self._worker.start()

    def process(self, frame: Frame) -> None:
        """Detect, publish and deliver."""
        if self._paused:
            return
        self.health.took_in()
        with self._lock:
            detections = self._detector.detect(frame)
            if self._debug_publisher.get_subscription_count() > 0:
                mask = dataclasses.replace(frame, image=self._detector.mask, encoding='mono8')
                self._debug_publisher.publish(image_of_frame(mask))
        self._publisher.publish(cloud_of_detections(detections))
        self.health.gave_out(detections.stamp)
        self._deliver(detections)

    def _receive(self, cdr: bytes) -> None:
        if not self._paused:
            self._backlog.put(cdr)

    def _work(self) -> None:
        while not self._backlog.closed:
            cdr = self._backlog.get(IDLE)
            start = time.monotonic()
            if cdr is None:
                self._order.look(lambda: lacks_clock(self))
                continue
            try:
                frame = self._read(cdr)
                self._order.push(frame.stamp, frame)
            except MessageError as error:
                self.health.refuse(str(error))
            self._backlog.took(time.monotonic() - start)

    def _pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._paused = request.data
        response.success = True
        response.message = 'paused' if self._paused else 'working'
        return response

    def _learn_background(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        with self._lock:
            self._detector.learn_background()
        response.success = True
        response.message = 'the background is learned anew from the next frame on'
        return response

    def _apply(self, setup: DetectorSetup) -> None:
        with self._lock:
            if setup.config != self._setup.config:
                self._detector.configure(setup.config)
        self._setup = setup
        self._backlog.max_lag = setup.max_lag
        self._order.window, self._order.max_late = setup.reorder_window, setup.max_late

    def close(self) -> None:
        """End the thread that works."""
        self._backlog.close()
        if self._worker.is_alive():
            self._worker.join()


def main() -> int:
    """Run the node."""
    return run(lambda _: [DetectorNode()])
