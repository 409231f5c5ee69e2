"""Parameters that name a file, set to what would end or block whoever reads it."""

import os

import pytest
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2
from support.claims import write_huge_png

SCENE = 'scene:single?width=64&height=48'


@pytest.mark.parametrize(
    ('node', 'name'), [('camera', 'camera_info_url'), ('detector', 'mask')], ids=str
)
def test_no_file_that_a_parameter_names_ends_or_blocks_the_node(ros, tmp_path, node, name):
    write_huge_png(tmp_path / 'huge')
    (tmp_path / 'brackets').write_text('[' * 20_000)
    (tmp_path / 'large').write_bytes(bytes(1 << 17))
    os.mkfifo(tmp_path / 'pipe')
    files = [str(tmp_path / file) for file in ('huge', 'brackets', 'large', 'pipe', 'missing', '')]
    camera = ros.start('camera', source=SCENE, loop='true')
    process = camera if node == 'camera' else ros.start(node)
    kind, topic = (Image, 'camera/image_raw') if node == 'camera' else (PointCloud2, 'detections')
    out = ros.listen(kind, topic)
    for value in (*files, '~nosuchuser/cal', '/dev/zero', '/dev/tty', 'x' * 5000):
        parameters = [Parameter(name, value=value).to_parameter_msg()]
        request = SetParameters.Request(parameters=parameters)
        (result,) = ros.call(SetParameters, f'{node}/set_parameters', request).results
        assert not result.successful, value
        assert result.reason, value
    count = len(out)
    assert ros.spin(lambda: len(out) > count + 10), ros.outputs()
    assert 'Traceback' not in process.output
    assert process.stop() == 0
