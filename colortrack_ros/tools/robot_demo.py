"""``make demo ROBOT=1``: a simulated robot follows a ball; a live table, and a video of it."""

import argparse
from collections.abc import Sequence
from functools import partial
import math
from pathlib import Path
import time
from typing import Any

import cv2
from nav_msgs.msg import Odometry
import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rich.console import Console
from rich.live import Live
from rich.table import Table
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2

from colortrack_ros.data import Locations
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.drawing import TopView
from colortrack_ros.drawing import VideoFile
from colortrack_ros.drawing import write_picture
from colortrack_ros.messages import frame_of_image
from colortrack_ros.messages import locations_of_cloud
from colortrack_ros.messages import stamp_of
from colortrack_ros.node_kit.runtime import share_file
from colortrack_ros.signals import INTERRUPTED
from colortrack_ros.simulation.rooms import ROOMS
from colortrack_ros.tools.processes import add_demo_options
from colortrack_ros.tools.processes import NodeEnded
from colortrack_ros.tools.processes import NodeGroup
from colortrack_ros.tools.processes import told

ROOM = ROOMS['balls']
NODES = ('tracker', 'detector', 'locator', 'follower', 'overlay')
PARTS = {
    'overlay/image_raw': Image,
    'locations': PointCloud2,
    'truth': PointCloud2,
    'odom': Odometry,
}
"""What a picture of the video is made of, by topic."""
PARTS_KEPT = 120
"""Stamps whose parts are waited for: 2 seconds of odometry."""
SILENCE = 60.0
"""The demo has failed when no picture has come for so long [s]. Assumed: with half of it a busy
machine on which nodes start slowly may fail, twice as much tells of a failure later."""


class RoomRecorder(Node):
    """Puts the camera's view and the room from above side by side, for each picture.

    :ivar frames: written so far.
    :ivar seconds: of the simulated time, since the first.
    :ivar distances: of the robot from the ball [m], in each.
    :ivar known: the newest locations.
    """

    def __init__(self, out: Path) -> None:
        super().__init__('robot_demo')
        self.frames, self.seconds = 0, 0.0
        self.distances: list[float] = []
        self.known = Locations()
        self.heard = time.monotonic()
        self._out, self._first = out, 0
        self._last: NDArray[np.uint8] = np.zeros((480, 1280, 3), np.uint8)
        self._parts: dict[int, dict[str, Any]] = {}
        pillars = [(p.config.path[0], p.config.path[1], p.config.diameter) for p in ROOM.pillars]
        self._above = TopView(ROOM.half_size, 640, pillars)
        self._video = VideoFile(out / 'demo.mp4', 30.0, (1280, 480))
        for topic, kind in PARTS.items():
            qos = qos_profile_sensor_data if kind is Image else 100
            self.create_subscription(kind, topic, partial(self._take, topic), qos)

    def _take(self, topic: str, message: Any) -> None:
        stamp = stamp_of(message.header)
        self._parts.setdefault(stamp, {})[topic] = message
        if len(self._parts[stamp]) == len(PARTS):
            self._compose(stamp, *(self._parts[stamp][topic] for topic in PARTS))
        while len(self._parts) > PARTS_KEPT:
            del self._parts[min(self._parts)]

    def _compose(
        self, stamp: int, picture: Image, known: PointCloud2, true: PointCloud2, odometry: Odometry
    ) -> None:
        self.heard = time.monotonic()
        self._first = self._first or stamp
        self.seconds = (stamp - self._first) / NANOSECONDS
        self.known, truth = locations_of_cloud(known), locations_of_cloud(true)
        where, turn = odometry.pose.pose.position, odometry.pose.pose.orientation
        place = where.x, where.y, 2 * math.atan2(turn.z, turn.w)
        ball = truth.rows[0]
        self.distances.append(math.hypot(ball['x'] - where.x, ball['y'] - where.y))
        above = self._above.draw(place, self.known, truth)
        text = f'{self.seconds:.1f} s   distance to the ball {self.distances[-1]:.2f} m'
        cv2.putText(
            above, text, (12, 24), cv2.FONT_HERSHEY_SIMPLEX, 0.6, (60, 60, 60), 1, cv2.LINE_AA
        )
        camera = frame_of_image(picture).image
        image = np.hstack([cv2.resize(camera, (640, 480)), above])
        self._last = np.asarray(image, np.uint8)
        self._video.write(self._last)
        self.frames += 1

    def is_complete(self) -> bool:
        """Whether all nodes but the simulator are there."""
        publishers = ('detections', 'tracks', 'locations', 'cmd_vel', 'overlay/image_raw')
        return all(self.count_publishers(topic) for topic in publishers)

    def close(self) -> None:
        """Finish the video, and write its last picture to a PNG.

        :raises OSError: not all of it could be written.
        """
        if self.frames:
            write_picture(self._out / 'demo.png', self._last)
            self._video.close()


def table_of_locations(locations: Locations, title: str) -> Table:
    """Objects in the world as a table for a terminal."""
    table = Table(title=title)
    for column in ('id', 'what', 'x [m]', 'y [m]', 'z [m]', 'speed [m/s]', 'seen [s]'):
        table.add_column(column, justify='left' if column == 'what' else 'right')
    for row in locations.rows:
        sized = zip('xyz', np.sqrt(np.diag(row['covariance'])[:3]), strict=True)
        place = [f'{row[axis]:.2f} ± {sigma:.2f}' for axis, sigma in sized]
        speed = math.hypot(row['vx'], row['vy'], row['vz'])
        name = ROOM.things[row['color']].name
        seen = f'{row["time_since_update"]:.1f}'
        table.add_row(str(row['track_id']), name, *place, f'{speed:.2f}', seen)
    return table


def main(args: Sequence[str] | None = None) -> int:
    """Run the demo."""
    parser = argparse.ArgumentParser(prog='make demo ROBOT=1', description=__doc__)
    add_demo_options(parser, 40.0, 'of the simulated time')
    arguments = parser.parse_args(args)
    try:
        arguments.out.mkdir(parents=True, exist_ok=True)
        with NodeGroup(str(share_file('params/world.yaml'))) as nodes:
            recorder = RoomRecorder(arguments.out)
            nodes.watch_with(recorder)
            for name in NODES:
                nodes.start(name, 'use_sim_time:=true')
            nodes.spin_until(recorder.is_complete)
            # not in real time: on any machine the robot sees all pictures
            nodes.start('simulator', 'real_time:=false', 'publish_clock:=true')
            _watch(recorder, nodes, arguments.seconds)
            recorder.close()
    except (OSError, NodeEnded) as error:
        return told(error)
    if nodes.stopped and not recorder.frames:
        return INTERRUPTED
    return _report(recorder, arguments.out)


def _watch(recorder: RoomRecorder, nodes: NodeGroup, seconds: float) -> None:
    """Show the table until the time is over, or a signal comes."""
    recorder.heard = time.monotonic()
    with Live(refresh_per_second=10, transient=True) as live:
        while not nodes.stopped and recorder.seconds < seconds:
            nodes.spin()
            title = f'objects after {recorder.seconds:.1f} s'
            live.update(table_of_locations(recorder.known, title))
            if time.monotonic() - recorder.heard > SILENCE:
                raise NodeEnded(f'no picture has come for {SILENCE:g} s')


def _report(recorder: RoomRecorder, out: Path) -> int:
    console = Console()
    console.print(table_of_locations(recorder.known, 'objects at the end'))
    if recorder.distances:
        console.print(
            f'{recorder.frames} pictures in {recorder.seconds:.0f} s; median distance to the ball '
            f'{np.median(recorder.distances):.2f} m'
        )
        console.print(f'Look at {out / "demo.mp4"}')
    return 0 if recorder.frames else 1


if __name__ == '__main__':
    raise SystemExit(main())
