"""The follower node: drives a robot after the target."""

from collections.abc import Callable
import contextlib
from dataclasses import dataclass
from typing import Any

from geometry_msgs.msg import PoseStamped
from geometry_msgs.msg import Twist
from geometry_msgs.msg import TwistStamped
import numpy as np
from rclpy.duration import Duration
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import Trigger

from colortrack_ros.data import Locations
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.messages import header_of
from colortrack_ros.messages import locations_of_serialized_cloud
from colortrack_ros.messages import MessageError
from colortrack_ros.messages import stamp_of
from colortrack_ros.messages import twist_of
from colortrack_ros.messages.serialized import message_of_serialized
from colortrack_ros.node_kit.clocks import STEADY
from colortrack_ros.node_kit.diagnostics import Health
from colortrack_ros.node_kit.managed import ManagedNode
from colortrack_ros.node_kit.node_setup import NodeSetup
from colortrack_ros.node_kit.odometry import OdometryConfig
from colortrack_ros.node_kit.odometry import receive_odometry
from colortrack_ros.node_kit.runtime import run
from colortrack_ros.node_kit.services import offer
from colortrack_ros.node_kit.topics import publish_on
from colortrack_ros.node_kit.topics import subscribe_to
from colortrack_ros.node_kit.topics import topic_name
from colortrack_ros.parameters import parameter
from colortrack_ros.parameters import part
from colortrack_ros.world.following import AHEAD
from colortrack_ros.world.following import Following
from colortrack_ros.world.following import FollowingConfig
from colortrack_ros.world.following import LONGEST_PERIOD
from colortrack_ros.world.following import Target
from colortrack_ros.world.selection import rule_of
from colortrack_ros.world.selection import Selector

TOLD_APART = 1.0
"""Least time [s] between reporting the target as lost and as followed again. A target that comes
and goes, as on a machine that is too slow, is reported once. A person reads a line a second."""

SLOW_EVERY = 30.0
"""Least time [s] between two lines about a target that is measured late, or a robot that is late.
Chosen."""

LAST_COMMAND = 0.5
"""Time for the stop command to arrive [s], out of the 1.5 s that a node has to shut down."""

FIRST_ODOMETRY = 2.0
"""Time from its start [s] after which a follower that has objects and no odometry says so: robots
send it at 10 Hz or more, but who has just come may hear locations first. Chosen."""

LEFT_BY_ROUNDING = 1e-6
"""Share of the larger variance by which a smaller one may be below 0: ten times what single
precision leaves of a variance of 0."""


@dataclass(frozen=True)
class FollowerSetup(NodeSetup):
    """The parameters of the follower node."""

    config: FollowingConfig = part(FollowingConfig)
    odometry: OdometryConfig = part(OdometryConfig)
    target_source: str = parameter(
        'locations',
        'What is followed: an object of locations_topic, or target_pose_topic, which tells '
        'neither speed nor certainty.',
        choices=('locations', 'pose'),
        read_only=True,
    )
    select: str = parameter(
        'nearest',
        'Which object is the target: nearest, largest, oldest, most_certain, a color, or an ID.',
        int_is_text=True,
    )
    colors: tuple[str, ...] = parameter(
        str, "Names of the detector's colors, in its order, for select."
    )
    stamped: bool = parameter(
        False, 'Whether cmd_vel is TwistStamped instead of Twist.', read_only=True
    )
    locations_topic: str = topic_name('locations', 'the objects')
    target_pose_topic: str = topic_name('target_pose', 'the pose of the target')
    cmd_vel_topic: str = topic_name('cmd_vel', 'the speeds for the robot')

    def check(self) -> None:
        """Raise an error if the selected target cannot exist."""
        rule_of(self.select, list(self.colors))


class FollowerNode(ManagedNode[FollowerSetup]):
    """Takes objects and odometry; publishes speeds with each target, and while the robot moves."""

    def __init__(self, **options: Any) -> None:
        super().__init__('follower', FollowerSetup, **options)

    def configure(self) -> None:
        """Create the publishers, services and subscriptions."""
        setup = self.setup
        self._following = Following(setup.config)
        self._selector = Selector(setup.select, list(setup.colors))
        self._told_following, self._lost = False, -TOLD_APART
        self._ticked, self._began = (0, 0), STEADY.now().nanoseconds
        self.health = Health(
            self, state=lambda: self._following.state, slow=lambda: self._following.slow,
            late=lambda: self._following.turns.line,
        )  # fmt: skip
        kind = TwistStamped if setup.stamped else Twist
        self._commands = publish_on(self, kind, setup.cmd_vel_topic)
        self._poses = receive_odometry(self, setup.odometry, self.health.refuse)
        if setup.target_source == 'pose':
            self._receive(PoseStamped, setup.target_pose_topic, self._take_pose, 'target_pose')
        else:
            self._receive(PointCloud2, setup.locations_topic, self._take_locations, 'locations')
        offer(self, Trigger, '~/stop', self._stop)
        offer(self, Trigger, '~/start', self._go)
        self._timer = self.create_timer(LONGEST_PERIOD, self._step, clock=STEADY)
        self._timer.cancel()

    def _receive(self, kind: type, topic: str, take: Callable[[bytes], object], what: str) -> None:
        subscribe_to(self, kind, topic, take, lambda why: self.health.refuse(f'{what}: {why}'))

    def _take_locations(self, cdr: bytes) -> None:
        locations = locations_of_serialized_cloud(cdr)
        self._check(self.setup.locations_topic, locations.frame_id, locations.stamp)
        self.health.took_in()
        target = self._chosen(locations)
        if target is not None:
            self._following.see(target)
        self._step()

    def _chosen(self, locations: Locations) -> Target | None:
        """Return the object to follow, or None."""
        if not len(self._poses):
            return None
        row = self._selector.choose(locations, self._poses.latest()[1].t)
        if row is None:
            return None
        found = locations.rows[row]
        if not np.isfinite(found['time_since_update']):
            raise MessageError('expected finite numbers, got time_since_update nan or inf')
        least, variance = np.linalg.eigvalsh(found['covariance'][:2, :2])
        if least < -LEFT_BY_ROUNDING * abs(variance):
            raise MessageError(f'expected a covariance, got one of variance {least:.3g} m^2')
        unseen = round(float(found['time_since_update']) * NANOSECONDS)
        return Target(
            np.array([found['x'], found['y']], float), np.array([found['vx'], found['vy']], float),
            locations.stamp, locations.stamp - unseen, float(np.sqrt(variance)),
        )  # fmt: skip

    def _take_pose(self, cdr: bytes) -> None:
        message = message_of_serialized(cdr, PoseStamped)
        stamp, where = stamp_of(message.header), message.pose.position
        self._check(self.setup.target_pose_topic, message.header.frame_id, stamp)
        place = np.array([where.x, where.y])
        if not np.isfinite(place).all():
            raise MessageError(f'expected finite numbers, got x {where.x}, y {where.y}')
        self.health.took_in()
        self._following.see(Target(place, np.zeros(2), stamp, stamp))
        self._step()

    def _check(self, topic: str, frame_id: str, stamp: int) -> None:
        """Raise MessageError for a wrong frame or time, for several publishers of one topic, or if
        there is no odometry.
        """
        given = topic, self.setup.odometry.odometry_topic
        names = [self.resolve_topic_name(one) for one in given]  # rclpy counts before remapping
        for name in names:
            if self.count_publishers(name) > 1:
                raise MessageError(
                    f'several nodes publish {name}, whose targets or poses would take turns: '
                    'the robot stands until one is left'
                )
        base, wanted = self.setup.odometry.base_frame, self.setup.odometry.fixed_frame
        awaited = STEADY.now().nanoseconds - self._began
        if not len(self._poses) and awaited > FIRST_ODOMETRY * NANOSECONDS:
            raise MessageError(
                f'no odometry of {base!r} in {wanted!r} has come on {names[1]}: the robot stands '
                'until it does'
            )
        if frame_id != wanted:
            raise MessageError(f'they are in {frame_id!r}: expected fixed_frame {wanted!r}')
        age = (self.get_clock().now().nanoseconds - stamp) / NANOSECONDS
        if not -AHEAD <= age <= self.setup.config.stop_within:
            raise MessageError(
                f'they are {age:.2f} s old: expected 0 to stop_within, '
                f'{self.setup.config.stop_within:g} s '
                '(slow nodes, use_sim_time, or clocks of two machines?)'
            )

    def _step(self) -> None:
        """Publish the commanded speeds."""
        if not self.active or not len(self._poses):
            return
        now = self.get_clock().now().nanoseconds
        at, base = self._poses.latest()
        with self.lock:
            if self._clock_stands(now):
                self._following.lose('the clock stands: a simulation or bag that is paused?')
            try:
                speeds = self._following.step(now, base, at)
            except Exception:  # whatever fails, the robot stands
                self._publish(now, 0.0, 0.0)
                raise
        self._tell()
        self._publish(now, *speeds)
        self.health.gave_out(at, repeated=True)
        # leave a stopped robot to other nodes until there is a target
        self._timer.reset() if self._following.follows else self._timer.cancel()

    def _clock_stands(self, now: int) -> bool:
        """Whether simulated time has stood still for stop_within: nothing would ever be late."""
        steady = STEADY.now().nanoseconds
        if now != self._ticked[0]:
            self._ticked = now, steady
        return steady - self._ticked[1] > self.setup.config.stop_within * NANOSECONDS

    def _tell(self) -> None:
        """Report a lost target at once, and one followed again after TOLD_APART at the earliest."""
        if self._following.slow:
            self.get_logger().warning(self._following.slow, throttle_duration_sec=SLOW_EVERY)
        if late := self._following.turns.line:
            self.get_logger().warning(late, throttle_duration_sec=SLOW_EVERY)
        follows, now = self._following.follows, STEADY.now().nanoseconds * 1e-9
        lately = now - self._lost < TOLD_APART
        if follows == self._told_following or (follows and lately):
            return
        self._told_following = follows
        self._lost = self._lost if follows else now
        self.get_logger().info(self._following.state)

    def _publish(self, now: int, speed: float, turn: float) -> None:
        command = twist_of(speed, turn)
        if self.setup.stamped:
            header = header_of(now, self.setup.odometry.base_frame)
            command = TwistStamped(header=header, twist=command)
        self._commands.publish(command)

    def _stop(self, _: Trigger.Request) -> str:
        self._following.stop()
        self._publish(self.get_clock().now().nanoseconds, 0.0, 0.0)
        return 'stopped; ~/start follows again'

    def _go(self, _: Trigger.Request) -> str:
        self._following.go()
        return 'following'

    def apply(self, setup: FollowerSetup) -> None:
        """Apply changed parameters."""
        self._following.configure(setup.config)
        if (setup.select, setup.colors) != (self.setup.select, self.setup.colors):
            self._selector = Selector(setup.select, list(setup.colors))

    def set_active(self, active: bool) -> None:
        """Drive the robot, or stop it."""
        if active:
            return
        self._timer.cancel()
        now = self.get_clock().now().nanoseconds
        with self.lock:  # once active again, it starts from a stand
            self._following.commands.give(now, 0.0, 0.0)
        self._publish(now, 0.0, 0.0)
        with contextlib.suppress(RuntimeError):  # of a middleware that cannot tell
            self._commands.wait_for_all_acked(Duration(seconds=LAST_COMMAND))


def main() -> int:
    """Run the node."""
    return run(lambda _: [FollowerNode()])
