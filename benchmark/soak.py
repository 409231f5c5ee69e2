"""Half an hour's frames through the pipeline, as fast as it goes: what it holds grows by nothing.

python benchmark/soak.py [FRAMES] prints a table and writes out/benchmark_soak.json. The exit status
is 1 when its own memory has grown by 2 MiB or more since the first minute's frames, or when there
are more threads or open files.
"""

import argparse
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import tempfile
import time

os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
os.environ['ROS_DOMAIN_ID'] = str(216 + os.getpid() % 17)  # tests have 1 to 100

import rclpy
from rich.console import Console
from rich.table import Table
from sensor_msgs.msg import PointCloud2

from colortrack_ros.messages import stamp_of
from colortrack_ros.node_kit.runtime import use_transport_profile

OUT = Path(__file__).parents[1] / 'out' / 'benchmark_soak.json'
RATE = 30
MINUTE = 60 * RATE
FRAMES = 30 * MINUTE
LOOKS = 10
MOST = 2 * 2**20
CODE = 'from colortrack_ros.nodes.pipeline import main; raise SystemExit(main())'
PARAMS = f"""/**/camera:
  ros__parameters:
    source: scene:five?width=640&height=480&rate={RATE}
    loop: true
    rate: -1.0
    wait_for_subscribers: 0
"""


def held(pid: int) -> dict[str, int]:
    """What a process has: memory of its own, that it shares [bytes], threads, open files.

    Shared are libraries, and what it has touched of its peers' segments of 64 MiB, where pictures
    come to lie elsewhere whenever somebody has stalled.
    """
    folder = Path('/proc') / str(pid)
    resident, shared = map(int, (folder / 'statm').read_text().split()[1:3])
    threads, files = (len(list((folder / name).iterdir())) for name in ('task', 'fd'))
    page = os.sysconf('SC_PAGE_SIZE')
    own = (resident - shared) * page
    return {'own': own, 'shared': shared * page, 'threads': threads, 'files': files}


def soak(pid: int, frames: int) -> list[dict[str, int]]:
    """What the pipeline holds after a minute's frames, and then ten times until the end."""
    rclpy.init()
    node = rclpy.create_node('soak')
    stamps: list[int] = []

    def note(message: PointCloud2) -> None:
        stamps[1:] = [stamp_of(message.header)]

    node.create_subscription(PointCloud2, 'tracks', note, 100)
    looks: list[dict[str, int]] = []
    due = [MINUTE + (frames - MINUTE) * k // LOOKS for k in range(LOOKS + 1)]
    while due:
        rclpy.spin_once(node, timeout_sec=10.0)
        done = round((stamps[-1] - stamps[0]) * RATE / 1e9) if stamps else 0
        if done >= due[0]:
            looks.append({'frames': done} | held(pid))
            due.pop(0)
    node.destroy_node()
    rclpy.shutdown()
    return looks


def main(frames: int) -> int:
    """Run the pipeline and look at it."""
    use_transport_profile()
    began = time.monotonic()
    with tempfile.NamedTemporaryFile('w', suffix='.yaml') as params:
        params.write(PARAMS)
        params.flush()
        command = [sys.executable, '-c', CODE, '--ros-args', '--params-file', params.name]
        pipeline = subprocess.Popen(command)
        try:
            looks = soak(pipeline.pid, frames)
        finally:
            pipeline.send_signal(signal.SIGINT)
            pipeline.wait()
    seconds = time.monotonic() - began
    table = Table(title=f'the pipeline, {frames} frames of 640x480 in {seconds:.0f} s')
    for column in ('frames', 'own memory [MiB]', 'threads', 'open files'):
        table.add_column(column, justify='right')
    for look in looks:
        numbers = look['threads'], look['files']
        table.add_row(str(look['frames']), f'{look["own"] / 2**20:.2f}', *map(str, numbers))
    Console().print(table)
    OUT.parent.mkdir(exist_ok=True)
    OUT.write_text(json.dumps(looks, indent=1))
    first, last = looks[0], looks[-1]
    stays = all(last[name] <= first[name] for name in ('threads', 'files'))
    return 0 if stays and last['own'] - first['own'] < MOST else 1


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('frames', nargs='?', type=int, default=FRAMES)
    raise SystemExit(main(**vars(parser.parse_args())))
