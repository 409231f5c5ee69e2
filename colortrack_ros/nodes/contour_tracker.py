"""The contour tracker node: tracks moving objects by their contours."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from std_srvs.srv import Trigger

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours import ContourTracker
from colortrack_ros.node_kit.runtime import run
from colortrack_ros.node_kit.services import offer
from colortrack_ros.node_kit.target_tracker import TargetTrackerNode
from colortrack_ros.node_kit.target_tracker import TargetTrackerSetup
from colortrack_ros.node_kit.tracks_output import OutlinesOutputConfig
from colortrack_ros.parameters import part


@dataclass(frozen=True)
class ContourTrackerSetup(TargetTrackerSetup):
    """The parameters of the contour tracker node."""

    config: ContourConfig = part(ContourConfig)
    output: OutlinesOutputConfig = part(OutlinesOutputConfig)


class ContourTrackerNode(TargetTrackerNode[ContourTrackerSetup]):
    """Tracks the contours of targets that move, or that a user or node names.

    Takes images; publishes one message of tracks, outlines, and markers for each that it processes.
    """

    tracker: ContourTracker

    def __init__(self, **options: Any) -> None:
        super().__init__('contour_tracker', ContourTrackerSetup, **options)

    def configure(self) -> None:
        """Create what every target tracker has, and the service."""
        super().configure()
        offer(self, Trigger, '~/learn_background', self._learn_background)

    def facts(self) -> dict[str, Callable[[], object]]:
        """Return additional values for the diagnostics."""
        return {**super().facts(), 'scene_changes': lambda: self.tracker.scene_changes}

    def make(self, setup: ContourTrackerSetup) -> ContourTracker:
        """Return a contour tracker."""
        return ContourTracker(setup.config, setup.targets)

    def renew(self, setup: ContourTrackerSetup) -> None:
        """Let the tracker begin anew, with the background of now."""
        super().renew(setup)
        self.tracker.learn_background()

    def _learn_background(self, _: Trigger.Request) -> str:
        with self.lock:
            self.tracker.learn_background()
        return 'the background is learned anew from the next picture on'


def main() -> int:
    """Run the node."""
    return run(lambda _: [ContourTrackerNode()])
