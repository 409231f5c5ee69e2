"""Connects to topics of pictures and to the parameters of running nodes."""

from collections.abc import Mapping
from collections.abc import Sequence
import threading
from typing import Any

from rcl_interfaces.srv import GetParameters
from rcl_interfaces.srv import ListParameters
from rcl_interfaces.srv import SetParametersAtomically
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter import parameter_value_to_python
from rclpy.qos import qos_profile_sensor_data
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import CompressedImage
from sensor_msgs.msg import Image

from colortrack_ros.messages import MessageError
from colortrack_ros.node_kit.intake import IntakeConfig
from colortrack_ros.node_kit.runtime import refuse_params_files
from colortrack_ros.node_kit.runtime import use_transport_profile
from colortrack_ros.tuner.footage import LiveFootage

TIME_TO_ANSWER = 2.0
"""How long a node may take to answer [s]: it answers between two pictures. Assumed: with half of it
nodes below 1 Hz are missed; with twice as much a dead node delays the page for longer."""

KINDS = {'detector': 'learn_background', 'tracker': 'reset'}
"""A service that identifies each kind of node."""

OTHER_TRACKERS = ('window_tracker', 'contour_tracker')
"""Suffixes of nodes that have the same service but other parameters."""


class RosLink:
    """A node that spins in a thread of its own.

    :param arguments: ROS arguments.
    """

    def __init__(self, arguments: Sequence[str]) -> None:
        use_transport_profile()
        args = ['--ros-args', *arguments] if arguments else []
        refuse_params_files(args)
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
        self._node: Node = rclpy.create_node('tuner')
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._spin, name='ros', daemon=True)
        self._thread.start()
        self._clients: dict[tuple[str, str], Any] = {}

    def footage(self, topic: str) -> LiveFootage:
        """The pictures of a topic, compressed if its name ends so, otherwise raw."""
        footage, config = LiveFootage(topic), IntakeConfig()
        kind = CompressedImage if topic.endswith('/compressed') else Image

        def take(cdr: bytes) -> None:
            try:
                footage.put(config.frame_of(cdr, kind))
            except MessageError as error:
                self._node.get_logger().warning(f'{topic}: {error}', throttle_duration_sec=5.0)

        self._node.create_subscription(kind, topic, take, qos_profile_sensor_data, raw=True)
        return footage

    def nodes(self) -> dict[str, list[str]]:
        """The full names of the detectors and trackers that are running."""
        services = [name for name, _ in self._node.get_service_names_and_types()]
        owners = {name.rpartition('/')[0] for name in services if name.endswith('/list_parameters')}
        found = {
            kind: sorted(owner for owner in owners if f'{owner}/{service}' in services)
            for kind, service in KINDS.items()
        }
        trackers = found['tracker']
        found['tracker'] = [n for n in trackers if n.rpartition('/')[2] not in OTHER_TRACKERS]
        return found

    def values(self, node: str) -> dict[str, Any]:
        """The values of a node's parameters.

        :raises ValueError: it does not answer.
        """
        names = self._call(node, 'list_parameters', ListParameters, ListParameters.Request())
        request = GetParameters.Request(names=names.result.names)
        got = self._call(node, 'get_parameters', GetParameters, request)
        values = map(parameter_value_to_python, got.values)
        known = zip(names.result.names, values, strict=True)
        return {name: _plain(value) for name, value in known if value is not None}

    def give(self, node: str, values: Mapping[str, Any]) -> None:
        """Set a node's parameters, all or none of them; None deletes one.

        :raises ValueError: the node refuses, with its reason, or does not answer.
        """
        request = SetParametersAtomically.Request()
        request.parameters = [
            Parameter(
                name,
                Parameter.Type.NOT_SET if value is None else None,
                value,
            ).to_parameter_msg()
            for name, value in values.items()
        ]
        name = 'set_parameters_atomically'
        answer = self._call(node, name, SetParametersAtomically, request)
        if not answer.result.successful:
            raise ValueError(f'{node} refuses: {answer.result.reason}')

    def close(self) -> None:
        """Close the connection."""
        self._executor.shutdown(timeout_sec=1.0)
        self._thread.join(1.0)
        self._node.destroy_node()
        rclpy.try_shutdown()

    def _spin(self) -> None:
        try:
            self._executor.spin()
        except ExternalShutdownException:
            return

    def _call(self, node: str, service: str, kind: Any, request: Any) -> Any:
        client = self._clients.get((node, service))
        if client is None:
            client = self._node.create_client(kind, f'{node}/{service}')
            self._clients[node, service] = client
        if not client.wait_for_service(TIME_TO_ANSWER):
            raise ValueError(f'{node}: there is no such node')
        done = threading.Event()
        future = client.call_async(request)
        future.add_done_callback(lambda _: done.set())
        if not done.wait(TIME_TO_ANSWER):
            raise ValueError(f'{node}: no answer within {TIME_TO_ANSWER:g} s')
        return future.result()


def _plain(value: Any) -> Any:
    """A value for YAML: lists in place of arrays."""
    return list(value) if hasattr(value, '__iter__') and not isinstance(value, str) else value
