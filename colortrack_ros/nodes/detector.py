"""The node that turns pictures into detections."""

from collections.abc import Callable
import dataclasses
import threading
from typing import Any

from rclpy.node import Node
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import SetBool
from std_srvs.srv import Trigger

from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.messages import cloud_of_detections
from colortrack_ros.messages import image_of_frame
from colortrack_ros.node_kit.diagnostics import Health
from colortrack_ros.node_kit.intake import ImageIntake
from colortrack_ros.node_kit.live_parameters import declare
from colortrack_ros.node_kit.runtime import run
from colortrack_ros.node_kit.topics import publish_on
from colortrack_ros.nodes.detector_parameters import build
from colortrack_ros.nodes.detector_parameters import DetectorSetup
from colortrack_ros.nodes.detector_parameters import TABLE


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
        self._setup: DetectorSetup = declare(self, TABLE, build, self._apply)
        self._detector = Detector(self._setup.config)
        self._deliver = deliver
        self.health = Health(self, skipped=lambda: self._intake.skipped)
        self._intake = ImageIntake(self, self.process, self.health.refuse)
        self._intake.configure(self._setup)
        self._publisher = publish_on(self, PointCloud2, self._setup.detections_topic)
        self._debug_publisher = publish_on(self, Image, self._setup.debug_topic)
        self.create_service(SetBool, '~/pause', self._pause)
        self.create_service(Trigger, '~/learn_background', self._learn_background)
        if subscribe:
            self._intake.subscribe(self._setup.image_topic, self._setup.image_transport)

    def process(self, frame: Frame) -> None:
        """Detect, publish and deliver."""
        if self._intake.paused:
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

    def _pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._intake.paused = request.data
        response.success = True
        response.message = 'paused' if request.data else 'working'
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
        self._intake.configure(setup)

    def close(self) -> None:
        """End the thread that works."""
        self._intake.close()


def main() -> int:
    """Run the node."""
    return run(lambda _: [DetectorNode()])
