"""A node that survives exceptions in its callbacks."""

from collections.abc import Callable
from functools import wraps
from typing import Any

from rclpy.node import Node

from colortrack_ros.flow.faults import fault_of


class GuardedNode(Node):
    """Logs what a callback raises, and where, counts it in the diagnostics, and continues.

    This holds for timers, subscriptions and services, including rclpy's parameter services. The
    caller of a service gets the response as it was, which says that the call failed.
    """

    def create_timer(self, timer_period_sec: float, callback: Any, *args: Any, **kw: Any) -> Any:
        """Create a timer, as rclpy does."""
        return super().create_timer(timer_period_sec, self._guarded(callback), *args, **kw)

    def create_subscription(
        self, msg_type: Any, topic: str, callback: Any, *args: Any, **kw: Any
    ) -> Any:
        """Create a subscription, as rclpy does."""
        return super().create_subscription(msg_type, topic, self._guarded(callback), *args, **kw)

    def create_service(
        self, srv_type: Any, srv_name: str, callback: Any, *args: Any, **kw: Any
    ) -> Any:
        """Create a service, as rclpy does."""
        guarded = self._guarded(callback)

        def answer(request: Any, response: Any) -> Any:
            return guarded(request, response) or response

        return super().create_service(srv_type, srv_name, answer, *args, **kw)

    def _guarded(self, callback: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(callback)  # rclpy looks at the parameters
        def call(*args: Any) -> Any:
            try:
                return callback(*args)
            except Exception as error:  # of any kind
                self.tell_fault(error)

        return call

    def tell_fault(self, error: Exception) -> None:
        """Count and report what a callback has raised."""
        health = getattr(self, 'health', None)
        # there are no diagnostics before a node is configured
        refuse = health.refuse if health else self.get_logger().error
        refuse(fault_of(error))
