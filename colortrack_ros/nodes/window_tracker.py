"""The node that follows targets by what they look like."""

from collections.abc import Callable
from dataclasses import dataclass
import threading
import time
from typing import Any

import numpy as np
from sensor_msgs.msg import PointCloud2

from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.flow.backlog import Backlog
from colortrack_ros.flow.pairing import Pairing
from colortrack_ros.messages import detections_of_serialized_cloud
from colortrack_ros.messages import MessageError
from colortrack_ros.node_kit.image_tracker import ImageTrackerNode
from colortrack_ros.node_kit.image_tracker import ImageTrackerSetup
from colortrack_ros.node_kit.runtime import run
from colortrack_ros.node_kit.topics import subscribe_to
from colortrack_ros.node_kit.topics import topic_name
from colortrack_ros.parameters import parameter
from colortrack_ros.parameters import part
from colortrack_ros.windows import WindowConfig
from colortrack_ros.windows import WindowTracker

Pair = tuple[Frame, Detections | None]


@dataclass(frozen=True)
class WindowTrackerSetup(ImageTrackerSetup):
    """The parameters of the window tracker node."""

    config: WindowConfig = part(WindowConfig)
    targets: tuple[float, ...] = parameter(
        float,
        'Boxes in the first picture, u, v of the top left pixel, width, height, of one target '
        'after the other; set later, they start in the next picture.',
        unit='px',
        minimum=-1e5,
        maximum=1e5,
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


class WindowTrackerNode(ImageTrackerNode[WindowTrackerSetup]):
    """Targets of the parameter ``targets``, and those that detections start.

    With ``detections_topic``, pictures wait for their detections, and then for their turn.
    """

    tracker: WindowTracker

    def __init__(self, **options: Any) -> None:
        self._pairing: Pairing[Frame] = Pairing()
        self._pairing_lock = threading.Lock()
        self._pairs: Backlog[Pair] = Backlog()
        self._pair_worker = threading.Thread(target=self._work, name='window_tracker_pairs')
        super().__init__('window_tracker', WindowTrackerSetup, **options)
        self._pairs.max_lag = self.setup.intake.max_lag
        if self.setup.detections_topic:
            subscribe_to(self, PointCloud2, self.setup.detections_topic, self._take_detections)
            self._pair_worker.start()

    def make(self, setup: WindowTrackerSetup) -> WindowTracker:
        """The tracker of the room."""
        return WindowTracker(setup.config, setup.targets)

    def facts(self) -> dict[str, Callable[[], object]]:
        """Further values for the diagnostics."""
        return {
            'refused_targets': lambda: self.tracker.refused,
            'skipped_pairs': lambda: self._pairs.skipped,
        }

    def take(self, frame: Frame) -> None:
        """A picture whose turn it is, in the thread that reads them."""
        if self.setup.detections_topic:
            self._put(self._pairing.put_frame, frame)
        else:
            self.process(frame)

    def apply(self, setup: WindowTrackerSetup) -> None:
        """Take changed parameters into use, while no picture is worked on."""
        if setup.targets != self.setup.targets:
            self.tracker.start(setup.targets)
            self.tracker.targets = np.array(setup.targets).reshape(-1, 4)
        super().apply(setup)
        self._pairs.max_lag = setup.intake.max_lag

    def _take_detections(self, cdr: bytes) -> None:
        try:
            self._put(self._pairing.put_detections, detections_of_serialized_cloud(cdr))
        except MessageError as error:
            self.health.refuse(str(error))

    def _put(self, into: Callable[[Any], list[Pair]], item: Frame | Detections) -> None:
        with self._pairing_lock:  # pictures and detections come from two threads
            for pair in into(item):
                self._pairs.put(pair)

    def _work(self) -> None:
        while (pair := self._pairs.get()) is not None:
            start = time.monotonic()
            frame, detections = pair
            if detections is not None:
                with self.lock:
                    offer(self.tracker, detections)
            self.process(frame)
            self._pairs.took(time.monotonic() - start)

    def close(self) -> None:
        """End the threads that work."""
        super().close()
        self._pairs.close()
        if self._pair_worker.is_alive():
            self._pair_worker.join()


def offer(tracker: WindowTracker, detections: Detections) -> None:
    """Have the tracker start targets in the next frame, of which these are."""
    names = ('box_u', 'box_v', 'box_w', 'box_h')
    tracker.offer(np.stack([detections.rows[name] for name in names], axis=1))


def main() -> int:
    """Run the node."""
    return run(lambda _: [WindowTrackerNode()])
