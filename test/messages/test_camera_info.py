import os
from pathlib import Path
import resource
import signal

import numpy as np
import pytest
from rclpy.serialization import serialize_message
from sensor_msgs.msg import CameraInfo
from sensor_msgs.msg import RegionOfInterest

from colortrack_ros.messages import image_size_of_serialized_camera_info
from colortrack_ros.messages import load_camera_info
from colortrack_ros.messages import MessageError
from colortrack_ros.messages import save_camera_info

YAML = """
image_width: 640
image_height: 480
camera_name: narrow_stereo
camera_matrix: {rows: 3, cols: 3, data: [430.2, 0, 306.7, 0, 430.5, 227.2, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [-0.34, 0.16, 0.001, -0.0002, 0]}
rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
projection_matrix: {rows: 3, cols: 4, data: [355.6, 0, 302.9, 0, 0, 417.2, 219.5, 0, 0, 0, 1, 0]}
"""


@pytest.mark.parametrize('prefix', ['', 'file://'])
def test_the_yaml_of_camera_calibration_is_read(tmp_path: Path, prefix: str):
    path = tmp_path / 'narrow.yaml'
    path.write_text(YAML)
    info = load_camera_info(f'{prefix}{path}')
    assert (info.width, info.height, info.distortion_model) == (640, 480, 'plumb_bob')
    assert np.allclose(info.k.reshape(3, 3)[:2, 2], (306.7, 227.2))
    assert len(info.d) == 5
    assert info.p[0] == 355.6


def test_a_calibration_without_a_distortion_model_is_plumb_bob(tmp_path: Path):
    """As in files of a decade ago, which camera_info_manager reads as well."""
    path = tmp_path / 'old.yaml'
    path.write_text(YAML.replace('distortion_model: plumb_bob\n', ''))
    assert load_camera_info(str(path)).distortion_model == 'plumb_bob'


def test_what_a_calibration_lacks_is_named(tmp_path: Path):
    path = tmp_path / 'half.yaml'
    path.write_text(YAML.replace('rectification_matrix', 'rectification'))
    with pytest.raises(ValueError, match='writes it: no rectification_matrix'):
        load_camera_info(str(path))


@pytest.mark.parametrize(
    ('width', 'is_one'), [(-1, False), (0, True), (2**32 - 1, True), (2**32, False)]
)
def test_a_size_that_no_message_can_hold_is_refused(tmp_path: Path, width: int, is_one: bool):
    path = tmp_path / 'sized.yaml'
    path.write_text(YAML.replace('image_width: 640', f'image_width: {width}'))
    if is_one:
        assert load_camera_info(str(path)).width == width
    else:
        with pytest.raises(
            ValueError, match=f'expected the width or height of a picture, got {width}'
        ):
            load_camera_info(str(path))


def test_no_calibration_is_all_zeros():
    info = load_camera_info('')
    assert not np.any(info.k)
    assert (info.width, info.height) == (0, 0)


@pytest.mark.parametrize(
    'text',
    ['', '[1, 2', 'a: 1', YAML.replace('430.2', 'wide'), YAML.replace('[1, 0, 0,', '[1, 0,')],
)
def test_another_file_is_refused_by_name(tmp_path: Path, text: str):
    path = tmp_path / 'bad.yaml'
    path.write_text(text)
    with pytest.raises(ValueError, match=r'bad\.yaml is not a calibration'):
        load_camera_info(str(path))


def test_a_missing_file_or_package_is_refused_by_name():
    with pytest.raises(ValueError, match='No such file'):
        load_camera_info('file:///nowhere/camera.yaml')
    with pytest.raises(ValueError, match="no package 'no_such_package'"):
        load_camera_info('package://no_such_package/camera.yaml')


@pytest.mark.parametrize(
    'url', ['~nosuchuser/cal.yaml', 'file://~nosuchuser/cal.yaml', 'a\0b', '/dev/zero', '/', '/tmp']
)
def test_what_is_no_file_is_refused(url: str):
    with pytest.raises(ValueError, match=r'.'):
        load_camera_info(url)


@pytest.mark.slow
@pytest.mark.parametrize(
    'content',
    [
        b'[' * 20_000,
        b'{a: ' * 15_000,
        b'\xff\xfe\x00' * 99,
        b'a' * 70_000,
        YAML.replace('640', '9' * 5000).encode(),
        YAML.replace('640', '1' + '0' * 30).encode(),
        YAML.replace('640', '.inf').encode(),
    ],
    ids=['brackets', 'braces', 'binary', 'large', 'digits', 'width', 'infinite'],
)
def test_whatever_a_file_holds_the_answer_is_a_refusal(tmp_path: Path, content: bytes):
    path = tmp_path / 'bad.yaml'
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r'bad\.yaml'):
        load_camera_info(str(path))


@pytest.mark.parametrize(
    ('info', 'size'),
    [
        (CameraInfo(width=640, height=480), (640, 480)),
        (CameraInfo(width=640, height=480, binning_x=2, binning_y=4), (320, 120)),
        (CameraInfo(width=640, height=480, roi=RegionOfInterest(width=100, height=50)), (100, 50)),
        (CameraInfo(), (0, 0)),
    ],
)
def test_the_size_of_the_pictures_is_that_of_the_region_after_binning(info, size):
    assert image_size_of_serialized_camera_info(serialize_message(info)) == size


@pytest.mark.parametrize('info', [CameraInfo(width=640), CameraInfo(height=480), None])
def test_half_a_size_or_another_message_is_refused(info):
    cdr = b'nonsense' if info is None else serialize_message(info)
    with pytest.raises(MessageError):
        image_size_of_serialized_camera_info(cdr)


def test_what_is_stored_is_read_back_and_leaves_nothing_beside_it(tmp_path: Path):
    path = tmp_path / 'new' / 'narrow.yaml'
    (tmp_path / 'old.yaml').write_text(YAML)
    info = load_camera_info(str(tmp_path / 'old.yaml'))
    save_camera_info(str(path), info)
    assert load_camera_info(str(path)) == info
    assert os.listdir(path.parent) == ['narrow.yaml']


def test_a_calibration_that_cannot_be_stored_leaves_the_old_one(tmp_path: Path):
    path = tmp_path / 'narrow.yaml'
    path.write_text(YAML)
    info = load_camera_info(str(path))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, before[1]))  # as a full disk
    try:
        with pytest.raises(ValueError, match=r'^File too large: .*narrow\.yaml$'):
            save_camera_info(str(path), info)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, ignored)
    assert path.read_text() == YAML
    assert os.listdir(tmp_path) == ['narrow.yaml']


@pytest.mark.parametrize('kind', ['folder', 'pipe'])
def test_a_calibration_is_stored_in_a_file_alone(tmp_path: Path, kind: str):
    path = tmp_path / 'there'
    path.mkdir() if kind == 'folder' else os.mkfifo(path)
    with pytest.raises(ValueError, match='expected a file'):
        save_camera_info(str(path), CameraInfo())


def test_a_calibration_without_a_place_is_not_stored():
    with pytest.raises(ValueError, match=r'^expected the path of a file .* got none$'):
        save_camera_info('', CameraInfo())


@pytest.mark.slow
def test_a_calibration_larger_than_is_read_is_not_stored(tmp_path: Path):
    with pytest.raises(ValueError, match='at most 65536 bytes'):
        save_camera_info(str(tmp_path / 'new.yaml'), CameraInfo(d=[0.1] * 100_000))
    assert os.listdir(tmp_path) == []
