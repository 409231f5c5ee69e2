import cv2
import numpy as np
import pytest
from support.waiting import PATIENCE
import yaml

from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.scenes import open_scene
from colortrack_ros.tools.pick_color import main

SCENE = 'scene:single?width=320&height=240&noise=0'
PARAMS = """\
# mine
/**/detector:
  ros__parameters:
    min_area: 9   # small
    colors: [blue]
    blue: {preset: blue}  # the cup
    red:
      rgb: [1, 2, 3]
      tolerance: 9.0
/**/tracker:
  ros__parameters: {max_dt: 3.0}
"""


def center() -> tuple[str, str]:
    row = open_scene(SCENE.removeprefix('scene:')).truth(0)[0]
    return str(round(row['u'])), str(round(row['v']))


def test_a_pixel_gives_the_yaml_of_its_color_and_a_picture(tmp_path, capsys):
    picture = tmp_path / 'picked.png'
    assert main([SCENE, *center(), '--name', 'ball', '--output', str(picture)]) == 0
    said = capsys.readouterr().out
    given = yaml.safe_load(said)
    assert given['colors'] == ['ball']
    lightness, a, b = given['ball']['lab']
    assert 30 < lightness < 60
    assert a > 30
    assert b > 20
    assert given == {'colors': ['ball'], 'ball': {'lab': [lightness, a, b]}}, 'the rest is found'
    assert '# expected area:' in said
    shown = cv2.imread(str(picture))
    assert shown.shape == (240, 960, 3)
    detector = Detector(DetectorConfig(colors=(ReferenceColor('ball', (lightness, a, b)),)))
    detector.detect(Frame(shown[:, :320].copy()))
    assert detector.mask.any()
    assert (shown[:, 320:640, 0] == detector.mask).all()


def test_writing_changes_that_color_alone_and_keeps_the_comments(tmp_path, capsys):
    params, output = tmp_path / 'mine.yaml', str(tmp_path / 'picked.png')
    params.write_text(PARAMS)
    assert (
        main([SCENE, *center(), '--name', 'red', '--write', str(params), '--output', output]) == 0
    )
    text = params.read_text()
    for line in PARAMS.splitlines():
        if not line.strip().startswith(('rgb:', 'tolerance:', 'colors:')):
            assert line in text, line
    detector = yaml.safe_load(text)['/**/detector']['ros__parameters']
    assert detector['colors'] == ['blue', 'red']
    assert set(detector['red']) == {'lab'}


@pytest.mark.parametrize('name', ['picture.png', 'video.avi'])
def test_pictures_and_videos_are_read_at_a_pixel_or_in_a_box(tmp_path, capsys, name):
    scene = open_scene(SCENE.removeprefix('scene:'))
    u, v = (int(text) for text in center())
    if name.endswith('.png'):
        cv2.imwrite(str(tmp_path / name), scene.render(0))
    else:
        video = cv2.VideoWriter(
            str(tmp_path / name), cv2.VideoWriter_fourcc(*'MJPG'), 24, (320, 240)
        )
        for _ in range(3):
            video.write(scene.render(0))
        video.release()
    source, output = str(tmp_path / name), ['--output', str(tmp_path / 'picked.png')]
    assert main([source, str(u), str(v), *output]) == 0
    lightness, a, b = yaml.safe_load(capsys.readouterr().out)['picked']['lab']
    assert 30 < lightness < 60
    assert a > 30
    assert b > 20
    box = ['--box', str(u - 4), str(v - 4), '9', '9']
    other = ['--also-not', source, '0', '6', '6']
    for more in ([], ['--not', '5', '5', '--also', source, '0', str(u + 4), str(v), *other]):
        assert main([source, *box, *more, *output]) == 0
        entry = yaml.safe_load(capsys.readouterr().out)['picked']
        assert ('others' in entry) == bool(more)
        red, green, blue = np.reshape(entry['samples'], (-1, 3)).T
        assert (red > 1.5 * np.maximum(green, blue)).all()


@pytest.mark.parametrize(
    ('arguments', 'said'),
    [
        (['/no/topic', '3', '4'], 'no file, and no sensor_msgs/Image'),
        (['nothing.png', '3', '4'], 'nothing.png'),
        ([SCENE, '3', '4000'], 'in the picture of 320 x 240 px'),
        ([SCENE, '3', '4', '--frame', '9999'], 'has fewer frames'),
        (
            [SCENE, '3', '4', '--write', '/no/such/folder/my.yaml'],
            '/no/such/folder/my.yaml: No such file',
        ),
    ],
)
def test_what_cannot_be_done_is_said_in_one_line(tmp_path, capsys, arguments, said):
    assert main([*arguments, '--output', str(tmp_path / 'picked.png')]) == 1
    told = capsys.readouterr().err.strip()
    assert said in told
    assert '\n' not in told


@pytest.mark.parametrize(
    ('more', 'said'),
    [
        ((), '--also-not SOURCE'),
        (('--not', '20', '20'), '--also SOURCE'),
        (('--not', '20', '20', '--also', SCENE, '5', *center()), '--also-not SOURCE'),
    ],
)
def test_what_one_picture_does_not_tell_is_to_be_shown_in_another(tmp_path, capsys, more, said):
    assert main([SCENE, *center(), *more, '--output', str(tmp_path / 'picked.png')]) == 0
    assert said in capsys.readouterr().err


PATIENT = f"""
import sys
from colortrack_ros.tools import pick_color
pick_color.IMAGE_TIMEOUT = {PATIENCE}
sys.exit(pick_color.main())
"""


@pytest.mark.parametrize('runs_on', [False, True])
def test_a_color_that_runs_into_others_is_told(tmp_path, capsys, runs_on):
    picture = np.full((480, 640, 3), (60, 160, 90), np.uint8)
    spread = 110 if runs_on else 6
    noise = np.random.default_rng(5).integers(-spread, spread, (200, 300, 3))
    picture[100:300, 100:400] = np.clip(np.add(noise, (90, 90, 160)), 0, 255)
    path = str(tmp_path / 'picture.png')
    cv2.imwrite(path, picture)
    assert main([path, '250', '200', '--output', str(tmp_path / 'mask.png')]) == 0
    assert ('runs into other colors' in capsys.readouterr().err) == runs_on


@pytest.mark.parametrize(
    ('arguments', 'said'),
    [
        (['3', '4', '--frame', '-1'], 'expected frames from 0'),
        (['3', '4', '--also', SCENE, '-2', '3', '4'], 'expected frames from 0'),
        (['nan', '4'], 'expected finite numbers'),
        (['3', '4', '--name', 'min_area'], '--name min_area: is a parameter of the detector; give'),
        (['3', '4', '--not', 'inf', '4'], 'expected finite numbers'),
    ],
)
def test_frames_pixels_and_names_that_cannot_be_are_refused(tmp_path, capsys, arguments, said):
    with pytest.raises(SystemExit):
        main([SCENE, *arguments, '--output', str(tmp_path / 'picture.png')])
    assert said in capsys.readouterr().err


def test_ros_arguments_that_cannot_be_read_are_told_in_a_line(capsys):
    with pytest.raises(SystemExit, match='2'):
        main([SCENE, *center(), '--ros-args', '--params-file', 'none.yaml'])
    told = "pick_color: error: bad ROS arguments: Failed to parse ROS arguments: Couldn't parse"
    assert told in capsys.readouterr().err.splitlines()[-1]


def test_a_topic_is_read(ros, tmp_path):
    ros.start('camera', source=SCENE, loop='true')
    assert ros.spin(lambda: ros.node.count_publishers('camera/image_raw') == 1), ros.outputs()
    output = str(tmp_path / 'picked.png')
    process = ros.start_code(PATIENT, '--', '/camera/image_raw', *center(), '--output', output)
    assert ros.spin(lambda: process.popen.poll() is not None), ros.outputs()
    assert 'lab: [' in process.output
