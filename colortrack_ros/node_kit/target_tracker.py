"""The base of nodes that follow given targets in pictures."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol
from typing import TypeVar

from sensor_msgs.msg import PointCloud2

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import Tracks
from colortrack_ros.encodings import size_of
from colortrack_ros.estimation.waiting_boxes import WaitingBoxes
from colortrack_ros.flow.pairing import Pair
from colortrack_ros.flow.stage import Stage
from colortrack_ros.flow.stage import Worker
from colortrack_ros.messages import detections_of_serialized_cloud
from colortrack_ros.node_kit.diagnostics import WARN
from colortrack_ros.node_kit.image_tracker import ImageTracker
from colortrack_ros.node_kit.image_tracker import ImageTrackerNode
from colortrack_ros.node_kit.image_tracker import ImageTrackerSetup
from colortrack_ros.node_kit.intake import worker_of
from colortrack_ros.node_kit.topics import subscribe_to
from colortrack_ros.node_kit.topics import topic_name
from colortrack_ros.parameters import parameter

LONE_PICTURES = 150
"""How many pictures on end without their detections are told: 5 s at 30 Hz. Assumed: a detector
that starts along with the camera is there by then."""


@dataclass(frozen=True)
class TargetTrackerSetup(ImageTrackerSetup):
    """The parameters of such a node; its own follow those of its room."""

    targets: tuple[float, ...] = parameter(
        float,
        'Boxes of the targets in the first picture, u, v of the top left pixel, width, height, one '
        'after the other; if they are set later, those in the next picture.',
        unit='px',
        limits=(-1e5, 1e5),
    )
    detections_topic: str = topic_name('', 'detections that start targets; empty: none')

    def check(self) -> None:
        """Four numbers for each target."""
        sizes = (*self.targets[2::4], *self.targets[3::4])
        if len(self.targets) % 4 or any(size < 1 for size in sizes):
            raise ValueError(
                'targets: expected u, v, width, height of each box, at least 1 px, '
                f'got {list(self.targets)}'
            )


class TargetTracker(ImageTracker, Protocol):
    """The interface of a tracker of images with targets."""

    waiting: WaitingBoxes


TargetSetup = TypeVar('TargetSetup', bound=TargetTrackerSetup)


class TargetTrackerNode(ImageTrackerNode[TargetSetup]):
    """Follows the parameter ``targets``, and targets that detections start.

    With ``detections_topic``, pictures wait for their detections before they are due. A subclass
    implements :meth:`make`.
    """

    tracker: TargetTracker

    def configure(self) -> None:
        """Create what every such node has, and subscribe to detections."""
        super().configure()
        self._alone, self._detected = 0, 'nothing has come'
        if self.setup.detections_topic:
            subscribe_to(
                self,
                PointCloud2,
                self.setup.detections_topic,
                self._take_detections,
                self.health.refuse,
            )

    def renew(self, setup: TargetSetup) -> None:
        """Let the tracker begin anew, with the targets of now."""
        self.tracker.waiting.targets = setup.targets
        super().renew(setup)

    def facts(self) -> dict[str, Callable[[], object]]:
        """Further values for the diagnostics."""
        return {
            'refused_targets': lambda: self.tracker.waiting.refused,
            'skipped_pairs': lambda: getattr(self._tracking, 'skipped', 0),
        }

    def troubles(self) -> tuple[tuple[str, ...], bytes]:
        """As of every such node; and that pictures wait in vain, by which all tracks are late."""
        troubles, level = super().troubles()
        if self._alone < LONE_PICTURES:
            return (*troubles, ''), level
        topic = self.resolve_topic_name(self.setup.detections_topic)
        waits = (
            f'pictures wait in vain for detections of their stamps on {topic}: there '
            f'{self._detected}; so no detection starts a target, and tracks come late'
        )
        return (*troubles, waits), level if any(troubles) else WARN

    def make_tracking(self) -> Stage[Pair, Tracks]:
        """The chain for pictures; with ``detections_topic`` they wait for their detections."""
        if self.setup.detections_topic:
            name, intake = f'{self.get_name()}_pairs', self.setup.intake
            return worker_of(self, self._track, self.health.refuse, intake, name)
        return super().make_tracking()

    def apply(self, setup: TargetSetup) -> None:
        """Apply changed parameters, between two pictures."""
        if setup.targets != self.setup.targets:
            self.tracker.waiting.name(setup.targets)
        super().apply(setup)
        if isinstance(self._tracking, Worker):
            self._tracking.max_lag = setup.intake.max_lag

    def _track(self, pair: Pair) -> Tracks:
        waits = self.setup.detections_topic and pair.detections is None
        self._alone = self._alone + 1 if waits else 0
        waiting = self.tracker.waiting
        refused = waiting.refused
        tracks = super()._track(pair)
        if waiting.refused > refused and waiting.took_named:
            height, width = size_of(pair.frame)
            self.health.refuse(
                f'{waiting.refused - refused} of the targets: expected boxes whose middle is '
                f'inside the picture, {width}x{height}, of some size and texture, and no more than '
                'max_targets'
            )
        return tracks

    def _take_detections(self, cdr: bytes) -> None:
        if self.active:
            detections = detections_of_serialized_cloud(cdr)
            self._detected = f'the last was at {detections.stamp / NANOSECONDS:.3f} s'
            self._chain.put(detections)
