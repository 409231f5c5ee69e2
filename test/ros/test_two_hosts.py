"""Camera on one host, detector and tracker on another, a link that delays and loses packets."""

from collections.abc import Iterator
import fcntl
import heapq
import os
from pathlib import Path
import random
import select
import shutil
import struct
import subprocess
import sys
import threading
import time

import pytest
from support.forks import program_of
from support.waiting import PATIENCE

TUN = Path('/dev/net/tun')
TUNSETIFF, TAP_WITHOUT_HEADER = 0x400454CA, 0x1002
LOSS, DELAY = 0.01, 0.02
HOSTS = {'cta': '10.77.31.1/24', 'ctb': '10.77.31.2/24'}

LISTENER = """
import sys
import rclpy
from sensor_msgs.msg import PointCloud2
rclpy.init()
node = rclpy.create_node('listener')
heard = []
node.create_subscription(PointCloud2, 'tracks', heard.append, 10)
while len(heard) < 100:
    rclpy.spin_once(node)
print(len({m.header.stamp.nanosec for m in heard}), max(m.width for m in heard))
"""


def ip(*words: str) -> None:
    subprocess.run(['ip', *words], check=True, capture_output=True)


class Link:
    """Two network namespaces, and what carries packets from the one to the other."""

    def __init__(self) -> None:
        self.lost = self.carried = 0
        self._ends = [self._host(name, address) for name, address in HOSTS.items()]
        self._chance = random.Random(1)
        self._open = True
        self._thread = threading.Thread(target=self._carry)
        self._thread.start()

    def _host(self, name: str, address: str) -> int:
        ip('netns', 'add', name)
        end = os.open(TUN, os.O_RDWR)
        fcntl.ioctl(end, TUNSETIFF, struct.pack('16sH', name.encode(), TAP_WITHOUT_HEADER))
        ip('link', 'set', name, 'netns', name)
        ip('-n', name, 'addr', 'add', address, 'dev', name)
        ip('-n', name, 'link', 'set', name, 'up')
        ip('-n', name, 'link', 'set', 'lo', 'up')
        return end

    def _carry(self) -> None:
        waiting: list[tuple[float, int, int, bytes]] = []
        while self._open:
            for end in select.select(self._ends, [], [], 0.002)[0]:
                packet = os.read(end, 65536)
                if self._chance.random() < LOSS:
                    self.lost += 1
                    continue
                self.carried += 1
                other = self._ends[1 - self._ends.index(end)]
                heapq.heappush(waiting, (time.monotonic() + DELAY, self.carried, other, packet))
            while waiting and waiting[0][0] <= time.monotonic():
                _, _, other, packet = heapq.heappop(waiting)
                os.write(other, packet)

    def close(self) -> None:
        self._open = False
        self._thread.join()
        for end in self._ends:
            os.close(end)
        for name in HOSTS:
            ip('netns', 'del', name)


@pytest.fixture
def link() -> Iterator[Link]:
    if os.geteuid() != 0 or not TUN.exists() or not shutil.which('ip'):
        pytest.skip('two hosts need root, /dev/net/tun and iproute2')
    for name in HOSTS:
        subprocess.run(['ip', 'netns', 'del', name], capture_output=True)
    try:
        one = Link()
    except (OSError, subprocess.CalledProcessError) as error:
        pytest.skip(f'two hosts need network namespaces and TAP devices: {error}')
    yield one
    one.close()


def start(host: str, *words: str) -> subprocess.Popen:
    env = dict(os.environ, ROS_AUTOMATIC_DISCOVERY_RANGE='SUBNET', ROS_DOMAIN_ID='31')
    return subprocess.Popen(['ip', 'netns', 'exec', host, sys.executable, '-c', *words], env=env)


def test_tracks_arrive_over_a_link_that_loses_one_packet_in_a_hundred(link):
    parameters = ('source:=scene:five?width=640&height=480', 'loop:=true')
    options = [word for parameter in parameters for word in ('-p', parameter)]
    nodes = [
        start('cta', program_of('camera'), '--ros-args', *options),
        start('ctb', program_of('detector'), '--ros-args', '-p', 'image_transport:=compressed'),
        start('ctb', program_of('tracker')),
    ]
    listener = start('ctb', LISTENER)
    try:
        assert listener.wait(timeout=PATIENCE) == 0
        assert link.lost > 0
    finally:
        for node in (listener, *nodes):
            node.terminate()
        statuses = [node.wait(timeout=PATIENCE) for node in nodes]
    assert statuses == [0, 0, 0]
