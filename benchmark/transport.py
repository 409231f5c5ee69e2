"""From the camera's stamp to the tracks, in processes and in one, beside a bare subscriber.

python benchmark/transport.py prints the table and writes out/benchmark_transport.json.
"""

import argparse
import itertools
import json
import os
from pathlib import Path
import signal
import statistics
import subprocess
import sys
import tempfile
import time

os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rich.console import Console
from rich.table import Table
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2

from colortrack_ros.messages import stamp_of
from colortrack_ros.messages import stamp_of_serialized
from colortrack_ros.node_kit.runtime import use_transport_profile

OUT = Path(__file__).parents[1] / 'out' / 'benchmark_transport.json'
CASES = {'640x480 at 60 Hz': (640, 480, 60), '1920x1080 at 30 Hz': (1920, 1080, 30)}
SECONDS = 15
SETTLE = 30
"""Frames at the start that do not count: tables are built, processes are still starting."""

_domains = itertools.count(os.getpid())


def listen(node, way, latencies, stamps):
    """Subscribe to what comes out, and note how old it is."""

    def note(stamp):
        latencies.append((time.time_ns() - stamp) * 1e-6)
        stamps.add(stamp)

    if way == 'bare subscriber':
        node.create_subscription(
            Image,
            'camera/image_raw',
            lambda cdr: note(stamp_of_serialized(cdr)),
            qos_profile_sensor_data,
            raw=True,
        )
    else:
        node.create_subscription(PointCloud2, 'tracks', lambda m: note(stamp_of(m.header)), 100)


def start(names, source, folder):
    """The processes of one way to do it, the camera last."""
    params = Path(folder) / 'params.yaml'
    params.write_text(
        '/**/camera:\n  ros__parameters:\n'
        f'    source: {source}\n    exit_at_end: true\n'
        f'    wait_for_subscribers: {0 if "pipeline" in names else 1}\n'
    )
    processes = []
    for name in names:
        if name == 'camera':
            time.sleep(6.0)  # until those before it have found each other
        code = f'from colortrack_ros.nodes.{name} import main; raise SystemExit(main())'
        command = [sys.executable, '-c', code, '--ros-args', '--params-file', str(params)]
        processes.append(subprocess.Popen(command, stderr=subprocess.DEVNULL))
    return processes


def measure(way, names, width, height, rate):
    """Median and 95th percentile of the latency [ms], and the share of frames that arrived."""
    domain = 1 + next(_domains) % 100
    os.environ['ROS_DOMAIN_ID'] = str(domain)
    context = Context()
    rclpy.init(context=context, domain_id=domain)
    node = Node('benchmark', context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    latencies, stamps = [], set()
    listen(node, way, latencies, stamps)
    source = f'scene:five?width={width}&height={height}&rate={rate}&duration={SECONDS}'
    with tempfile.TemporaryDirectory() as folder:
        processes = start(names, source, folder)
        end = time.monotonic() + SECONDS + 20
        while time.monotonic() < end and processes[-1].poll() is None:
            executor.spin_once(timeout_sec=0.1)
        for process in processes:
            process.send_signal(signal.SIGINT)
            process.wait()
    rclpy.shutdown(context=context)
    used = sorted(latencies[SETTLE:])
    expected = SECONDS * rate
    if 'pipeline' in names:  # it does not wait for us, so we may have missed the first ones
        expected = round((max(stamps) - min(stamps)) * rate * 1e-9) + 1
    return {
        'median_ms': statistics.median(used),
        'p95_ms': used[int(0.95 * len(used))],
        'arrived': len(stamps) / expected,
    }


WAYS = {
    'bare subscriber': ('camera',),
    'three processes': ('tracker', 'detector', 'camera'),
    'pipeline': ('pipeline',),
}


def main():
    use_transport_profile()
    print('load', *os.getloadavg())
    results = {
        case: {way: measure(way, names, *size) for way, names in WAYS.items()}
        for case, size in CASES.items()
    }
    table = Table(title='from the camera stamp to the tracks')
    for column in ('case', 'way', 'median [ms]', '95 % [ms]', 'frames arrived'):
        table.add_column(column, justify='left' if column in ('case', 'way') else 'right')
    for case, ways in results.items():
        for way, one in ways.items():
            numbers = f'{one["median_ms"]:.1f}', f'{one["p95_ms"]:.1f}', f'{one["arrived"]:.1%}'
            table.add_row(case, way, *numbers)
    Console().print(table)
    OUT.parent.mkdir(exist_ok=True)
    OUT.write_text(json.dumps(results, indent=1))


if __name__ == '__main__':
    argparse.ArgumentParser(description=__doc__).parse_args()
    main()
