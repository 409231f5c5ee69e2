"""The node that turns detections into tracks."""

from dataclasses import dataclass
from dataclasses import replace
from typing import Any

from sensor_msgs.msg import CameraInfo
from std_srvs.srv import Trigger

from colortrack_ros.data import Detections
from colortrack_ros.data import Tracks
from colortrack_ros.flow.order import IDLE
from colortrack_ros.flow.order import OrderConfig
from colortrack_ros.flow.stage import Stage
from colortrack_ros.flow.stage import Worker
from colortrack_ros.messages import image_size_of_serialized_camera_info
from colortrack_ros.node_kit.camera_pose import CameraPoseConfig
from colortrack_ros.node_kit.clocks import lacks_clock
from colortrack_ros.node_kit.clocks import seconds_of
from colortrack_ros.node_kit.clocks import STEADY
from colortrack_ros.node_kit.detections_intake import DetectionsConfig
from colortrack_ros.node_kit.detections_intake import subscribe_to_detections
from colortrack_ros.node_kit.diagnostics import Health
from colortrack_ros.node_kit.diagnostics import TOLD_EVERY
from colortrack_ros.node_kit.intake import configure
from colortrack_ros.node_kit.intake import lag_limit
from colortrack_ros.node_kit.intake import whole_updates
from colortrack_ros.node_kit.intake import worker_of
from colortrack_ros.node_kit.managed import CONFIGURED_AGAIN
from colortrack_ros.node_kit.managed import ManagedNode
from colortrack_ros.node_kit.node_setup import NodeSetup
from colortrack_ros.node_kit.runtime import run
from colortrack_ros.node_kit.services import offer
from colortrack_ros.node_kit.topics import subscribe_to
from colortrack_ros.node_kit.topics import topic_name
from colortrack_ros.node_kit.tracks_output import TracksOutput
from colortrack_ros.node_kit.tracks_output import TracksOutputConfig
from colortrack_ros.node_kit.viewpoint_intake import ViewpointIntake
from colortrack_ros.parameters import part
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig


@dataclass(frozen=True)
class TrackerSetup(NodeSetup):
    """The parameters of the tracker node."""

    config: TrackerConfig = part(TrackerConfig)
    max_lag: float = lag_limit(0.5, 'detections')
    order: OrderConfig = part(OrderConfig)
    detections: DetectionsConfig = part(DetectionsConfig)
    camera_info_topic: str = topic_name(
        'camera/camera_info', 'the CameraInfo that tells how large the pictures are'
    )
    output: TracksOutputConfig = part(TracksOutputConfig)
    pose: CameraPoseConfig = part(CameraPoseConfig)


class TrackerNode(ManagedNode[TrackerSetup]):
    """Takes detections, and publishes one message of tracks and one of markers for each message.

    :param subscribe: whether to subscribe to ``detections_topic``; otherwise detections are put
        into :attr:`intake`.
    :ivar stage: makes the tracks.
    :ivar intake: takes detections for the stage.
    """

    def __init__(self, *, subscribe: bool = True, **options: Any) -> None:
        super().__init__('tracker', TrackerSetup, **options)
        self._subscribe, self._tracker = subscribe, Tracker(self.setup.config)
        self.stage: Stage[Detections, Tracks] = (
            worker_of(self, self._track, self._refuse, self.setup)
            if subscribe
            else Stage(self._track, self._refuse, seconds_of(self))
        )
        self.stage.paused = True
        self.intake = ViewpointIntake(self, self.stage, self._refuse)
        self._configure(self.setup)
        self.stage.then(self._publish)

    def configure(self) -> None:
        """Create publishers, services and subscriptions."""
        self._tracker.configure(self.setup.config)
        if self.configured_before:
            self._tracker.reset(CONFIGURED_AGAIN)
        self._tracker.screening.refuse = self._refuse
        self._image_size = 0, 0
        self._skipped = self.stage.skipped
        self.health = Health(
            self,
            tracks=lambda: self._output.alive,
            invalid_detections=lambda: self._tracker.screening.dropped,
            detections_left_out=lambda: self._tracker.screening.crowded_out,
            repeated_detections=lambda: self._tracker.screening.repeated,
            repeated_pictures=lambda: self._tracker.repeats,
            skipped=lambda: self.stage.skipped,
        )
        self._output = TracksOutput(self, self.setup.output)
        offer(self, Trigger, '~/reset', self._reset)
        if self._subscribe:
            detections = self.setup.detections
            self._read = detections.reader(self.get_logger().warning)
            subscribe_to_detections(self, detections, self._receive, self._refuse)
            subscribe_to(
                self, CameraInfo, self.setup.camera_info_topic, self._learn_size, self._refuse
            )
        else:
            self.create_timer(IDLE, self._look, clock=STEADY)
        self.intake.clear()
        self._ask_viewpoints(self.setup)
        self.create_timer(IDLE, self.intake.look, clock=STEADY)

    def set_active(self, active: bool) -> None:
        """Process detections, or drop them."""
        self.stage.paused = not active

    def release(self) -> None:
        """Process everything that is waiting."""
        self.intake.flush()

    def _refuse(self, reason: str) -> None:
        self.health.refuse(reason)

    def _track(self, detections: Detections) -> Tracks:
        self.health.took_in()
        # in a pipeline, detections come from the detector's thread
        with self.lock, whole_updates(self._tracker):
            return self._tracker.update(detections)

    def _publish(self, tracks: Tracks, _: object) -> None:
        self._output.publish(tracks, self.setup.output.marker_scale)
        self.health.gave_out(tracks.stamp)

    def _receive(self, cdr: bytes) -> None:
        size = self._image_size
        self.intake.put_unread(lambda: replace(self._read(cdr), image_size=size), len(cdr))
        skipped = self.stage.skipped
        if skipped > self._skipped:
            self.get_logger().warning(
                f'Too slow for what comes in: {skipped} messages of detections skipped so far.',
                throttle_duration_sec=TOLD_EVERY,
            )
            self._skipped = skipped

    def _learn_size(self, cdr: bytes) -> None:
        self._image_size = image_size_of_serialized_camera_info(cdr)

    def _look(self) -> None:
        self.stage.look(lambda: lacks_clock(self))

    def _reset(self, _: Trigger.Request) -> str:
        with self.lock:
            self._tracker.reset('a call of ~/reset')
        return 'all tracks are dropped with the next frame'

    def apply(self, setup: TrackerSetup) -> None:
        """Apply changed parameters."""
        if setup.config != self.setup.config:
            self._tracker.configure(setup.config)
        self._configure(setup)
        self._ask_viewpoints(setup)

    def _ask_viewpoints(self, setup: TrackerSetup) -> None:
        asked = setup.config.ego_motion == 'odometry'
        self.intake.configure(setup.pose, setup.camera_info_topic, asked=asked)

    def _configure(self, setup: TrackerSetup) -> None:
        if isinstance(self.stage, Worker):
            configure(self.stage, setup)
        else:
            self.stage.configure(setup.order)

    def close(self) -> None:
        """Stop the worker thread."""
        self.stage.close()
        super().close()


def main() -> int:
    """Run the node."""
    return run(lambda _: [TrackerNode()])
