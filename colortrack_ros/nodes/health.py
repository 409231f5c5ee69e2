"""What an operator sees of a node: counters on /diagnostics and throttled log lines."""

from collections.abc import Callable
from statistics import median
import threading

from diagnostic_msgs.msg import DiagnosticArray
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_msgs.msg import KeyValue
from rclpy.clock import Clock
from rclpy.clock import ClockType
from rclpy.node import Node

PERIOD = 1.0
THROTTLE = 5.0


class Health:
    """Counts what a node takes in, gives out, skips and refuses, and publishes it every second.

    :param node: whose health it is.
    :param facts: further values to show, each a function that returns it.
    """

    def __init__(self, node: Node, **facts: Callable[[], object]) -> None:
        self._node = node
        self._facts = facts
        self._lock = threading.Lock()
        self._taken = self._given = self.refused = 0
        self._refused_before = 0
        self._reason = ''
        self._latencies: list[float] = []
        self._publisher = node.create_publisher(DiagnosticArray, '/diagnostics', 10)
        # Not the node's clock: a simulated one may stand still.
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        node.create_timer(PERIOD, self.publish, clock=steady)

    def took_in(self) -> None:
        """Count a message or a frame that came in."""
        with self._lock:
            self._taken += 1

    def gave_out(self, stamp: int) -> None:
        """Count a message that went out.

        :param stamp: of its header [ns].
        """
        latency = (self._node.get_clock().now().nanoseconds - stamp) * 1e-9
        with self._lock:
            self._given += 1
            self._latencies.append(latency)

    def refuse(self, reason: str) -> None:
        """Count input that cannot be right, and say why, at most once in a while."""
        with self._lock:
            self.refused += 1
            self._reason = reason
        self._node.get_logger().warning(f'Refused: {reason}', throttle_duration_sec=THROTTLE)

    def publish(self) -> None:
        """Publish the counts since the last time."""
        with self._lock:
            taken, given, latencies = self._taken, self._given, self._latencies
            refused, reason = self.refused, self._reason
            self._taken = self._given = 0
            self._latencies = []
        new = refused - self._refused_before
        self._refused_before = refused
        values = {
            'rate in [Hz]': f'{taken / PERIOD:.1f}',
            'rate out [Hz]': f'{given / PERIOD:.1f}',
            'latency from stamp, median [ms]': f'{median(latencies) * 1e3:.1f}'
            if latencies
            else 'none',
            'refused': refused,
            'last refusal': reason,
            **{name.replace('_', ' '): fact() for name, fact in self._facts.items()},
        }
        status = DiagnosticStatus(
            level=DiagnosticStatus.WARN if new else DiagnosticStatus.OK,
            name=self._node.get_fully_qualified_name(),
            message=f'{new} refused: {reason}' if new else 'working' if given else 'idle',
            values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)
