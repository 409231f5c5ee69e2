"""What all nodes have in common that take images and publish tracks."""

from abc import ABC
from abc import abstractmethod
from collections.abc import Callable
from collections.abc import Mapping
from dataclasses import dataclass
import threading
from typing import Any
from typing import Protocol

from rclpy.node import Node
from std_srvs.srv import Trigger

from colortrack_ros.data import Frame
from colortrack_ros.data import Tracks
from colortrack_ros.node_kit.diagnostics import HEALTH
from colortrack_ros.node_kit.diagnostics import Health
from colortrack_ros.node_kit.intake import ImageIntake
from colortrack_ros.node_kit.intake import INTAKE
from colortrack_ros.node_kit.live_parameters import declare
from colortrack_ros.node_kit.topics import DEPTH
from colortrack_ros.node_kit.topics import PICTURE_DEPTH
from colortrack_ros.node_kit.tracks_output import MARKER_SCALE
from colortrack_ros.node_kit.tracks_output import TRACKS_OUT
from colortrack_ros.node_kit.tracks_output import TracksOutput
from colortrack_ros.parameters import ParameterTable

IMAGE_TRACKER = (
    MARKER_SCALE,
    *INTAKE,
    *TRACKS_OUT,
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


class ImageTrackerNode(Node, ABC):
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
        self.health = Health(
            self,
            str,
            skipped=lambda: self._intake.skipped,
            tracks=lambda: self._output.alive,
            **self.facts(),
        )
        self._intake: ImageIntake = ImageIntake(self, self.take, self.health.refuse)
        self._intake.configure(self.setup)
        self._output = TracksOutput(self, self.setup)
        self.create_service(Trigger, '~/reset', self._reset)
        if subscribe:
            self._intake.subscribe(self.setup.image_topic, self.setup.image_transport)

    @abstractmethod
    def make(self, setup: Any) -> ImageTracker:
        """The tracker of the room."""

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
        self._output.publish(tracks, scale)
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
