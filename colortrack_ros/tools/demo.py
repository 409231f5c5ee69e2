"""``make demo``: the nodes as processes of their own, their tracks as a live table, and a video."""

import argparse
from collections.abc import Iterable
from collections.abc import Mapping
from collections.abc import Sequence
import errno
import os
from pathlib import Path
import random
import signal
import subprocess
import sys
import threading
import time

import cv2
import numpy as np
from numpy.typing import NDArray
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.signals import SignalHandlerOptions
from rich.console import Console
from rich.live import Live
from rich.table import Table
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import Tracks
from colortrack_ros.drawing import VideoFile
from colortrack_ros.messages import frame_of_serialized_image
from colortrack_ros.messages import tracks_of_cloud
from colortrack_ros.node_kit.runtime import share_file
from colortrack_ros.node_kit.runtime import use_transport_profile
from colortrack_ros.tools.processes import check_nodes
from colortrack_ros.tools.processes import end_nodes
from colortrack_ros.tools.processes import NodeEnded
from colortrack_ros.tools.processes import start_node

STATES = ('tentative', 'confirmed', 'coasting')
QUIET = 3.0
"""The demo is over when nothing has arrived for this long [s]."""


class Recorder(Node):
    """Keeps the newest tracks, and writes the overlay to a video and its best frame to a PNG."""

    def __init__(self, out: Path) -> None:
        super().__init__('demo')
        self.tracks = Tracks()
        self.objects: dict[int, np.void] = {}
        self.messages = self.frames = 0
        self.latencies: list[float] = []
        self.heard = time.monotonic()
        self._out = out
        self._first: tuple[int, NDArray[np.uint8]] | None = None
        self._video: VideoFile | None = None
        self._best = -1
        self.create_subscription(PointCloud2, 'tracks', self._take_tracks, 10)
        self.create_subscription(
            Image, 'overlay/image_raw', self._take_picture, qos_profile_sensor_data, raw=True
        )

    def _take_tracks(self, message: PointCloud2) -> None:
        self.tracks = tracks_of_cloud(message)
        self.messages += 1
        self.heard = time.monotonic()
        self.latencies.append((time.time_ns() - self.tracks.stamp) / NANOSECONDS)
        rows = self.tracks.rows
        confirmed = rows[rows['state'] != TENTATIVE]
        self.objects.update(zip(confirmed['track_id'].tolist(), confirmed, strict=True))

    def _take_picture(self, cdr: bytes) -> None:
        frame = frame_of_serialized_image(cdr)
        self.frames += 1
        if self._first is None:
            self._first = frame.stamp, frame.image
            return
        if self._video is None:
            self._open(frame.stamp - self._first[0], frame.image.shape)
        assert self._video is not None
        self._video.write(frame.image)
        state = self.tracks.rows['state']
        # The best picture shows many objects that are measured and few that coast.
        alive = int(np.count_nonzero(state == CONFIRMED) - np.count_nonzero(state == COASTING))
        if alive > self._best and self.frames > 24:
            self._best = alive
            self._write_picture(frame.image)

    def _open(self, period: int, shape: tuple[int, ...]) -> None:
        assert self._first is not None
        rate = NANOSECONDS / max(period, 1)
        self._video = VideoFile(self._out / 'demo.mp4', rate, (shape[1], shape[0]))
        self._video.write(self._first[1])

    def _write_picture(self, image: NDArray[np.uint8]) -> None:
        path = self._out / 'demo.png'
        if not cv2.imwrite(str(path), image):
            raise OSError(errno.EIO, 'cannot be written; is the disk full?', str(path))

    def is_complete(self) -> bool:
        """Whether all nodes but the camera are there."""
        listeners = self.count_subscribers('camera/image_raw') + self.count_subscribers(
            'detections'
        )
        publishers = ('detections', 'tracks', 'overlay/image_raw')
        return listeners == 3 and all(self.count_publishers(topic) for topic in publishers)

    def close(self) -> None:
        """Finish the video.

        :raises OSError: not all of it could be written.
        """
        if self._video is not None:
            self._video.close()


def table_of(rows: Iterable[np.void], title: str) -> Table:
    """Tracks as a table for a terminal."""
    table = Table(title=title)
    for column in ('id', 'state', 'u [px]', 'v [px]', 'du [px/s]', 'dv [px/s]', 'age [s]', 'hits'):
        table.add_column(column, justify='left' if column == 'state' else 'right')
    for row in rows:
        sigma_u, sigma_v = np.sqrt(np.diag(row['covariance'])[:2])
        table.add_row(
            str(row['track_id']),
            STATES[row['state']],
            f'{row["u"]:.1f} ± {sigma_u:.1f}',
            f'{row["v"]:.1f} ± {sigma_v:.1f}',
            f'{row["du"]:.0f}',
            f'{row["dv"]:.0f}',
            f'{row["age"]:.1f}',
            str(row['hits']),
        )
    return table


def _arguments(args: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog='make demo', description=__doc__)
    parser.add_argument('--source', default='scene:occlusion', help='as the camera takes it')
    parser.add_argument('--params', default='', help='parameters of the nodes')
    parser.add_argument('--color', default='', help='r,g,b of the objects, 0..255')
    parser.add_argument('--tolerance', default='', help='in CIELAB units; found if not given')
    parser.add_argument('--seconds', type=float, default=21.0, help='how long at the most')
    parser.add_argument('--out', type=Path, default=Path('out'), help='folder for the results')
    arguments = parser.parse_args(args)
    if arguments.color:
        try:
            red, green, blue = (int(value) for value in arguments.color.split(','))
        except ValueError:
            parser.error(f'--color {arguments.color}: expected r,g,b, such as 220,60,40')
        arguments.color = f'[{red}, {green}, {blue}]'
    return arguments


def main(args: Sequence[str] | None = None) -> int:
    """Run the demo."""
    arguments = _arguments(args)
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: stop.set())
    arguments.out.mkdir(parents=True, exist_ok=True)
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    os.environ.setdefault('ROS_DOMAIN_ID', str(random.randint(1, 100)))
    use_transport_profile()
    color = [f'red.rgb:={arguments.color}'] if arguments.color else []
    tolerance = [f'red.tolerance:={arguments.tolerance}'] if arguments.tolerance else []
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    recorder = Recorder(arguments.out)
    params = arguments.params or str(share_file('params/colortrack.yaml'))
    nodes = {
        'tracker': start_node('tracker', params),
        'detector': start_node('detector', params, *color, *tolerance),
        'overlay': start_node('overlay', params),
    }
    executor = SingleThreadedExecutor()
    executor.add_node(recorder)
    try:
        while not recorder.is_complete() and not stop.is_set():
            executor.spin_once(timeout_sec=0.1)
            check_nodes(nodes)
        play = (f'source:={arguments.source}', 'wait_for_subscribers:=2', 'exit_at_end:=true')
        nodes['camera'] = start_node('camera', params, *play)
        status = _watch(recorder, executor, nodes, arguments.seconds, stop)
        recorder.close()
    except OSError as error:
        print(f'demo: {error.filename or "output"}: {error.strerror}', file=sys.stderr)
        return 1
    except NodeEnded as error:
        print(f'demo: {error}', file=sys.stderr)
        return 1
    finally:
        end_nodes(nodes.values())
    return status or _report(recorder, arguments.out)


def _watch(
    recorder: Recorder,
    executor: SingleThreadedExecutor,
    nodes: Mapping[str, subprocess.Popen[bytes]],
    seconds: float,
    stop: threading.Event,
) -> int:
    """Show the table until the camera ends, the time is over, or a signal comes."""
    end: float | None = None
    camera = nodes['camera']
    with Live(refresh_per_second=10, transient=True) as live:
        while not stop.is_set():
            executor.spin_once(timeout_sec=0.1)
            check_nodes(nodes)
            title = f'tracks of frame {recorder.messages}'
            live.update(table_of(recorder.tracks.rows, title))
            now = time.monotonic()
            if end is None and recorder.messages:
                end = now + seconds
            ended = camera.poll() is not None and now - recorder.heard > QUIET
            if ended or (end is not None and now > end):
                return camera.poll() or 0
    return 0


def _report(recorder: Recorder, out: Path) -> int:
    console = Console()
    latency = 1e3 * float(np.median(recorder.latencies)) if recorder.latencies else 0.0
    console.print(table_of(recorder.objects.values(), 'objects, when last seen'))
    console.print(
        f'{recorder.messages} frames tracked, {len(recorder.objects)} objects, '
        f'median latency from camera to tracks {latency:.1f} ms'
    )
    console.print(f'Look at {out / "demo.png"} and {out / "demo.mp4"}')
    return 0 if recorder.frames else 1


if __name__ == '__main__':
    raise SystemExit(main())
