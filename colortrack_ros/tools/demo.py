"""``make demo``: runs the nodes, each in its own process, and shows a live table and makes a
video.
"""

import argparse
from collections.abc import Iterable
from collections.abc import Sequence
import os
from pathlib import Path
import shlex
import sys
import time

import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.qos import QoSProfile
from rclpy.qos import ReliabilityPolicy
from rclpy.subscription import Subscription
from rich.console import Console
from rich.live import Live
from rich.table import Table
from sensor_msgs.msg import CameraInfo
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import Tracks
from colortrack_ros.drawing import VideoFile
from colortrack_ros.drawing import write_picture
from colortrack_ros.files import read_params_file
from colortrack_ros.messages import frame_of_serialized_image
from colortrack_ros.messages import tracks_of_cloud
from colortrack_ros.node_kit.runtime import share_file
from colortrack_ros.signals import INTERRUPTED
from colortrack_ros.sources.base import DEFAULT_RATE
from colortrack_ros.tools.color_options import color_option
from colortrack_ros.tools.color_options import tolerance_option
from colortrack_ros.tools.processes import add_demo_options
from colortrack_ros.tools.processes import NodeEnded
from colortrack_ros.tools.processes import NodeGroup
from colortrack_ros.tools.processes import told

STATES = ('tentative', 'confirmed', 'coasting')
QUIET = 3.0
"""The demo is over when nothing has arrived for this long [s]. Assumed: with half of it a slow node
ends it early; with twice as much everybody waits 3 s longer for the summary."""

TRACKED_SHARE = 0.9
"""Share of the pictures shown that have to be tracked; with fewer, the user is told. Assumed: the
last ones are still under way when the time is up."""


class Recorder(Node):
    """Keeps the newest tracks, and writes the overlay to a video and its best frame to a PNG."""

    def __init__(self, out: Path) -> None:
        super().__init__('demo')
        self.tracks = Tracks()
        self.objects: dict[int, np.void] = {}
        self.messages = self.frames = self.shown = 0
        self.latencies: list[float] = []
        self.heard = time.monotonic()
        self._out = out
        self._first: tuple[int, NDArray[np.uint8]] | None = None
        self._last: NDArray[np.uint8] | None = None
        self._video: VideoFile | None = None
        self._best = -1
        self.create_subscription(PointCloud2, 'tracks', self._take_tracks, 10)
        self.create_subscription(
            Image, 'overlay/image_raw', self._take_picture, qos_profile_sensor_data, raw=True
        )
        # One with each picture, and so small that none is lost.
        quietly = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
        self.create_subscription(CameraInfo, 'camera/camera_info', self._count, quietly, raw=True)
        # The camera waits for subscribers of its pictures alone: once it has found this one, it has
        # found the one above, too. Without it, up to all pictures of a short film were not counted.
        self._found: Subscription | None = self.create_subscription(
            Image, 'camera/image_raw', lambda _: None, qos_profile_sensor_data, raw=True
        )

    def _count(self, _: bytes) -> None:
        self.shown += 1
        if self._found is not None:
            self.destroy_subscription(self._found)
            self._found = None

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
        self._last = frame.image
        if self._first is None:
            self._first = frame.stamp, frame.image
            return
        if self._video is None:
            self._open(frame.stamp - self._first[0], frame.image.shape)
        assert self._video is not None
        self._video.write(frame.image)
        state = self.tracks.rows['state']
        # The best picture shows many measured objects and few coasting ones.
        alive = int(np.count_nonzero(state == CONFIRMED) - np.count_nonzero(state == COASTING))
        if alive > self._best and self.frames > 24:
            self._best = alive
            write_picture(self._out / 'demo.png', frame.image)

    def _open(self, period: int, shape: tuple[int, ...]) -> None:
        assert self._first is not None
        rate = NANOSECONDS / max(period, 1)
        self._video = VideoFile(self._out / 'demo.mp4', rate, (shape[1], shape[0]))
        self._video.write(self._first[1])

    def is_complete(self) -> bool:
        """Whether all nodes except the camera are running."""
        listeners = self.count_subscribers('camera/image_raw') + self.count_subscribers(
            'detections'
        )
        publishers = ('detections', 'tracks', 'overlay/image_raw')
        return listeners == 4 and all(self.count_publishers(topic) for topic in publishers)

    def close(self) -> None:
        """Finish the video, and write the last picture if it was over before the best one.

        :raises OSError: not all of it could be written.
        """
        if self._video is None and self._first is not None:
            self._open(round(NANOSECONDS / DEFAULT_RATE), self._first[1].shape)
        if self._video is not None:
            self._video.close()
        if self._best < 0 and self._last is not None:
            write_picture(self._out / 'demo.png', self._last)


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
    parser.add_argument(
        '--color',
        type=color_option,
        default='',
        help='of the objects: r,g,b of 0..255, or its name',
    )
    parser.add_argument(
        '--tolerance', type=tolerance_option, default='', help='in CIELAB units; found if not given'
    )
    add_demo_options(parser, 21.0, 'how long at the most')
    arguments = parser.parse_args(args)
    try:
        if arguments.params:
            read_params_file(arguments.params)
    except ValueError as error:
        parser.error(str(error))
    return arguments


def main(args: Sequence[str] | None = None) -> int:
    """Run the demo."""
    arguments = _arguments(args)
    params = arguments.params or str(share_file('params/colortrack.yaml'))
    try:
        arguments.out.mkdir(parents=True, exist_ok=True)
        with NodeGroup(params, may_end='camera') as nodes:
            recorder = Recorder(arguments.out)
            nodes.watch_with(recorder)
            _start(nodes, recorder, arguments)
            status = _watch(recorder, nodes, arguments.seconds)
            recorder.close()
    except (OSError, NodeEnded) as error:
        return told(error)
    if nodes.stopped and not recorder.frames:
        return INTERRUPTED
    return status or _report(recorder, arguments)


def _detector_parameters(arguments: argparse.Namespace) -> list[str]:
    """NAME:=VALUE of what is given."""
    name = 'object' if arguments.color else 'red'
    color = [f'colors:=[{name}]', f'{name}.{arguments.color}'] if arguments.color else []
    return color + ([f'{name}.tolerance:={arguments.tolerance}'] if arguments.tolerance else [])


def _start(nodes: NodeGroup, recorder: Recorder, arguments: argparse.Namespace) -> None:
    """Start the nodes; the camera starts once all others are running."""
    nodes.start('tracker')
    nodes.start('detector', *_detector_parameters(arguments))
    nodes.start('overlay')
    nodes.spin_until(recorder.is_complete)
    source = f'source:={arguments.source}'
    once = 'exit_at_end:=true', 'loop:=false'  # objects would jump back to where they began
    nodes.start('camera', source, 'wait_for_subscribers:=3', *once)


def _watch(recorder: Recorder, nodes: NodeGroup, seconds: float) -> int:
    """Show the table until the camera ends, the time is up, or a signal arrives."""
    end: float | None = None
    with Live(refresh_per_second=10, transient=True) as live:
        while not nodes.stopped:
            nodes.spin()
            title = f'tracks of frame {recorder.messages}'
            live.update(table_of(recorder.tracks.rows, title))
            now = time.monotonic()
            if end is None and recorder.messages:
                end = now + seconds
            status = nodes.status_of('camera')
            ended = status is not None and now - recorder.heard > QUIET
            if ended or (end is not None and now > end):
                return status or 0
    return 0


def _report(recorder: Recorder, arguments: argparse.Namespace) -> int:
    console = Console()
    latency = 1e3 * float(np.median(recorder.latencies)) if recorder.latencies else 0.0
    console.print(table_of(recorder.objects.values(), 'objects, when last seen'))
    console.print(
        f'{recorder.messages} frames tracked, {len(recorder.objects)} objects, '
        f'median latency from camera to tracks {latency:.1f} ms'
    )
    if recorder.messages < TRACKED_SHARE * recorder.shown:
        skipped = f'{recorder.shown - recorder.messages} of {recorder.shown} pictures were skipped'
        console.print(f'{skipped}: they come faster than this machine tracks them')
        if command := replay_command(arguments):
            console.print(f'To take each: {command}', soft_wrap=True, markup=False, highlight=False)
    if not recorder.frames:
        return 1
    out = arguments.out
    console.print(f'Look at {out / "demo.png"} and {out / "demo.mp4"}')
    return 0


def replay_command(arguments: argparse.Namespace) -> str:
    """The command that tracks every picture of the same source; empty if that does not wait."""
    source = Path(arguments.source)
    if not source.is_file() and not source.is_dir():
        return ''
    script = Path(sys.executable).with_name('replay')
    installed = ['ros2', 'run', 'colortrack_ros', 'replay']
    words = [os.path.relpath(script)] if script.exists() else installed
    params = ['--params-file', arguments.params] if arguments.params else []
    given = [
        word for each in _detector_parameters(arguments) for word in ('-p', f'detector:{each}')
    ]
    results = ['--output', str(arguments.out / 'tracks'), '--video', str(arguments.out / 'all.mp4')]
    return shlex.join([*words, arguments.source, *params, *given, *results, '--force'])


if __name__ == '__main__':
    raise SystemExit(main())
