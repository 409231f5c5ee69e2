"""A bag played into a domain as `ros2 bag play --clock` does it."""

from pathlib import Path
import time

from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
from support.recorded import KINDS
from support.ros_domain import Ros

from colortrack_ros.bags import BagReader

TICK = 0.01


class Player:
    """Publishes the messages of a bag at their log times, and these as /clock.

    :ivar sent: number of messages.
    """

    def __init__(self, ros: Ros, bag: Path, depth: int = 1000) -> None:
        reader = BagReader(bag)
        self._ros = ros
        self._clock = ros.node.create_publisher(Clock, '/clock', 10)
        self._publishers = {
            t.name: ros.node.create_publisher(KINDS[t.kind], t.name, QoSProfile(depth=depth))
            for t in reader.topics
        }
        found = [
            (log_time, t.name, cdr) for t in reader.topics for log_time, cdr in reader.messages(t)
        ]
        self._messages = sorted(found)
        reader.close()
        self.now = self._messages[0][0]
        self.sent = 0

    @property
    def subscribers(self) -> int:
        """How many listen to the topics."""
        return sum(p.get_subscription_count() for p in self._publishers.values())

    def play(self, speed: float, first: int = 0, last: int | None = None) -> None:
        """Play messages of the bag, as many times faster as recorded.

        :param first: of them; the clock goes back to its time where need be.
        :param last: the one after the last; None plays all.
        """
        some = self._messages[first:last]
        began = time.monotonic()
        start = some[0][0]
        end = some[-1][0]
        self.now = start
        while some:
            self.now = min(start + round((time.monotonic() - began) * speed * 1e9), end)
            self.tick()
            while some and some[0][0] <= self.now:
                _, topic, cdr = some.pop(0)
                self._publishers[topic].publish(cdr)
                self.sent += 1
            self._ros.spin(lambda: False, TICK)

    def pause(self, seconds: float) -> None:
        """Have the clock stand still."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.tick()
            self._ros.spin(lambda: False, TICK)

    def end(self) -> None:
        """Take the clock away."""
        self._ros.node.destroy_publisher(self._clock)

    def tick(self) -> None:
        """Publish the time."""
        message = Clock()
        message.clock.sec, message.clock.nanosec = divmod(self.now, 10**9)
        self._clock.publish(message)
