"""Everything at once: nodes killed, stalled, misconfigured, fed nonsense, on a busy machine.

python benchmark/faults.py [SECONDS] prints a table and writes out/benchmark_faults.json. An attempt
is survived when every node that was not killed still runs and tracks go on. The exit status is 1
when one is not, when a node has printed a traceback, or when a node holds more threads, or 32 MiB
more, than 10 s after it has worked for the first time. More files are told alone: a peer that is
started anew has shared memory of its own. At last all is left alone for 20 s: each picture that the
camera gives the detector answers, skips or refuses, by their diagnostics.
"""

import argparse
from collections import Counter
import json
import math
import os
from pathlib import Path
import random
import signal
import subprocess
import sys
import tempfile
import time

os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
os.environ['ROS_DOMAIN_ID'] = str(216 + os.getpid() % 17)  # tests have 1 to 100

from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.msg import Parameter
from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import SetParameters
import rclpy
from rclpy.serialization import serialize_message
from rich.console import Console
from rich.table import Table
from sensor_msgs.msg import CameraInfo
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2
from soak import held

from colortrack_ros.node_kit.runtime import use_transport_profile

OUT = Path(__file__).parents[1] / 'out' / 'benchmark_faults.json'
NODES = ('tracker', 'detector', 'camera', 'overlay')
TOPICS = {'camera/image_raw': Image, 'detections': PointCloud2, 'camera/camera_info': CameraInfo}
PATIENCE = 60.0
"""How long tracks may take to go on [s], on a machine that does ten other things."""
SETTLED = 10.0
"""How long a node has worked when what it holds is first looked at [s]."""
MOST = {'own': 32 * 2**20, 'shared': 128 * 2**20, 'threads': 0}
"""More of each that a node may hold; shared: all of the segments of both that send pictures, of
which none may be left over from a peer that has been killed."""
WAITING = 60
"""Pictures of a second at both ends: camera and detector count seconds of their own."""
FULL_DISK = """ulimit -f 64; exec {python} -c 'from colortrack_ros.replay.main import main
raise SystemExit(main())' 'scene:five?duration=3' --output {folder}/full"""
"""A bag of more than 64 KiB where no more can be written."""
BUSY = 'while True: pass'
VALUES = (
    ParameterValue(type=1, bool_value=True), ParameterValue(type=2, integer_value=-(2**62)),
    ParameterValue(type=3, double_value=float('nan')), ParameterValue(type=3, double_value=1e300),
    ParameterValue(type=4, string_value='../' * 1000), ParameterValue(type=4, string_value='/'),
    ParameterValue(type=9, string_array_value=['x'] * 1000), ParameterValue(type=0),
)  # fmt: skip


class Chain:
    """The nodes as processes, and what is done to them."""

    def __init__(self, folder: Path, chance: random.Random) -> None:
        rclpy.init()
        self.node, self.chance, self.folder = rclpy.create_node('faults'), chance, folder
        self.heard = 0
        self.books = Counter()
        self.node.create_subscription(DiagnosticArray, '/diagnostics', self._note, 100)
        self.node.create_subscription(PointCloud2, 'tracks', self._hear, 10, raw=True)
        self.publishers = {
            name: self.node.create_publisher(k, name, 10) for name, k in TOPICS.items()
        }
        self.processes: dict[str, subprocess.Popen] = {}
        self.first: dict[int, tuple[float, dict[str, int]]] = {}
        self.grown = Counter()
        for name in NODES:
            self.start(name)

    def _hear(self, _: bytes) -> None:
        self.heard += 1

    def _note(self, message: DiagnosticArray) -> None:
        """Keep the books of pictures: given by the camera, answered, skipped, refused."""
        for status in message.status:
            values = {pair.key: pair.value for pair in status.values}
            if status.name == 'camera: messages':
                self.books['given'] += round(float(values['rate out [Hz]']))
            elif status.name == 'detector: messages':
                self.books['answered'] += round(float(values['rate out [Hz]']))
                self.books['refused'] = int(values['refused'])
                self.books['skipped'] = int(values['skipped'])

    def start(self, name: str) -> None:
        """Start a node."""
        code = f'from colortrack_ros.nodes.{name} import main; raise SystemExit(main())'
        command = [sys.executable, '-c', code, '--ros-args']
        if name == 'camera':
            command += ['-p', 'source:=scene:five?width=320&height=240', '-p', 'loop:=true']
        log = (self.folder / f'{name}_{time.monotonic_ns()}.log').open('w')
        self.processes[name] = subprocess.Popen(command, stderr=log, stdout=log)
        self.first[self.processes[name].pid] = (math.inf, {})

    def look(self) -> None:
        """While all work, note what each holds when it has settled, and how much more since."""
        for process in self.processes.values():
            began, first = self.first[process.pid]
            began = min(began, time.monotonic())
            self.first[process.pid] = began, first
            if process.poll() is None and time.monotonic() - began > SETTLED:
                now = held(process.pid)
                first.update({} if first else now)
                for name in now:
                    self.grown[name] = max(self.grown[name], now[name] - first[name])

    def spin(self, seconds: float) -> None:
        """Hear for a time [s]."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            rclpy.spin_once(self.node, timeout_sec=0.05)

    def goes_on(self) -> bool:
        """Whether all nodes run, and new tracks come."""
        before, end = self.heard, time.monotonic() + PATIENCE
        while self.heard < before + 3 and time.monotonic() < end:
            rclpy.spin_once(self.node, timeout_sec=0.05)
        if self.heard < before + 3:
            return False
        self.look()
        return all(p.poll() is None for p in self.processes.values())

    def call(self, kind: type, name: str, request: object) -> None:
        """Call a service, and wait for the answer."""
        client = self.node.create_client(kind, name)
        if client.wait_for_service(timeout_sec=PATIENCE):
            future = client.call_async(request)
            rclpy.spin_until_future_complete(self.node, future, timeout_sec=PATIENCE)
        self.node.destroy_client(client)

    def kill(self) -> None:
        """SIGKILL, and a new node in its place."""
        name = self.chance.choice(NODES)
        self.processes[name].kill()
        self.processes[name].wait()
        self.start(name)

    def stall(self) -> None:
        """SIGSTOP for 1 s."""
        process = self.processes[self.chance.choice(NODES)]
        process.send_signal(signal.SIGSTOP)
        self.spin(1.0)
        process.send_signal(signal.SIGCONT)

    def set_parameters(self) -> None:
        """Values that no parameter can have, in one call."""
        name = self.chance.choice(NODES)
        keys = ('colors', 'min_area', 'rate', 'source', 'mask', 'camera_info_url', 'use_sim_time',
                'motion_model', 'max_dt', 'tracks_topic', 'red.lab', 'x' * 1000)  # fmt: skip
        values = [Parameter(name=key, value=self.chance.choice(VALUES[1:])) for key in keys]
        self.call(SetParameters, f'{name}/set_parameters', SetParameters.Request(parameters=values))

    def change_state(self) -> None:
        """Transitions that there are and that there are not; active at the end."""
        name = self.chance.choice(NODES)
        for number in (self.chance.randrange(256), 4, 2, 1, 3):
            if number not in (5, 6, 7):  # which end a node for good
                transition = Transition(id=number)
                self.call(
                    ChangeState, f'{name}/change_state', ChangeState.Request(transition=transition)
                )

    def publish(self) -> None:
        """200 messages of random bytes, cut short, or with some bytes changed."""
        for _ in range(200):
            name = self.chance.choice(list(TOPICS))
            good = bytearray(serialize_message(TOPICS[name]()))
            for _ in range(self.chance.randrange(8)):
                good[self.chance.randrange(4, len(good))] = self.chance.randrange(256)
            noise = self.chance.randbytes(self.chance.randrange(4, 400))
            self.publishers[name].publish(bytes(self.chance.choice((good, good[:4] + noise))))
        self.spin(0.2)

    def full_disk(self) -> None:
        """A replay onto a full disk: status 1, in one line."""
        command = FULL_DISK.format(python=sys.executable, folder=self.folder)
        done = subprocess.run(['bash', '-c', command], capture_output=True, text=True)
        (self.folder / f'replay_{time.monotonic_ns()}.log').write_text(done.stderr)
        assert done.returncode == 1, done.stderr

    def audit(self) -> int:
        """Pictures within 20 s that the detector neither answers nor skips nor refuses."""
        self.spin(3.0)
        before = Counter(self.books)
        self.spin(20.0)
        self.books.subtract(before)
        return self.books['given'] - sum(self.books[k] for k in ('answered', 'skipped', 'refused'))

    def close(self) -> Counter:
        """End the nodes; exit statuses."""
        for process in self.processes.values():
            process.send_signal(signal.SIGINT)
        return Counter(process.wait(PATIENCE) for process in self.processes.values())


def main(seconds: float) -> int:
    use_transport_profile()
    tried, survived = Counter(), Counter()
    busy = [subprocess.Popen([sys.executable, '-c', BUSY]) for _ in range(2)]
    with tempfile.TemporaryDirectory() as folder:
        chain = Chain(Path(folder), random.Random(1))
        names = ('kill', 'stall', 'set_parameters', 'change_state', 'publish', 'full_disk')
        try:
            ready, end = chain.goes_on(), time.monotonic() + seconds
            while ready and time.monotonic() < end:
                name = chain.chance.choice(names)
                getattr(chain, name)()
                tried[name] += 1
                survived[name] += chain.goes_on()
            missing = chain.audit()
            statuses = chain.close()
        finally:
            for process in (*busy, *chain.processes.values()):
                process.kill()
        logs = [path.read_text(errors='replace') for path in Path(folder).iterdir()]
    tracebacks = sum('Traceback' in log for log in logs)
    _print(chain, tried, survived, seconds)
    console = Console()
    console.print(f'books of pictures: {dict(chain.books)}, missing {missing}')
    console.print(f'exit statuses {dict(statuses)}, logs with a traceback: {tracebacks}')
    grown = any(chain.grown[name] > most for name, most in MOST.items())
    lost = abs(missing) > WAITING
    all_well = ready and tried == survived and not grown and not lost
    return int(not all_well or tracebacks > 0 or set(statuses) != {0})


def _print(chain: Chain, tried: Counter, survived: Counter, seconds: float) -> None:
    """What was tried and survived, on the terminal and as JSON."""
    table = Table('attempt', 'tried', 'survived', title=f'Everything at once for {seconds:g} s')
    for name in tried:
        table.add_row(getattr(Chain, name).__doc__, str(tried[name]), str(survived[name]))
    console = Console()
    console.print(table)
    console.print(f'held more than when settled, at most: {dict(chain.grown)}')
    OUT.parent.mkdir(exist_ok=True)
    OUT.write_text(
        json.dumps({'tried': tried, 'survived': survived, 'grown': chain.grown}, indent=2)
    )


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('seconds', nargs='?', type=float, default=1800.0)
    raise SystemExit(main(**vars(parser.parse_args())))
