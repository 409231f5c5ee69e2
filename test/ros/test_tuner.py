"""The tuner beside running nodes: it shows a topic, and sets their parameters as they allow."""

from rcl_interfaces.srv import GetParameters
from sensor_msgs.msg import PointCloud2
from support.ros_domain import Ros
from support.tuner import only
from support.tuner import see_a_picture
from support.tuner import state_of
from support.tuner import talk
from support.tuner import tuner
from support.waiting import wait_until

SCENE = 'scene:single?width=160&height=120'


def value_of(ros: Ros, name: str):
    request = GetParameters.Request(names=[name])
    (value,) = ros.call(GetParameters, '/robot1/detector/get_parameters', request).values
    return value


def set_to(**values):
    return {'do': 'set', 'node': 'detector', 'values': values, 'follows': False}


def test_changes_go_to_the_running_node_and_what_it_refuses_is_told(ros, tmp_path):
    camera = ros.start('camera', source=SCENE, rate=20.0, loop=True)
    topic = '/camera/image_raw'
    ros.start('detector', '-r', '__ns:=/robot1', '-r', f'camera/image_raw:={topic}', min_area=31)
    with tuner(topic, '--folder', tmp_path, ROS_DOMAIN_ID=str(ros.domain)) as url:
        wait_until(lambda: '/robot1/detector' in str(only(talk(url, [{'do': 'nodes'}]), 'nodes')))
        see_a_picture(url)
        talk(url, [{'do': 'pause'}])
        attach = {'do': 'attach', 'node': 'detector', 'to': '/robot1/detector'}
        assert only(talk(url, [attach]), 'refused')[:-1] == []
        state = state_of(url)
        assert state['attached'] == {'detector': '/robot1/detector'}
        assert state['values']['detector']['min_area'] == 31
        talk(url, [set_to(min_area=44), set_to(**{'colors': ['cup'], 'cup.rgb': [1.0, 2.0, 3.0]})])
        assert value_of(ros, 'min_area').integer_value == 44
        assert list(value_of(ros, 'colors').string_array_value) == ['cup']
        assert list(value_of(ros, 'cup.rgb').double_array_value) == [1.0, 2.0, 3.0]
        talk(url, [{'do': 'undo'}, {'do': 'undo'}])
        assert value_of(ros, 'min_area').integer_value == 31
        assert list(value_of(ros, 'colors').string_array_value) == ['red']
        answers = talk(url, [set_to(min_area=50), set_to(max_area=40)])
        assert any('max_area: expected at least' in a['why'] for a in only(answers, 'refused'))
        lines = only(talk(url, [{'do': 'lines'}]), 'lines')[-1]['text']
        assert 'ros2 param set /robot1/detector min_area 50' in lines
        (tmp_path / 'b.yaml').write_text('/**/detector: {ros__parameters: {min_area: 52}}')
        talk(url, [{'do': 'load', 'path': 'b.yaml'}])
    assert value_of(ros, 'min_area').integer_value == 52
    with tuner(topic, '--folder', tmp_path, killed=True, ROS_DOMAIN_ID=str(ros.domain)) as url:
        wait_until(lambda: not only(talk(url, [attach]), 'refused')[:-1])
        see_a_picture(url)
        talk(url, [set_to(min_area=60), {'do': 'play'}])
    found = ros.listen(PointCloud2, '/robot1/detections')
    assert ros.spin(lambda: len(found) > 20)  # a second of the camera
    assert value_of(ros, 'min_area').integer_value == 60
    assert camera.popen.poll() is None
    detector = ros.processes[1]
    assert 'refused' not in detector.output
    assert detector.stop() == 0
