"""The connection to a running ROS: pictures, and nodes whose parameters the page tunes."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from colortrack_ros.sources import SourceError
from colortrack_ros.tuner.footage import LiveFootage

if TYPE_CHECKING:
    from colortrack_ros.tuner.ros_link import RosLink

WITHOUT_ROS = 'source a ROS installation first: without rclpy there are no topics and no nodes'


class RunningNodes:
    """The connection to ROS, established when it is first needed.

    :param arguments: ROS arguments, such as ``-r __ns:=/robot1``.
    """

    def __init__(self, arguments: Sequence[str] = ()) -> None:
        self._arguments = list(arguments)
        self._link: RosLink | None = None

    def footage(self, topic: str) -> LiveFootage:
        """The pictures of a topic.

        :raises SourceError: there is no ROS.
        """
        try:
            return self.link().footage(topic)
        except ValueError as error:
            raise SourceError(f'{topic}: no such file, and {error}') from error

    def link(self) -> 'RosLink':
        """The connection.

        :raises ValueError: there is no ROS.
        """
        if self._link is None:
            try:
                from colortrack_ros.tuner.ros_link import RosLink
            except ModuleNotFoundError as error:
                raise ValueError(f'{error}; {WITHOUT_ROS}') from error
            self._link = RosLink(self._arguments)
        return self._link

    def close(self) -> None:
        """Close the connection, if there is one."""
        if self._link is not None:
            self._link.close()
