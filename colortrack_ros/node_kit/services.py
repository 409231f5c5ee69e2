"""Services of std_srvs."""

from collections.abc import Callable
from typing import Any

from rclpy.node import Node


def offer(node: Node, kind: type, name: str, serve: Callable[[Any], str]) -> None:
    """Offer a service that always succeeds.

    :param kind: Trigger or SetBool.
    :param serve: takes a request, acts on it, and returns the message of the response.
    """

    def answer(request: Any, response: Any) -> Any:
        response.success, response.message = True, serve(request)
        return response

    node.create_service(kind, name, answer)
