"""The time that passes for a node."""

from collections.abc import Callable
from typing import Any

from rclpy.clock import Clock
from rclpy.clock import ClockType
from rclpy.node import Node

from colortrack_ros.data import NANOSECONDS

STEADY = Clock(clock_type=ClockType.STEADY_TIME)
"""For timers: a simulated clock may stand still."""


def seconds_of(node: Node) -> Callable[[], float]:
    """Where to read the time [s] since some moment.

    It is steady; with use_sim_time it is that of /clock, which stands still while a bag is paused
    and goes back when it loops.
    """

    def now() -> float:
        clock = node.get_clock() if _is_simulated(node) else STEADY
        return float(clock.now().nanoseconds / NANOSECONDS)

    return now


def lacks_clock(node: Node) -> bool:
    """Whether the node uses the simulated time and nobody tells it, as when a bag has ended."""
    return _is_simulated(node) and node.count_publishers('/clock') == 0


def _is_simulated(node: Node) -> bool:
    clock: Any = node.get_clock()  # what rclpy types as Clock is a ROSClock
    return bool(clock.ros_time_is_active)
