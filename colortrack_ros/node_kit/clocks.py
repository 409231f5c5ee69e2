"""The clock of a node, real or simulated."""

from collections.abc import Callable
from typing import Any

from rclpy.clock import Clock
from rclpy.clock import ClockType
from rclpy.node import Node

from colortrack_ros.data import NANOSECONDS

STEADY = Clock(clock_type=ClockType.STEADY_TIME)
"""For timers: a simulated clock may stand still."""


def seconds_of(node: Node) -> Callable[[], float]:
    """A function that returns the time [s] since some moment.

    It is steady; with use_sim_time it is that of /clock, which stops while a bag is paused and goes
    back when it loops.
    """

    def now() -> float:
        clock = node.get_clock() if _is_simulated(node) else STEADY
        return float(clock.now().nanoseconds / NANOSECONDS)

    return now


def lacks_clock(node: Node) -> bool:
    """Whether the node uses simulated time and nobody publishes it, as when a bag has ended."""
    return _is_simulated(node) and node.count_publishers('/clock') == 0


def _is_simulated(node: Node) -> bool:
    clock: Any = node.get_clock()  # rclpy types the ROSClock as a Clock
    return bool(clock.ros_time_is_active)
