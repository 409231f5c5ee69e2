"""The detector node: turns pictures into detections."""

import dataclasses
from dataclasses import dataclass
from typing import Any

from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import SetBool
from std_srvs.srv import Trigger

from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection.regions import Regions
from colortrack_ros.messages import cloud_of_detections
from colortrack_ros.messages import image_of_frame
from colortrack_ros.node_kit.calibrated_size import CalibratedSize
from colortrack_ros.node_kit.diagnostics import Health
from colortrack_ros.node_kit.diagnostics import WARN
from colortrack_ros.node_kit.intake import configure
from colortrack_ros.node_kit.intake import IntakeConfig
from colortrack_ros.node_kit.intake import receive_images
from colortrack_ros.node_kit.intake import worker_of
from colortrack_ros.node_kit.managed import ManagedNode
from colortrack_ros.node_kit.node_setup import NodeSetup
from colortrack_ros.node_kit.runtime import run
from colortrack_ros.node_kit.services import offer
from colortrack_ros.node_kit.topics import PictureQueueConfig
from colortrack_ros.node_kit.topics import publish_on
from colortrack_ros.node_kit.topics import topic_name
from colortrack_ros.parameters import part


@dataclass(frozen=True)
class DetectorSetup(NodeSetup):
    """The parameters of the detector node."""

    config: DetectorConfig = part(DetectorConfig)
    intake: IntakeConfig = part(IntakeConfig)
    detections_topic: str = topic_name('detections', 'the detections that are published')
    debug_topic: str = topic_name('detector/mask', 'the mask, published while somebody subscribes')
    camera_info_topic: str = topic_name(
        'camera/camera_info', 'the CameraInfo whose picture size is compared with that of images'
    )
    pictures: PictureQueueConfig = part(PictureQueueConfig)

    def check(self) -> None:
        """Raise an error if the mask cannot be read, or if regions are no polygons."""
        Regions(self.config.regions, self.config.mask)


class DetectorNode(ManagedNode[DetectorSetup]):
    """Takes images; publishes one message of detections for each image that it processes.

    :param subscribe: whether to subscribe to ``image_topic``, or to take images by :attr:`stage`
        alone.
    :ivar stage: turns frames into detections and passes them to the next stage of the chain.
    """

    def __init__(self, *, subscribe: bool = True, **options: Any) -> None:
        super().__init__('detector', DetectorSetup, **options)
        self._subscribe = subscribe
        self._calibrated: CalibratedSize | None = None
        self._paused = False
        self.stage = worker_of(self, self._detect, self._refuse, self.setup.intake)
        self.stage.paused = True
        self.stage.then(self._publish)

    def configure(self) -> None:
        """Create the detector, its publishers, services and subscriptions."""
        self._detector = Detector(self.setup.config)
        self.health = Health(
            self,
            lost=lambda: self.health.losses.total,
            skipped=lambda: self.stage.skipped,
        )
        self._publisher = publish_on(self, PointCloud2, self.setup.detections_topic)
        self._debug_publisher = publish_on(self, Image, self.setup.debug_topic)
        offer(self, SetBool, '~/pause', self._pause)
        offer(self, Trigger, '~/learn_background', self._learn_background)
        if self._subscribe:
            topic = self.setup.camera_info_topic
            self._calibrated = CalibratedSize(self, topic, self.setup.intake.image_topic)
            receive_images(self, self.stage, self.setup.intake, self._refuse, self.health.losses)

    def set_active(self, active: bool) -> None:
        """Process frames, or drop them."""
        self.stage.paused = self._paused or not active

    def release(self) -> None:
        """Finish the frames that are waiting."""
        self.stage.flush()

    def _refuse(self, reason: str) -> None:
        self.health.refuse(reason)

    def _detect(self, frame: Frame) -> Detections:
        self.health.took_in()
        with self.lock:
            detections = self._detector.detect(frame)
            size = self._calibrated.trouble(frame) if self._calibrated else ''
            # colors may be out of view
            self.health.note(size, self._detector.trouble, level=WARN)
            if self._debug_publisher.get_subscription_count() > 0:
                mask = dataclasses.replace(frame, image=self._detector.mask, encoding='mono8')
                self._debug_publisher.publish(image_of_frame(mask))
        return detections

    def _publish(self, detections: Detections, _: object) -> None:
        self._publisher.publish(cloud_of_detections(detections))
        self.health.gave_out(detections.stamp)

    def _pause(self, request: SetBool.Request) -> str:
        self._paused = request.data
        self.set_active(self.active)
        return 'paused' if request.data else 'working'

    def _learn_background(self, _: Trigger.Request) -> str:
        with self.lock:
            self._detector.learn_background()
        return 'the background is learned anew from the next frame on'

    def apply(self, setup: DetectorSetup) -> None:
        """Apply changed parameters."""
        if setup.config != self.setup.config:
            self._detector.configure(setup.config)
        configure(self.stage, setup.intake)

    def close(self) -> None:
        """Stop the worker thread."""
        self.stage.close()
        super().close()


def main() -> int:
    """Run the node."""
    return run(lambda _: [DetectorNode()])
