"""Network cameras that come and go."""

import time

from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
from rcl_interfaces.msg import ParameterEvent
from rcl_interfaces.srv import GetParameters
from sensor_msgs.msg import Image
from support.mjpeg import free_port
from support.mjpeg import serve

from colortrack_ros.messages import stamp_of


def test_a_stream_that_goes_and_comes_back_is_taken_up_again(ros):
    port = free_port()
    server = serve(port)
    try:
        images = ros.listen(Image, 'camera/image_raw', reliable=False)
        events = ros.listen(ParameterEvent, '/parameter_events')
        diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
        camera = ros.start('camera', source=f'http://me:secret@127.0.0.1:{port}/stream.mjpg')
        assert ros.spin(lambda: len(images) > 10), ros.outputs()
        server.kill()
        server.wait()
        assert ros.spin(lambda: 'Next try in' in camera.output), ros.outputs()
        ros.spin(lambda: False, 2.0)
        count, back = len(images), time.time_ns()
        server = serve(port)
        assert ros.spin(lambda: len(images) > count + 10), ros.outputs()
        stamps = np.array([stamp_of(image.header) for image in images])
        assert (np.diff(stamps) > 0).all()
        assert back < stamps[-1] < time.time_ns()
        assert any('failed' in str(message) for message in diagnostics)
        request = GetParameters.Request(names=['source'])
        shown = ros.call(GetParameters, 'camera/get_parameters', request).values[0].string_value
        assert shown == f'http://me:***@127.0.0.1:{port}/stream.mjpg'
        assert 'secret' not in camera.output + str(events) + str(diagnostics)
        assert camera.stop() == 0
    finally:
        server.kill()


def test_a_stream_that_is_not_there_yet_is_waited_for(ros):
    """It ended the node, of a robot whose network camera starts later than its computer."""
    port = free_port()
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
    images = ros.listen(Image, 'camera/image_raw', reliable=False)
    camera = ros.start('camera', source=f'http://me:secret@127.0.0.1:{port}/stream.mjpg')
    camera.wait_for('Next try in 1 s.')
    assert 'check the address, the password' in camera.output

    def failures() -> int:
        values = [
            v.value for m in diagnostics for s in m.status for v in s.values if 'failu' in v.key
        ]
        return int(values[-1]) if values else 0

    assert ros.spin(lambda: failures() >= 2), ros.outputs()
    server = serve(port)
    try:
        assert ros.spin(lambda: len(images) > 10 and failures() == 0), ros.outputs()
        assert 'secret' not in camera.output + str(diagnostics)
        assert camera.stop() == 0
    finally:
        server.kill()
