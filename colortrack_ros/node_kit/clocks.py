"""The clock of a node, real or simulated."""

from collections.abc import Callable
from typing import Any

from rclpy.clock import Clock
from rclpy.clock import ClockType
from rclpy.node import Node

from colortrack_ros.data import NANOSECONDS

STEADY = Clock(clock_type=ClockType.STEADY_TIME)
"""A clock for timers: a simulated clock may stand still."""

CLOCK_LOOKED_EVERY = 0.02
"""Interval [s] at which the first time is looked for: shorter than the period of any picture."""


def seconds_of(node: Node) -> Callable[[], float]:
    """A function that returns a time [s].

    It is monotonic; with use_sim_time it is that of /clock, which stops while a bag is paused and
    goes back when it loops.
    """

    def now() -> float:
        clock = node.get_clock() if _is_simulated(node) else STEADY
        return float(clock.now().nanoseconds / NANOSECONDS)

    return now


class Elapsed:
    """The time [s] that has elapsed on a node's clock, without its jumps.

    Neither a change of use_sim_time nor a looping bag, for which /clock goes back, makes it jump.
    """

    def __init__(self, node: Node) -> None:
        self._node, self._now = node, seconds_of(node)
        self._passed, self._last, self._simulated = 0.0, self._now(), _is_simulated(node)

    def __call__(self) -> float:
        """The elapsed time since this object was created."""
        now, simulated = self._now(), _is_simulated(self._node)
        if simulated == self._simulated:
            self._passed += max(now - self._last, 0.0)
        self._last, self._simulated = now, simulated
        return self._passed


def lacks_clock(node: Node) -> bool:
    """Whether the node uses simulated time but nobody publishes it, as when a bag has ended."""
    return _is_simulated(node) and node.count_publishers('/clock') == 0


def await_clock(node: Node, wait: Callable[[float], bool]) -> None:
    """Wait until simulated time, if the node uses it, has come: before, it is 0.

    :param wait: waits for so long [s]; returns whether to give up.
    """
    if _is_timeless(node):
        node.get_logger().info('use_sim_time is true: waits for the first message on /clock')
    while _is_timeless(node) and not wait(CLOCK_LOOKED_EVERY):
        pass


def _is_timeless(node: Node) -> bool:
    return _is_simulated(node) and node.get_clock().now().nanoseconds == 0


def _is_simulated(node: Node) -> bool:
    clock: Any = node.get_clock()  # rclpy types the ROSClock as a Clock
    return bool(clock.ros_time_is_active)
