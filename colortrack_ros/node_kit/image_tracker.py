"""The base of nodes that take images and publish tracks."""

from abc import ABC
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any
from typing import Protocol
from typing import TypeVar

from std_srvs.srv import Trigger

from colortrack_ros.chain import ImageChain
from colortrack_ros.chain import track_pair
from colortrack_ros.data import Frame
from colortrack_ros.data import Tracks
from colortrack_ros.flow.pairing import Pair
from colortrack_ros.flow.stage import Stage
from colortrack_ros.flow.stage import Worker
from colortrack_ros.node_kit.diagnostics import ERROR
from colortrack_ros.node_kit.diagnostics import Health
from colortrack_ros.node_kit.intake import configure
from colortrack_ros.node_kit.intake import IntakeConfig
from colortrack_ros.node_kit.intake import receive_images
from colortrack_ros.node_kit.intake import whole_updates
from colortrack_ros.node_kit.intake import worker_of
from colortrack_ros.node_kit.managed import CONFIGURED_AGAIN
from colortrack_ros.node_kit.managed import ManagedNode
from colortrack_ros.node_kit.node_setup import NodeSetup
from colortrack_ros.node_kit.services import offer
from colortrack_ros.node_kit.topics import PictureQueueConfig
from colortrack_ros.node_kit.tracks_output import TracksOutput
from colortrack_ros.node_kit.tracks_output import TracksOutputConfig
from colortrack_ros.parameters import part

Setup = TypeVar('Setup', bound='ImageTrackerSetup')


@dataclass(frozen=True)
class ImageTrackerSetup(NodeSetup):
    """The parameters of such a node; its own follow those of its room.

    :param config: what the tracker of the room is configured with, a part.
    """

    config: Any = None
    intake: IntakeConfig = part(IntakeConfig)
    output: TracksOutputConfig = part(TracksOutputConfig)
    pictures: PictureQueueConfig = part(PictureQueueConfig)


class ImageTracker(Protocol):
    """The interface of a tracker of images.

    :ivar trouble: why it finds nothing new in the last picture, empty if it may.
    """

    trouble: str

    def update(self, frame: Frame) -> Tracks:
        """Return the tracks after the next frame."""

    def configure(self, config: Any) -> None:
        """Apply another configuration."""

    def reset(self, why: str) -> None:
        """Drop all tracks; the next ones are marked as restarted, with this reason."""


class ImageTrackerNode(ManagedNode[Setup], ABC):
    """Takes images and publishes one message of tracks and one of markers for each that it
    processes.

    A subclass implements :meth:`make`, and may extend :meth:`renew`, :meth:`facts`,
    :meth:`troubles`, :meth:`make_tracking` and :meth:`apply`.

    :param name: of the node.
    :param config: its parameters.
    """

    def __init__(self, name: str, config: type[Setup], **options: Any) -> None:
        super().__init__(name, config, **options)

    def configure(self) -> None:
        """Create the tracker, publishers, services and subscriptions."""
        if self.configured_before:
            self.renew(self.setup)
        else:
            self.tracker = self.make(self.setup)
        self.health = Health(
            self,
            str,
            lost=lambda: self.health.losses.total,
            skipped=lambda: self._pictures.skipped,
            tracks=lambda: self._output.alive,
            **self.facts(),
        )
        self._pictures: Worker[Frame, Frame] = worker_of(
            self, lambda frame: frame, self.health.refuse, self.setup.intake
        )
        self._tracking = self.make_tracking()
        self._tracking.then(self._publish)
        detects = isinstance(self._tracking, Worker)
        self._chain = ImageChain(
            self._pictures,
            self._tracking,
            detects=detects,
            most=self.setup.pictures.image_queue_depth,
        )
        self._output = TracksOutput(self, self.setup.output)
        offer(self, Trigger, '~/reset', self._reset)
        receive_images(
            self, self._pictures, self.setup.intake, self.health.refuse, self.health.losses
        )

    def set_active(self, active: bool) -> None:
        """Process pictures, or drop them."""
        self._pictures.paused = not active

    @abstractmethod
    def make(self, setup: Setup) -> ImageTracker:
        """Create the tracker."""

    def renew(self, setup: Setup) -> None:
        """Let the tracker begin anew, with IDs that nobody knows yet."""
        self.tracker.configure(setup.config)
        self.tracker.reset(CONFIGURED_AGAIN)

    def facts(self) -> dict[str, Callable[[], object]]:
        """Further values for the diagnostics."""
        return {}

    def troubles(self) -> tuple[tuple[str, ...], bytes]:
        """What is wrong with the last picture, as for Health.note, and the level of the worst."""
        return (self.tracker.trouble,), ERROR

    def make_tracking(self) -> Stage[Pair, Tracks]:
        """The chain for pictures that wait for nothing; it runs in the thread that reads them."""
        return Stage(self._track, self.health.refuse)

    def apply(self, setup: Setup) -> None:
        """Apply changed parameters, between two pictures."""
        if setup.config != self.setup.config:
            self.tracker.configure(setup.config)
        configure(self._pictures, setup.intake)

    def _track(self, pair: Pair) -> Tracks:
        self.health.took_in()
        with self.lock, whole_updates(self.tracker):
            tracks = track_pair(self.tracker, pair)
        troubles, level = self.troubles()
        self.health.note(*troubles, level=level)
        return tracks

    def _publish(self, tracks: Tracks, _: object) -> None:
        self._output.publish(tracks, self.setup.output.marker_scale)
        self.health.gave_out(tracks.stamp)

    def _reset(self, _: Trigger.Request) -> str:
        with self.lock:
            self.tracker.reset('a call of ~/reset')
        return 'all tracks are dropped with the next picture'

    def release(self) -> None:
        """Stop the worker threads."""
        self._pictures.close()
        self._tracking.close()
