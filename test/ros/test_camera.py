from pathlib import Path
import signal
import time

import cv2
import numpy as np
import pytest
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from sensor_msgs.msg import CameraInfo
from sensor_msgs.msg import CompressedImage
from sensor_msgs.msg import Image
from sensor_msgs.srv import SetCameraInfo
from std_srvs.srv import SetBool
from support.damaged import damaged_video
from support.films import encode
from support.films import H264
from support.films import needs_ffmpeg
from support.waiting import slowness
import yaml

from colortrack_ros.messages import frame_of_image
from colortrack_ros.messages import load_camera_info
from colortrack_ros.messages import stamp_of
from colortrack_ros.scenes import open_scene

SMALL = 'scene:single?width=160&height=120&duration=1'
DEEP = {'image_queue_depth': 1000, 'queue_depth': 1000}
"""So that nothing is lost where this process comes late to what it is sent."""


def stamps(messages) -> np.ndarray:
    return np.array([m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in messages])


def test_a_scene_is_published_in_time_with_its_own_stamps_and_a_camera_info_each(ros):
    # The camera waits for whoever listens to pictures: it knows of the other one before.
    infos = ros.listen(CameraInfo, 'camera/camera_info')
    images = ros.listen(Image, 'camera/image_raw')
    camera = ros.start('camera', source=SMALL, wait_for_subscribers=1, frame_id='left', **DEEP)
    start = time.time_ns()
    assert ros.spin(lambda: len(images) == len(infos) == 24), ros.outputs()
    assert [m.header for m in images] == [m.header for m in infos]
    assert {m.header.frame_id for m in images} == {'left'}
    np.testing.assert_allclose(np.diff(stamps(images)), 1e9 / 24, atol=1)
    assert start < stamps(images)[0] < stamps(images)[-1] < time.time_ns()
    scene = open_scene(SMALL.removeprefix('scene:'))
    for k in (0, 23):
        np.testing.assert_array_equal(frame_of_image(images[k]).image, scene.render(k))
    assert (images[0].encoding, images[0].step) == ('bgr8', 480)
    assert all(not np.any(info.k) for info in infos)
    assert {(info.width, info.height) for info in infos} == {(160, 120)}
    camera.wait_for('has ended')
    assert not ros.spin(lambda: len(images) > 24, 0.5)
    assert camera.popen.poll() is None
    assert camera.output.count('has ended') == 1


@needs_ffmpeg
@pytest.mark.parametrize(
    ('times', 'seconds'),
    [('if(lt(N,10),N/5,2+(N-10)/25)', 3.56), ('if(lt(N,20),N/25,60+(N-20)/25)', 11.92)],
    ids=['varying_rate', 'far_apart'],
)
def test_a_film_is_published_when_its_own_times_say_but_nobody_waits_long(
    ros, tmp_path, times, seconds
):
    film = encode(tmp_path / 'film.mkv', f"{H264} -vf setpts='{times}/TB' -vsync vfr", count=50)
    infos, came = ros.listen(CameraInfo, 'camera/camera_info'), []
    ros.node.create_subscription(Image, 'camera/image_raw', lambda _: came.append(time.time()), 50)
    camera = ros.start('camera', source=str(film), wait_for_subscribers=1, **DEEP)
    assert ros.spin(lambda: len(came) == len(infos) == 50), ros.outputs()
    early = stamps(infos) / 1e9 - came
    if seconds < 10.0:
        assert early.max() < 0.01, 'no stamp is in the future'
    assert came[-1] - came[0] == pytest.approx(seconds, abs=0.3 * slowness())
    assert ('later' in camera.output) == (seconds > 10.0)


def test_exit_at_end_ends_the_node_with_status_0(ros):
    camera = ros.start('camera', source=SMALL, exit_at_end='true')
    assert camera.end() == 0, camera.output


def test_a_loop_goes_on_with_growing_stamps(ros):
    images = ros.listen(Image, 'camera/image_raw')
    ros.start('camera', source=SMALL, wait_for_subscribers=1, loop='true', rate=240.0, **DEEP)
    assert ros.spin(lambda: len(images) >= 60), ros.outputs()
    np.testing.assert_allclose(np.diff(stamps(images)), 1e9 / 24, atol=1)


def test_the_calibration_goes_out_with_each_image(ros, tmp_path: Path):
    url = tmp_path / 'camera.yaml'
    url.write_text(
        'image_width: 160\nimage_height: 120\ndistortion_model: plumb_bob\n'
        'camera_matrix: {rows: 3, cols: 3, data: [100, 0, 80, 0, 100, 60, 0, 0, 1]}\n'
        'distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n'
        'rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\n'
        'projection_matrix: {rows: 3, cols: 4, data: [100, 0, 80, 0, 0, 100, 60, 0, 0, 0, 1, 0]}\n'
    )
    infos = ros.listen(CameraInfo, 'camera/camera_info')
    ros.start('camera', source=SMALL, loop='true', camera_info_url=f'file://{url}')
    assert ros.spin(lambda: len(infos) > 0), ros.outputs()
    assert (infos[0].width, infos[0].height, infos[0].k[0]) == (160, 120, 100.0)


def test_jpegs_are_published_while_somebody_subscribes(ros):
    ros.start('camera', source=SMALL, loop='true')
    jpegs = ros.listen(CompressedImage, 'camera/image_raw/compressed')
    assert ros.spin(lambda: len(jpegs) > 3), ros.outputs()
    picture = cv2.imdecode(np.frombuffer(jpegs[0].data, np.uint8), cv2.IMREAD_COLOR)
    assert picture.shape == (120, 160, 3)
    assert 'jpeg' in jpegs[0].format


@pytest.mark.slow
def test_a_picture_that_no_jpeg_can_hold_is_refused_and_goes_out_as_it_is(ros, tmp_path: Path):
    for k, width in enumerate((640, 66_000, 320)):
        cv2.imwrite(str(tmp_path / f'{k}.png'), np.full((8, width, 3), 90, np.uint8))
    jpegs = ros.listen(CompressedImage, 'camera/image_raw/compressed')
    images = ros.listen(Image, 'camera/image_raw')
    camera = ros.start('camera', source=str(tmp_path), rate=5.0, loop='true', **DEEP)
    assert ros.spin(lambda: len(images) > 6 and len(jpegs) > 3), ros.outputs()
    assert {image.width for image in images} == {640, 66_000, 320}
    camera.wait_for('Refused: JPEG: expected 1x1 to 65535x65535 pixels, got 66000x8')
    assert camera.stop() == 0


@pytest.mark.parametrize(
    ('source', 'said'),
    [
        ('/no/such/file.mp4', 'there is no such file'),
        ('scene:nine', "unknown scene 'nine': there are single"),
    ],
)
def test_a_source_that_is_not_there_ends_the_node_with_one_clear_line(ros, source, said):
    camera = ros.start('camera', source=source)
    assert camera.end() == 1
    lines = camera.output.strip().splitlines()
    assert len(lines) == 1, camera.output
    assert said in lines[0]
    assert source.split('/')[-1] in lines[0]


def test_a_file_that_is_no_video_is_refused_by_name(ros, tmp_path: Path):
    path = tmp_path / 'notes.mp4'
    path.write_text('not a video')
    camera = ros.start('camera', source=str(path))
    assert camera.end() == 1
    assert str(path) in camera.output
    assert 'Traceback' not in camera.output


READER = """
import rclpy
from sensor_msgs.msg import Image
rclpy.init()
node = rclpy.create_node('reader')
heard = []
node.create_subscription(Image, 'camera/image_raw', heard.append, 100)
while len(heard) < 48:
    print('reading', len(heard), flush=True)
    rclpy.spin_once(node)
print('reading', len(heard), flush=True)
"""


@pytest.mark.slow
def test_at_its_end_a_camera_waits_for_reliable_subscribers(ros, monkeypatch):
    # whose sockets hold less than this while they stand still
    monkeypatch.setenv('FASTDDS_BUILTIN_TRANSPORTS', 'UDPv4')
    reader = ros.start_code(READER)
    reader.wait_for('reading 0')
    source = 'scene:single?width=640&height=480&duration=2'
    options = {'wait_for_subscribers': 1, 'exit_at_end': 'true', 'image_queue_depth': 100}
    camera = ros.start('camera', source=source, rate=100.0, **options)
    reader.wait_for('reading 1')
    reader.popen.send_signal(signal.SIGSTOP)
    camera.wait_for('has ended')
    time.sleep(1.0)
    assert camera.popen.poll() is None
    reader.popen.send_signal(signal.SIGCONT)
    reader.wait_for('reading 48')
    assert camera.end() == 0
    assert reader.end() == 0


def test_a_signal_while_a_subscriber_blocks_the_publisher_ends_a_camera_in_order(ros, monkeypatch):
    """A camera that takes longer than it may ends with status 124."""
    monkeypatch.setenv('FASTDDS_BUILTIN_TRANSPORTS', 'UDPv4')
    reader = ros.start_code(READER)
    reader.wait_for('reading 0')
    source = 'scene:single?width=640&height=480'
    camera = ros.start('camera', source=source, loop='true', image_queue_depth=1)
    reader.wait_for('reading 1')
    reader.popen.send_signal(signal.SIGSTOP)
    time.sleep(1.0)
    assert camera.stop() == 0
    assert 'Traceback' not in camera.output
    reader.popen.kill()


def test_a_camera_ends_with_a_status_when_its_video_was_damaged(ros, tmp_path):
    video = damaged_video(tmp_path / 'a.mp4', 'mp4v')
    ros.listen(Image, 'camera/image_raw')
    infos = ros.listen(CameraInfo, 'camera/camera_info')
    camera = ros.start('camera', source=video, exit_at_end=True, wait_for_subscribers=1)
    assert ros.spin(lambda: camera.popen.poll() is not None), ros.outputs()
    assert camera.popen.returncode == 1
    assert 'pictures were lost, the file is damaged' in camera.output
    assert stamp_of(infos[-1].header) - stamp_of(infos[0].header) > 5 * 10**9


@pytest.mark.parametrize(('source', 'path'), [(93, '/dev/video93'), ("'93'", '/dev/video93')])
def test_a_device_that_is_not_there_is_waited_for_by_number_or_name(ros, source, path):
    camera = ros.start('camera', source=source)
    camera.wait_for('Next try in 1 s.')
    assert f'there is no device {path}' in camera.output
    assert camera.stop() == 0


def test_after_a_pause_the_stamps_of_a_recording_go_on_with_the_clock(ros):
    ros.start('camera', source='scene:single?width=64&height=48', loop=True, **DEEP)
    infos = ros.listen(CameraInfo, 'camera/camera_info')
    assert ros.spin(lambda: len(infos) > 5), ros.outputs()
    asked = time.monotonic()
    ros.call(SetBool, '/camera/pause', SetBool.Request(data=True))
    paused = time.monotonic()
    ros.spin(lambda: False, 3.0)
    least = time.monotonic() - paused
    ros.call(SetBool, '/camera/pause', SetBool.Request(data=False))
    most = time.monotonic() - asked
    seen = len(infos)
    assert ros.spin(lambda: len(infos) > seen + 10), ros.outputs()
    slow = slowness()
    assert abs(time.time_ns() - stamp_of(infos[-1].header)) < 1.5e9 * slow
    steps = np.diff([stamp_of(info.header) for info in infos])
    assert 1e9 * least - 0.5e9 * slow < steps.max() < 1e9 * most + 0.5e9 * slow
    assert np.sort(steps)[-2] < 0.1e9


def test_a_rate_that_was_slow_by_mistake_is_mended_at_once(ros):
    images = ros.listen(Image, 'camera/image_raw')
    ros.start('camera', source=SMALL, loop=True, rate=0.001, wait_for_subscribers=1, **DEEP)
    assert ros.spin(lambda: len(images) == 1), ros.outputs()
    ros.spin(lambda: False, 0.2)
    assert len(images) == 1
    request = SetParameters.Request(parameters=[Parameter('rate', value=100.0).to_parameter_msg()])
    assert ros.call(SetParameters, 'camera/set_parameters', request).results[0].successful
    assert ros.spin(lambda: len(images) > 20), ros.outputs()


def test_cameracalibrator_can_store_a_calibration(ros, tmp_path):
    path = tmp_path / 'new' / 'camera.yaml'
    path.parent.mkdir()
    path.write_text(yaml.safe_dump(CALIBRATION))
    camera = ros.start(
        'camera', source='scene:single?width=64&height=48', camera_info_url=str(path)
    )
    infos = ros.listen(CameraInfo, 'camera/camera_info')
    camera.wait_for('is the calibration of 640x480 pictures, these have 64x48')
    k = [50.0, 0.0, 32.0, 0.0, 50.0, 24.0, 0.0, 0.0, 1.0]
    info = CameraInfo(width=64, height=48, distortion_model='plumb_bob', k=k, d=[0.1] * 5)
    request = SetCameraInfo.Request(camera_info=info)
    assert ros.call(SetCameraInfo, '/camera/set_camera_info', request).success
    seen = len(infos)
    assert ros.spin(lambda: len(infos) > seen + 2), ros.outputs()
    assert list(infos[-1].k) == k
    assert list(load_camera_info(str(path)).d) == [0.1] * 5
    assert camera.output.count('is the calibration of') == 1


def test_a_calibration_without_a_place_is_not_stored(ros):
    ros.start('camera', source='scene:single?width=64&height=48')
    answer = ros.call(SetCameraInfo, '/camera/set_camera_info', SetCameraInfo.Request())
    assert not answer.success
    assert 'camera_info_url: expected the path of a file' in answer.status_message


CALIBRATION = {
    'image_width': 640,
    'image_height': 480,
    'distortion_model': 'plumb_bob',
    'camera_matrix': {'data': [500.0, 0, 320, 0, 500, 240, 0, 0, 1]},
    'distortion_coefficients': {'data': [0.0] * 5},
    'rectification_matrix': {'data': [1.0, 0, 0, 0, 1, 0, 0, 0, 1]},
    'projection_matrix': {'data': [500.0, 0, 320, 0, 0, 500, 240, 0, 0, 0, 1, 0]},
}
