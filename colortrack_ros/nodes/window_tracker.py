"""The node that follows targets by what they look like."""

from dataclasses import dataclass
from typing import Any

from colortrack_ros.node_kit.runtime import run
from colortrack_ros.node_kit.target_tracker import TargetTrackerNode
from colortrack_ros.node_kit.target_tracker import TargetTrackerSetup
from colortrack_ros.parameters import part
from colortrack_ros.windows import WindowConfig
from colortrack_ros.windows import WindowTracker


@dataclass(frozen=True)
class WindowTrackerSetup(TargetTrackerSetup):
    """The parameters of the window tracker node."""

    config: WindowConfig = part(WindowConfig)


class WindowTrackerNode(TargetTrackerNode[WindowTrackerSetup]):
    """Targets that somebody names, followed by their windows."""

    tracker: WindowTracker

    def __init__(self, **options: Any) -> None:
        super().__init__('window_tracker', WindowTrackerSetup, **options)

    def make(self, setup: WindowTrackerSetup) -> WindowTracker:
        """The tracker of the room."""
        return WindowTracker(setup.config, setup.targets)


def main() -> int:
    """Run the node."""
    return run(lambda _: [WindowTrackerNode()])
