"""The locator node: turns tracks into objects in meters."""

from collections.abc import Callable
from dataclasses import dataclass
from dataclasses import replace
from typing import Any
from typing import NamedTuple

from std_msgs.msg import String

from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import Tracks
from colortrack_ros.flow.interleaving import Interleaving
from colortrack_ros.flow.order import IDLE
from colortrack_ros.messages import BOXES
from colortrack_ros.node_kit.camera_feed import CameraFeed
from colortrack_ros.node_kit.camera_feed import CameraFeedConfig
from colortrack_ros.node_kit.camera_feed import Depth
from colortrack_ros.node_kit.clocks import seconds_of
from colortrack_ros.node_kit.clocks import STEADY
from colortrack_ros.node_kit.diagnostics import Health
from colortrack_ros.node_kit.locations_output import LocationsOutput
from colortrack_ros.node_kit.locations_output import LocationsOutputConfig
from colortrack_ros.node_kit.managed import ManagedNode
from colortrack_ros.node_kit.node_setup import NodeSetup
from colortrack_ros.node_kit.runtime import run
from colortrack_ros.node_kit.topics import PictureQueueConfig
from colortrack_ros.parameters import part
from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world.locator import GAP
from colortrack_ros.world.selection import rule_of
from colortrack_ros.world.selection import Selector
from colortrack_ros.world.view import CalibrationWatch
from colortrack_ros.world.view import View

MAP = 'map'
"""The frame that moves in steps as localization corrects the robot's pose in it, REP-105."""

MAP_JUMPS = (
    f'fixed_frame {MAP}: localization moves it in steps, which look like motion of the objects: '
    'they are off, or withheld; expected odom, from which others transform by TF'
)

HEIGHTLESS = (
    '{}: neither NAME.diameter nor NAME.height is told: centers are taken to be on the ground, '
    'and objects, whose centers are above it, are located too far away'
)


HIJACKED = (
    'target_frame {!r} is a frame of the robot, which would be where the target is: the target has '
    'none in TF; expected a name that nobody else publishes, such as target'
)


@dataclass(frozen=True)
class LocatorSetup(NodeSetup):
    """The parameters of the locator node."""

    config: LocatorConfig = part(LocatorConfig)
    feed: CameraFeedConfig = part(CameraFeedConfig)
    output: LocationsOutputConfig = part(LocationsOutputConfig)
    pictures: PictureQueueConfig = part(PictureQueueConfig)

    def check(self) -> None:
        """Raise an error if the selected target cannot exist."""
        rule_of(self.output.select, self.names)

    @property
    def seen_as(self) -> LocatorConfig:
        """How things are located: the boxes of networks are not eroded."""
        is_eroded = self.feed.detections.detections_type != BOXES
        return replace(self.config, eroded=self.config.eroded if is_eroded else 0.0)

    @property
    def hijacks(self) -> str:
        """The frame of the robot that the target would have in TF; empty if it has its own."""
        pose, frame = self.feed.pose, self.output.target_frame
        taken = (pose.fixed_frame, pose.base_frame, pose.camera_frame)
        return frame if pose.pose_source == 'tf' and frame in taken else ''

    @property
    def names(self) -> list[str]:
        """Names of the colors."""
        return [kind.name for kind in self.config.colors]


class Seen(NamedTuple):
    """A picture, with all data that belong to it.

    :param camera: index of the camera that took it.
    """

    camera: int
    tracks: Tracks
    detections: Detections
    view: View
    depth: Depth | None


class LocatorNode(ManagedNode[LocatorSetup]):
    """Takes tracks, detections, calibration and poses; publishes objects in meters per picture."""

    def __init__(self, **options: Any) -> None:
        super().__init__('locator', LocatorSetup, **options)

    def configure(self) -> None:
        """Create the locator, its publishers and its subscriptions."""
        setup, feeds = self.setup, self.setup.feed.each
        if setup.feed.pose.fixed_frame == MAP and setup.feed.pose.pose_source != 'fixed':
            self.get_logger().warning(MAP_JUMPS)
        if names := ', '.join(setup.config.heightless):
            self.get_logger().warning(HEIGHTLESS.format(names))
        hijacked = setup.hijacks
        if hijacked:
            self.get_logger().error(HIJACKED.format(hijacked))
        self.health = Health(self, objects=lambda: self._output.alive)
        self._locator = Locator(setup.seen_as, self.health.refuse, len(feeds))
        self._calibrations = CalibrationWatch()
        self._selector = Selector(setup.output.select, setup.names)
        self._order: Interleaving[Seen] = Interleaving(
            len(feeds), self._locate, self.health.refuse, seconds_of(self)
        )
        self._feeds = [
            CameraFeed(
                self, feed, self._taker(camera), self.health.took_in, self.health.refuse,
                needs_depth=setup.config.method in ('depth', 'fused'),
            )
            for camera, feed in enumerate(feeds)
        ]  # fmt: skip
        self._output = LocationsOutput(
            self, setup.output, setup.names,
            tf=setup.feed.pose.pose_source == 'tf' and not hijacked,
        )  # fmt: skip
        self.create_subscription(String, '~/select', self._select, 10)
        self.create_timer(IDLE, self._look, clock=STEADY)

    def set_active(self, active: bool) -> None:
        """Accept tracks, or drop them."""
        for feed in self._feeds:
            feed.active = active

    def _taker(self, camera: int) -> Callable[[Tracks, Detections, View, Depth | None], object]:
        """Return the callback for the pictures of a camera."""
        return lambda tracks, *rest: self._order.put(
            camera, tracks.stamp, Seen(camera, tracks, *rest)
        )

    def _locate(self, seen: Seen) -> None:
        """Locate and publish; reset the locator if that fails."""
        try:
            self._publish(seen)
        except Exception as error:
            self._locator.reset()
            self.tell_fault(error)

    def _publish(self, seen: Seen) -> None:
        tracks = seen.tracks
        with self.lock:
            if line := self._calibrations.see(seen.camera, seen.view.camera):
                self._locator.configure(self.setup.seen_as)
                self.get_logger().warning(line)
            locations = self._locator.update(
                tracks, seen.detections, seen.view, seen.depth, seen.camera
            )
            if self.setup.output.predict_to_now:
                locations = self._locator.locations(self._now(tracks.stamp))
            locations = replace(locations, frame_id=self.setup.feed.pose.fixed_frame)
            self._output.publish(locations, tracks, self._selector, seen.view.base.t)
        self.health.note(self._locator.doubt)
        self.health.gave_out(tracks.stamp)

    def _now(self, stamp: int) -> int:
        """Return the time [ns] to which objects of a picture are predicted."""
        now = self.get_clock().now().nanoseconds
        if now - stamp > GAP * NANOSECONDS:  # its stamp is of another clock, as that of a bag
            self.health.refuse(
                f'predict_to_now: the picture is {(now - stamp) / NANOSECONDS:.0f} s old by the '
                'clock of this node: objects are where they were in it (use_sim_time, or another '
                'clock?)'
            )
            return stamp
        return max(now, stamp)

    def _select(self, message: String) -> None:
        try:
            self._selector = Selector(message.data, self.setup.names)
        except ValueError as error:
            self.health.refuse(str(error))

    def _look(self) -> None:
        for feed in self._feeds:
            feed.look()
        self._order.look()

    def apply(self, setup: LocatorSetup) -> None:
        """Apply changed parameters."""
        if setup.config != self.setup.config or setup.feed != self.setup.feed:
            self._locator.configure(setup.seen_as)
        if setup.output.select != self.setup.output.select:
            self._selector = Selector(setup.output.select, setup.names)
        for feed, config in zip(self._feeds, setup.feed.each, strict=True):
            feed.configure(config)


def main() -> int:
    """Run the node."""
    return run(lambda _: [LocatorNode()])
