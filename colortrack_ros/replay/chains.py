"""What ``replay`` runs: the rooms behind the nodes, joined as the nodes are by their topics."""

from abc import ABC
from abc import abstractmethod
from collections.abc import Callable
from functools import partial
from typing import Any

from colortrack_ros.contours import ContourTracker
from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.data import Tracks
from colortrack_ros.detection import Detector
from colortrack_ros.flow.order import Order
from colortrack_ros.flow.order import OrderConfig
from colortrack_ros.flow.pairing import Pairing
from colortrack_ros.node_kit.image_tracker import ImageTracker
from colortrack_ros.node_kit.image_tracker import ImageTrackerSetup
from colortrack_ros.nodes.tracker import TrackerSetup
from colortrack_ros.nodes.window_tracker import offer
from colortrack_ros.replay.recordings import Item
from colortrack_ros.replay.setup import Setup
from colortrack_ros.tracking import Tracker
from colortrack_ros.windows import WindowTracker


class Chain(ABC):
    """From recorded messages, as they arrive, to tracks.

    :param setup: of the nodes.
    :param detected: takes an item and what was detected in it.
    :param tracked: takes an item and the tracks after it.
    :param drop: takes the reason why something came too late.
    """

    def __init__(
        self,
        setup: Setup,
        detected: Callable[[Item, Detections], object],
        tracked: Callable[[Item, Tracks], object],
        drop: Callable[[str], object],
    ) -> None:
        self._detected, self._tracked, self._drop = detected, tracked, drop
        self._orders: list[Order[Any]] = []

    @abstractmethod
    def push(self, item: Item) -> None:
        """Take the next message."""

    def flush(self) -> None:
        """Work on what waits for its place: nothing more comes."""
        for order in self._orders:
            order.flush()

    def _ordered(self, config: OrderConfig, release: Callable[[Any], object]) -> Order[Any]:
        """The order into which a node with this configuration puts what it takes."""
        order: Order[Any] = Order(release, self._drop)
        order.configure(config)
        self._orders.append(order)
        return order


class ColorChain(Chain):
    """Detector and tracker, or the tracker alone for recorded detections."""

    def __init__(self, setup: Setup, *outputs: Any) -> None:
        super().__init__(setup, *outputs)
        assert isinstance(setup.tracker, TrackerSetup)
        self._tracker = Tracker(setup.tracker.config)
        if setup.detector:
            self._detector = Detector(setup.detector.config)
            self._pictures = self._ordered(setup.detector.intake.order, self._detect)
        self._detections = self._ordered(setup.tracker.order, self._track)

    def push(self, item: Item) -> None:
        """Take the next message."""
        if isinstance(item.content, Frame):
            self._pictures.push(item.stamp, item)
        else:
            self._give(item, item.content)

    def _detect(self, item: Item) -> None:
        assert isinstance(item.content, Frame)
        self._give(item, self._detector.detect(item.content))

    def _give(self, item: Item, detections: Detections) -> None:
        self._detected(item, detections)
        self._detections.push(item.stamp, (item, detections))

    def _track(self, pair: tuple[Item, Detections]) -> None:
        self._tracked(pair[0], self._tracker.update(pair[1]))


class ImageChain(Chain):
    """A tracker that takes pictures, beside a detector where detections start its targets."""

    def __init__(self, make: Callable[[Any], ImageTracker], setup: Setup, *outputs: Any) -> None:
        super().__init__(setup, *outputs)
        assert isinstance(setup.tracker, ImageTrackerSetup)
        self._tracker: Any = make(setup.tracker)
        self._pairing: Pairing[Item] = Pairing()
        self._pictures = self._ordered(setup.tracker.intake.order, self._take)
        self._detector = Detector(setup.detector.config) if setup.detector else None
        if setup.detector:
            self._to_detect = self._ordered(setup.detector.intake.order, self._detect)

    def push(self, item: Item) -> None:
        """Take the next message."""
        self._pictures.push(item.stamp, item)
        if self._detector:
            self._to_detect.push(item.stamp, item)

    def _take(self, item: Item) -> None:
        if self._detector:
            self._track(self._pairing.put_frame(item))
        else:
            self._track([(item, None)])

    def _detect(self, item: Item) -> None:
        assert isinstance(item.content, Frame)
        assert self._detector
        detections = self._detector.detect(item.content)
        self._detected(item, detections)
        self._track(self._pairing.put_detections(detections))

    def _track(self, pairs: list[tuple[Item, Detections | None]]) -> None:
        for item, detections in pairs:
            if detections is not None:
                offer(self._tracker, detections)
            self._tracked(item, self._tracker.update(item.content))


def _window_tracker(setup: Any) -> WindowTracker:
    return WindowTracker(setup.config, setup.targets)


def _contour_tracker(setup: ImageTrackerSetup) -> ContourTracker:
    return ContourTracker(setup.config)


CHAINS: dict[str, Callable[..., Chain]] = {
    'tracker': ColorChain,
    'window_tracker': partial(ImageChain, _window_tracker),
    'contour_tracker': partial(ImageChain, _contour_tracker),
}
"""By the name of the node that publishes the tracks."""
