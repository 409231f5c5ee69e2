"""What all nodes have in common that take images and publish tracks."""

from collections.abc import Callable
from collections.abc import Mapping
from dataclasses import dataclass
import threading
from typing import Any
from typing import Protocol

from rclpy.node import Node
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from colortrack_ros.data import Frame
from colortrack_ros.data import Tracks
from colortrack_ros.messages import cloud_of_tracks
from colortrack_ros.messages import MarkerWriter
from colortrack_ros.nodes.health import HEALTH
from colortrack_ros.nodes.health import Health
from colortrack_ros.nodes.intake import ImageIntake
from colortrack_ros.nodes.intake import INTAKE
from colortrack_ros.nodes.live_parameters import declare
from colortrack_ros.nodes.parameters import ParameterTable
from colortrack_ros.nodes.parameters import Spec
from colortrack_ros.nodes.topics import DEPTH
from colortrack_ros.nodes.topics import PICTURE_DEPTH
from colortrack_ros.nodes.topics import publish_on
from colortrack_ros.nodes.topics import topic

IMAGE_TRACKER = (
    Spec(
        'marker_scale',
        0.01,
        'Size of a pixel in the markers.',
        unit='m/px',
        minimum=1e-9,
        maximum=1e3,
    ),
    *INTAKE,
    topic('tracks_topic', 'tracks', 'the tracks that are published'),
    topic('markers_topic', 'tracks/markers', 'the markers that are published'),
    PICTURE_DEPTH,
    DEPTH,
    *HEALTH,
)
"""The rows that the table of such a node ends with."""


@dataclass(frozen=True)
class ImageTrackerSetup:
    """The values of these rows, and the configuration of the room.

    :param config: what the tracker of the room is configured with.
    """

    config: Any
    marker_scale: float
    max_lag: float
    reorder_window: float
    max_late: float
    image_topic: str
    image_transport: str
    tracks_topic: str
    markers_topic: str


class ImageTracker(Protocol):
    """What the room of such a node gives it."""

    def update(self, frame: Frame) -> Tracks:
        """Take the next frame."""

    def configure(self, config: Any) -> None:
        """Take another configuration."""

    def reset(self, why: str) -> None:
        """Drop all tracks; the next ones are marked as restarted, with this reason."""


class ImageTrackerNode(Node):
    """Images in, one message of tracks and one of markers for each that it works on out.

    A node of its own has :meth:`make`, and overrides :meth:`facts`, :meth:`take` and :meth:`apply`
    where it has more to tell or to do.

    :param name: of the node.
    :param table: its parameters, with the rows IMAGE_TRACKER.
    :param build: makes an ImageTrackerSetup, or one with more, of their values.
    :param subscribe: whether images come from ``image_topic``, or by :meth:`process` alone.
    """

    def __init__(
        self,
        name: str,
        table: ParameterTable,
        build: Callable[[Mapping[str, Any]], ImageTrackerSetup],
        *,
        subscribe: bool = True,
        **options: Any,
    ) -> None:
        super().__init__(name, allow_undeclared_parameters=True, **options)
        self._lock = threading.Lock()  # images and parameters come from two threads
        self.setup: Any = declare(self, table, build, self._apply)
        self.tracker = self.make(self.setup)
        self._markers, self._alive = MarkerWriter(), 0
        self.health = Health(
            self,
            str,
            skipped=lambda: self._intake.skipped,
            tracks=lambda: self._alive,
            **self.facts(),
        )
        self._intake: ImageIntake = ImageIntake(self, self.take, self.health.refuse)
        self._intake.configure(self.setup)
        self._tracks_publisher = publish_on(self, PointCloud2, self.setup.tracks_topic)
        self._markers_publisher = publish_on(self, MarkerArray, self.setup.markers_topic)
        self.create_service(Trigger, '~/reset', self._reset)
        if subscribe:
            self._intake.subscribe(self.setup.image_topic, self.setup.image_transport)

    def make(self, setup: Any) -> ImageTracker:
        """The tracker of the room."""
        raise NotImplementedError

    def facts(self) -> dict[str, Callable[[], object]]:
        """Further values for the diagnostics."""
        return {}

    def take(self, frame: Frame) -> None:
        """A picture whose turn it is, in the thread that works."""
        self.process(frame)

    def apply(self, setup: Any) -> None:
        """Take changed parameters into use, while no picture is worked on."""
        if setup.config != self.setup.config:
            self.tracker.configure(setup.config)

    def process(self, frame: Frame) -> None:
        """Track and publish."""
        self.health.took_in()
        with self._lock:
            tracks = self.tracker.update(frame)
            scale = self.setup.marker_scale
        self._alive = len(tracks.rows)
        if tracks.restarted:
            self.get_logger().warning(
                f'The tracker started afresh: {tracks.restarted}', throttle_duration_sec=1.0
            )
        self._tracks_publisher.publish(cloud_of_tracks(tracks))
        self._markers_publisher.publish(self._markers.write(tracks, scale))
        self.health.gave_out(tracks.stamp)

    def _reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        with self._lock:
            self.tracker.reset('a call of ~/reset')
        response.success = True
        response.message = 'all tracks are dropped with the next picture'
        return response

    def _apply(self, setup: Any) -> None:
        with self._lock:
            self.apply(setup)
            self.setup = setup
        self._intake.configure(setup)

    def close(self) -> None:
        """End the thread that works."""
        self._intake.close()
