"""Run an installed tracker for a moment against a published detection.

Usage: try_install.py PREFIX, the folder that holds lib/colortrack_ros/tracker.
"""

import os
from pathlib import Path
import signal
import subprocess
import sys
import time

os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
os.environ['ROS_DOMAIN_ID'] = str(1 + os.getpid() % 100)

import numpy as np
import rclpy
from sensor_msgs.msg import PointCloud2

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.messages import cloud_of_detections
from colortrack_ros.messages import tracks_of_cloud


def main(prefix: Path) -> int:
    for file in (
        'share/ament_index/resource_index/packages/colortrack_ros',
        'share/colortrack_ros/package.xml',
        'share/colortrack_ros/launch/colortrack.launch.xml',
        'share/colortrack_ros/params/fastdds.xml',
    ):
        assert (prefix / file).is_file(), f'not installed: {file}'
    packages = next(prefix.glob('lib/python*/site-packages'))
    env = dict(os.environ)
    for name, path in (('PYTHONPATH', packages), ('AMENT_PREFIX_PATH', prefix)):
        env[name] = os.pathsep.join(filter(None, [str(path), env.get(name)]))
    tracker = subprocess.Popen([prefix / 'lib/colortrack_ros/tracker'], env=env, cwd=prefix)
    rclpy.init()
    node = rclpy.create_node('try_install')
    tracks: list[PointCloud2] = []
    node.create_subscription(PointCloud2, 'tracks', tracks.append, 10)
    publisher = node.create_publisher(PointCloud2, 'detections', 10)
    rows = np.zeros(1, DETECTION)
    rows['u'], rows['v'], rows['area'] = 100.0, 50.0, 300.0
    end = time.monotonic() + 30.0
    while len(tracks) < 5 and time.monotonic() < end:
        publisher.publish(cloud_of_detections(Detections(rows, time.time_ns())))
        rclpy.spin_once(node, timeout_sec=0.05)
    tracker.send_signal(signal.SIGINT)
    status = tracker.wait(timeout=10.0)
    assert len(tracks) >= 5, f'{len(tracks)} messages of tracks'
    assert tracks_of_cloud(tracks[-1]).rows['track_id'].tolist() == [1]
    assert status == 0, f'exit status {status}'
    print(f'{prefix.name}: the installed tracker tracks')
    return 0


if __name__ == '__main__':
    raise SystemExit(main(Path(sys.argv[1]).resolve()))
