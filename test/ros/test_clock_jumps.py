"""Clocks that jump: use_sim_time that comes and goes, a bag that loops."""

from diagnostic_msgs.msg import DiagnosticArray
from diagnostic_msgs.msg import DiagnosticStatus
import numpy as np
import pytest
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo
from sensor_msgs.msg import PointCloud2

from colortrack_ros.messages import stamp_of
from colortrack_ros.node_kit.clocks import Elapsed

RATE = 25.0
PATIENT = {'warn_latency': 3600.0, 'error_latency': 3600.0}
"""To be late is no illness: a busy machine makes all nodes so."""


def set_sim_time(ros, nodes, value):
    parameters = [Parameter('use_sim_time', value=value).to_parameter_msg()]
    request = SetParameters.Request(parameters=parameters)
    for node in nodes:
        (result,) = ros.call(SetParameters, f'{node}/set_parameters', request).results
        assert result.successful, result.reason


class Hands:
    """Turns the hands of a simulated clock."""

    def __init__(self, ros) -> None:
        self._ros, self._clock = ros, ros.node.create_publisher(Clock, '/clock', 10)

    def show(self, seconds: float) -> None:
        message = Clock()
        message.clock.sec = int(seconds)
        message.clock.nanosec = int(seconds % 1 * 1e9)
        self._clock.publish(message)

    def run(self, start: float, seconds: float) -> None:
        for tick in np.arange(0.0, seconds, 0.02):
            self.show(start + tick)
            self._ros.spin(lambda: False, 0.02)

    def take_away(self) -> None:
        self._ros.node.destroy_publisher(self._clock)


def test_what_has_passed_is_without_the_jumps_of_the_clock(ros):
    node, hands = ros.node, Hands(ros)

    def see(seconds: float) -> None:
        at = round(seconds * 1e9)

        def seen() -> bool:
            hands.show(seconds)
            return node.get_clock().now().nanoseconds == at

        assert ros.spin(seen)

    elapsed = Elapsed(node)
    node.set_parameters([Parameter('use_sim_time', value=True)])
    see(1000.0)
    assert elapsed() < 60.0  # not the time since 1970, or since the machine was started
    before = elapsed()
    see(1007.5)
    assert elapsed() - before == pytest.approx(7.5)
    see(3.0)  # the bag loops
    assert elapsed() - before == pytest.approx(7.5)
    see(4.0)
    assert elapsed() - before == pytest.approx(8.5)
    node.set_parameters([Parameter('use_sim_time', value=False)])
    assert elapsed() - before < 60.0


def test_a_camera_waits_for_the_first_time_of_a_simulated_clock(ros):
    """Pictures were stamped from 0 on, for good, as no odometry and no TF are."""
    infos = ros.listen(CameraInfo, '/camera/camera_info')
    source = 'scene:single?width=80&height=60'
    camera = ros.start('camera', source=source, loop='true', use_sim_time='true')
    camera.wait_for('waits for the first message on /clock')
    assert ros.spin(lambda: ros.node.count_publishers('/camera/camera_info') > 0)
    ros.spin(lambda: False, 1.0)
    hands = Hands(ros)
    hands.run(1000.0, 2.0)
    assert ros.spin(lambda: len(infos) > 5), ros.outputs()
    assert 1000.0 <= stamp_of(infos[0].header) / 1e9 < 1010.0


def flow(ros, names, tracks, said) -> None:
    """Tracks come, stamped one period after the other, and all nodes say that they work."""
    tracks.clear()
    assert ros.spin(lambda: len(tracks) > 30), ros.outputs()
    steps = np.diff([stamp_of(m.header) for m in tracks[10:]])
    assert np.median(steps) == pytest.approx(1e9 / 24.0, rel=0.2)
    said.clear()
    fine = dict.fromkeys(names, False)

    def all_fine() -> bool:
        for status in [s for m in said for s in m.status]:
            name = status.name.partition(':')[0]
            fine[name] = status.level == DiagnosticStatus.OK
        return all(fine.values())

    assert ros.spin(all_fine), (said[-3:], ros.outputs())


def test_tracks_flow_and_health_is_told_whatever_the_clock_does(ros):
    source = 'scene:single?width=160&height=120'
    ros.start('camera', source=source, loop='true', rate=RATE, **PATIENT)
    names = ('camera', 'detector', 'tracker')
    nodes = [ros.start(name, max_lag=60.0, **PATIENT) for name in names[1:]]
    tracks = ros.listen(PointCloud2, 'tracks')
    said = ros.listen(DiagnosticArray, '/diagnostics')
    assert ros.spin(lambda: len(tracks) > 10), ros.outputs()
    hands = Hands(ros)

    flow(ros, names, tracks, said)
    hands.run(50.0, 0.2)
    set_sim_time(ros, names, True)
    hands.run(50.0, 1.0)  # before anything comes by the new clock
    hands.run(10.0, 1.0)  # it goes back
    set_sim_time(ros, names, False)
    flow(ros, names, tracks, said)
    set_sim_time(ros, names, True)
    hands.run(1.7e9, 1.0)
    hands.take_away()
    ros.processes[0].popen.kill()
    set_sim_time(ros, names[1:], False)
    said.clear()
    # whoever says nothing any more is missed, though the clock is behind what it was then

    def silence_is_told() -> bool:
        told = {s.name: s.message for m in said for s in m.status if s.level != DiagnosticStatus.OK}
        return 'nothing has come in' in told.get('detector: messages', '')

    assert ros.spin(silence_is_told), said[-3:]
    assert all('Traceback' not in node.output for node in nodes)
