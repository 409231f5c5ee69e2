"""The simulator node: a robot with a camera in a room of colored objects."""

from collections.abc import Callable
from dataclasses import dataclass
from dataclasses import replace
import threading
import time
from typing import Any

from geometry_msgs.msg import Twist
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
import numpy as np
from rclpy.publisher import Publisher
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.flow.pacing import Pacer
from colortrack_ros.flow.pacing import Window
from colortrack_ros.messages import cloud_of_locations
from colortrack_ros.messages import header_of
from colortrack_ros.messages import image_of_depth
from colortrack_ros.messages import image_of_frame
from colortrack_ros.messages import odometry_on_ground
from colortrack_ros.messages import speeds_of_serialized_twist
from colortrack_ros.messages import stamp_of_serialized
from colortrack_ros.node_kit.clocks import STEADY
from colortrack_ros.node_kit.diagnostics import Health
from colortrack_ros.node_kit.managed import ManagedNode
from colortrack_ros.node_kit.node_setup import NodeSetup
from colortrack_ros.node_kit.runtime import run
from colortrack_ros.node_kit.topics import PictureQueueConfig
from colortrack_ros.node_kit.topics import publish_on
from colortrack_ros.node_kit.topics import subscribe_to
from colortrack_ros.node_kit.topics import topic_name
from colortrack_ros.node_kit.transforms import Transforms
from colortrack_ros.parameters import parameter
from colortrack_ros.parameters import part
from colortrack_ros.simulation import Simulation
from colortrack_ros.simulation import SimulationConfig
from colortrack_ros.world.poses import OPTICAL

TICKS = 2
"""Messages of odometry per picture, the last with the picture's stamp: robots publish odometry more
often than pictures."""
PATIENCE = 0.5
"""Time without cmd_vel [s] after which the robot stops: the default of diff_drive_controller."""
LONGEST_DRIVE = 0.1
"""Longest time [s] that the robot drives in one step: at its top speed 0.15 m, less than its
radius, so that it never drives through a wall."""
LONGEST_STALL = 10.0
"""Longest time [s] between two steps in which a busy machine lets the robot drive on; after more of
it, the clock was set. Assumed: even one that swaps answers earlier."""


@dataclass(frozen=True)
class SimulatorSetup(NodeSetup):
    """The parameters of the simulator node."""

    config: SimulationConfig = part(SimulationConfig)
    real_time: bool = parameter(
        True,
        'Whether time goes by as it does; otherwise each picture waits for the answer to the last.',
        read_only=True,
    )
    publish_clock: bool = parameter(
        False, 'Whether the simulated time is published on /clock.', read_only=True
    )
    stamped: bool = parameter(
        False, 'Whether cmd_vel is TwistStamped instead of Twist.', read_only=True
    )
    publish_tf: bool = parameter(
        True,
        'Whether TF tells of base_frame in fixed_frame and of the camera on it, where tf2_ros is.',
        read_only=True,
    )
    fixed_frame: str = parameter('odom', 'The frame of the odometry.', read_only=True)
    base_frame: str = parameter('base_link', 'The frame of the robot.', read_only=True)
    frame_id: str = parameter(
        'camera_optical_frame', 'The optical frame of the camera.', read_only=True
    )
    cmd_vel_topic: str = topic_name('cmd_vel', 'the speeds that the robot drives with')
    image_topic: str = topic_name('camera/image_raw', 'the pictures')
    camera_info_topic: str = topic_name('camera/camera_info', 'the calibration of the camera')
    depth_topic: str = topic_name('camera/depth/image_raw', 'the depth pictures')
    odometry_topic: str = topic_name('odom', 'the odometry')
    truth_topic: str = topic_name('truth', 'where things are')
    answer_topic: str = topic_name('locations', 'the answers to pictures, unless real_time')
    pictures: PictureQueueConfig = part(PictureQueueConfig)


class SimulatorNode(ManagedNode[SimulatorSetup]):
    """Takes speeds; publishes pictures, depths, calibration, odometry, and the true positions."""

    def __init__(self, **options: Any) -> None:
        super().__init__('simulator', SimulatorSetup, **options)
        self._going = threading.Event()

    def configure(self) -> None:
        """Create the room, the publishers and the subscriptions."""
        setup = self.setup
        self.health = Health(self)
        self._simulation = Simulation(setup.config)
        self._images = publish_on(self, Image, setup.image_topic)
        self._infos = publish_on(self, CameraInfo, setup.camera_info_topic)
        self._depths = publish_on(self, Image, setup.depth_topic)
        self._odometry = publish_on(self, Odometry, setup.odometry_topic)
        self._truth = publish_on(self, PointCloud2, setup.truth_topic)
        self._clocks: Publisher | None = None
        if setup.publish_clock:
            self._clocks = publish_on(self, Clock, '/clock')
        self._transforms: Transforms | None = None
        if setup.publish_tf:
            optical = self._simulation.mount @ OPTICAL
            self._transforms = Transforms(
                self, setup.fixed_frame, setup.base_frame, setup.frame_id, optical
            )
        kind = TwistStamped if setup.stamped else Twist
        subscribe_to(self, kind, setup.cmd_vel_topic, self._drive, self.health.refuse)
        self._window = Window(1)
        if not setup.real_time:
            subscribe_to(
                self, PointCloud2, setup.answer_topic, self._take_answer, self.health.refuse
            )
        self._now = self._real_time()
        self._start = self._now()
        self._told = 0
        self._closing = threading.Event()
        self._pacer = Pacer(self._closing.wait)
        self._going.clear()
        self._thread = threading.Thread(target=self._play, name='simulator')
        self._thread.start()

    @property
    def _stamp(self) -> int:
        """Simulated time [ns]."""
        return self._start + self._simulation.time

    def _real_time(self) -> Callable[[], int]:
        """A function that returns the time that real time goes by [ns].

        Who publishes /clock cannot wait for it, and it must not jump.
        """
        if not self.setup.publish_clock:
            return lambda: self.get_clock().now().nanoseconds
        start = time.time_ns() - STEADY.now().nanoseconds
        return lambda: start + int(STEADY.now().nanoseconds)

    def _drive(self, cdr: bytes) -> None:
        speeds = speeds_of_serialized_twist(cdr, stamped=self.setup.stamped)
        self.health.took_in()
        with self.lock:
            self._told = self._simulation.time
            self._simulation.robot.command(*speeds)

    def _take_answer(self, cdr: bytes) -> None:
        self._window.answer(stamp_of_serialized(cdr))

    def _play(self) -> None:
        while not self._closing.is_set():
            try:
                self._play_next()
            except Exception as error:  # of any kind: time goes on
                self.tell_fault(error)

    def _play_next(self) -> None:
        """Advance by the period of a picture, and take it."""
        tick = round(NANOSECONDS / (TICKS * self.setup.config.rate))
        if not self.setup.real_time:
            self._window.send(self._stamp + TICKS * tick)
        if not self._going.is_set():
            self._going.wait()
            if self.setup.real_time:
                self._start = self._now() - self._simulation.time  # time has not gone by
        for _ in range(TICKS):
            if not self._closing.is_set():
                self._advance(tick)
        if not self._closing.is_set():
            self._look()

    def _advance(self, step: int) -> None:
        """Advance the time, and publish it and the odometry.

        :param step: [ns].
        """
        if self.setup.real_time:
            self._pacer.pace(step / NANOSECONDS)
            step = self._passed(step)
        self._move(step)
        robot, stamp, setup = self._simulation.robot, self._stamp, self.setup
        if self._clocks:
            self._clocks.publish(Clock(clock=header_of(stamp, '').stamp))
        place = robot.odometry
        if self._transforms:
            self._transforms.tell(place.pose, stamp)
        self._odometry.publish(
            odometry_on_ground(
                (place.x, place.y, place.yaw), (robot.speed, robot.turn),
                stamp, setup.fixed_frame, setup.base_frame,
            )
        )  # fmt: skip

    def _passed(self, usual: int) -> int:
        """Time since the last step [ns]; if the clock has been set, the usual one.

        A machine too slow for all pictures drops some instead of slowing the robot down.
        """
        passed = self._now() - self._stamp
        if 0 <= passed <= LONGEST_STALL * NANOSECONDS:
            return passed
        if self._stamp > 0:  # else /clock has come
            self.get_logger().warning(
                f'the clock has jumped by {passed / NANOSECONDS:.1f} s: stamps follow it, the '
                'robot stays where it is'
            )
        self._start += passed - usual
        return usual

    def _move(self, duration: int) -> None:
        """Let the robot drive, and stop if it is no longer told to [ns]."""
        simulation, longest = self._simulation, round(LONGEST_DRIVE * NANOSECONDS)
        end = simulation.time + duration
        with self.lock:
            while True:
                if simulation.time - self._told > PATIENCE * NANOSECONDS:
                    simulation.robot.command(0.0, 0.0)
                simulation.advance(min(end - simulation.time, longest))
                if simulation.time >= end:
                    break

    def _look(self) -> None:
        """Render and publish a picture, with the ground truth at its time."""
        frame_id, stamp = self.setup.frame_id, self._stamp
        self._infos.publish(self._info(stamp))
        if not any(p.get_subscription_count() for p in (self._images, self._depths, self._truth)):
            return
        with self.lock:
            sight = self._simulation.look()
            truth = self._simulation.truth(sight.visible)
        truth = replace(truth, stamp=stamp, frame_id=self.setup.fixed_frame)
        self._truth.publish(cloud_of_locations(truth))
        # megabytes each: converted to messages only for subscribers
        _publish(self._depths, lambda: image_of_depth(sight.depth, stamp, frame_id))
        _publish(self._images, lambda: image_of_frame(Frame(sight.image, 'bgr8', stamp, frame_id)))
        self.health.gave_out(stamp)

    def _info(self, stamp: int) -> CameraInfo:
        camera = self._simulation.camera
        info = CameraInfo(header=header_of(stamp, self.setup.frame_id))
        info.width, info.height = camera.width, camera.height
        info.distortion_model, info.d = 'plumb_bob', list(self.setup.config.distortion)
        info.k, info.r = camera.K.ravel(), np.eye(3).ravel()
        info.p = np.column_stack([camera.K, np.zeros(3)]).ravel()
        return info

    def apply(self, setup: SimulatorSetup) -> None:
        """Apply changed objects."""
        self._simulation.place(setup.config.objects)

    def set_active(self, active: bool) -> None:
        """Run or pause the simulation."""
        self._going.set() if active else self._going.clear()

    def release(self) -> None:
        """Stop the thread."""
        self._closing.set()
        self._window.answer(self._stamp + NANOSECONDS)  # nobody else answers any more
        self._going.set()
        self._thread.join()


def _publish(publisher: Publisher, make: Callable[[], Image]) -> None:
    if publisher.get_subscription_count() > 0:
        publisher.publish(make())


def main() -> int:
    """Run the node."""
    return run(lambda _: [SimulatorNode()])
