"""The Python of the pages runs, and does what they say."""

import ast
from pathlib import Path
import re
import shutil
import subprocess
import sys

import cv2
import numpy as np
import pytest
from support.pages import blocks
from support.pages import README
from support.paths import ROOT

from colortrack_ros.data import TRACK
from colortrack_ros.data import Tracks
from colortrack_ros.messages import cloud_of_tracks
from colortrack_ros.scenes import open_scene
from colortrack_ros.sources import open_source

FROM_PYTHON = ROOT / 'doc' / 'python.md'


@pytest.fixture
def scene(tmp_path, monkeypatch):
    """A scene of one ball in the color that the pages name, and ball.mp4, its video."""
    scene = open_scene('single?width=320&height=240&duration=1')
    codec = cv2.VideoWriter.fourcc(*'mp4v')
    video = cv2.VideoWriter(str(tmp_path / 'ball.mp4'), codec, 24.0, (320, 240))
    for k in range(len(scene)):
        video.write(scene.render(k))
    video.release()
    monkeypatch.chdir(tmp_path)
    return scene


def assert_near(u, v, truth):
    assert abs(float(u) - truth['u']) < 3
    assert abs(float(v) - truth['v']) < 3


def test_the_python_of_the_readme_tracks_a_video(scene, capsys):
    (code,) = blocks(README, 'python')
    exec(code, {})
    _stamp, track, u, v = capsys.readouterr().out.splitlines()[-1].split()
    assert int(track) == 1
    assert_near(u, v, scene.truth(len(scene) - 1)[0])


def test_the_python_that_draws_leaves_a_video_with_boxes(scene):
    code, _, _ = blocks(FROM_PYTHON, 'python')
    exec(code, {})
    count = 0
    for drawn, plain in zip(open_source('tracked.mp4'), open_source('ball.mp4'), strict=True):
        count += 1
        changed = cv2.absdiff(drawn.image, plain.image).max(axis=2) > 60
    v, u = np.nonzero(changed)
    truth = scene.truth(len(scene) - 1)[0]
    assert count == len(scene)
    assert abs(np.median(u) - truth['u']) < 20
    assert abs(np.median(v) - truth['v']) < 20


def test_the_python_of_other_trackers_follows_its_target(scene, capsys):
    _, _, code = blocks(FROM_PYTHON, 'python')
    u, v = (round(scene.truth(0)[0][name]) - 16 for name in ('u', 'v'))
    exec(code.replace('[40, 60,', f'[{u}, {v},'), {})
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    target = [line[1:] for line in lines if line[0] == 'target']
    assert len(target) == len(scene)
    assert_near(*target[-1][:2], scene.truth(len(scene) - 1)[0])
    assert {line[1] for line in lines if line[0] == 'moving'} <= {'1', '2'}


def test_the_python_that_tracks_boxes_of_a_network_tracks_them():
    """Two that walk by each other, as ultralytics gives boxes: float32, classes as well."""

    def network(picture):
        k = int(picture[0, 0])
        left = np.array([10.0 + 5 * k, 310.0 - 5 * k])
        boxes = np.stack([left, [40.0, 140.0], left + 30, [120.0, 230.0]], axis=1)
        return boxes.astype('f4'), np.array([0.9, 0.8], 'f4'), np.array([0, 2], 'f4')

    _, code, _ = blocks(FROM_PYTHON, 'python')
    scope = {}
    exec(code, scope)
    pictures = [np.full((240, 360), k, np.uint8) for k in range(40)]
    *_, rows = scope['track'](pictures, network)
    assert rows['track_id'].tolist() == [1, 2]
    assert rows['color'].tolist() == [0, 2]
    # the center of the first pixel is 0, its left edge for a network
    np.testing.assert_allclose(rows['u'], [219.5, 129.5], atol=0.1)
    np.testing.assert_allclose(rows['box_u'], [205, 115], atol=0.1)
    np.testing.assert_allclose(rows['du'], [150, -150], atol=1)


def test_the_python_that_reads_tracks_reads_a_message(capsys):
    (code,) = blocks(ROOT / 'doc' / 'messages.md', 'python')
    tree = ast.parse(code)
    tree.body = [
        node
        for node in tree.body
        if isinstance(node, ast.Import | ast.ImportFrom | ast.FunctionDef)
    ]
    scope = {}
    exec(compile(tree, 'messages.md', 'exec'), scope)
    rows = np.zeros(2, TRACK)
    rows['track_id'], rows['state'] = [3, 4], [1, 0]
    scope['tracks_of'](cloud_of_tracks(Tracks(rows)))
    assert capsys.readouterr().out == '[3] [0.] [0.] (1, 4, 4)\n'


TRY = """
import numpy as np
from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.sources import open_source
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

lamp = np.zeros((12, 60, 80, 3), np.uint8)
for k, picture in enumerate(lamp):
    picture[20:30, 10 + 3 * k : 20 + 3 * k] = 250
np.save('lamp.npy', lamp)
video = open_source('lamp.npy', rate=10.0)
detector = Detector(DetectorConfig(method='brightness', least_brightness=245))
tracker = Tracker(TrackerConfig(motion_model='damped_velocity', associator='greedy'))
while (frame := video.read()) is not None:
    rows = tracker.update(detector.detect(frame)).rows
(row,) = rows
assert row['track_id'] == 1 and row['hits'] == 12, row
assert abs(row['u'] - 47.5) < 0.5 and abs(row['v'] - 24.5) < 0.5, row
assert 20 < row['du'] < 35, row
"""


def insert(path, line, anchor):
    """A line after the first one that the pattern matches."""
    text = path.read_text()
    end = re.search(anchor, text, re.MULTILINE).end()
    path.write_text(f'{text[:end]}\n{line}{text[end:]}')


@pytest.mark.slow
def test_each_way_to_extend_the_package_is_one_file_and_one_line(tmp_path):
    shutil.copytree(ROOT / 'colortrack_ros', tmp_path / 'colortrack_ros')
    page = ROOT / 'doc' / 'extending.md'
    lines = re.findall(r'^The line: `(.*?)` in `(\w+)`', page.read_text(), re.MULTILINE)
    for code, (line, table) in zip(blocks(page, 'python'), lines, strict=True):
        file, text = code.removeprefix('# ').split('\n', 1)
        (tmp_path / file).write_text(text)
        module = file.removesuffix('.py').replace('/', '.')
        name = line.rpartition(' ')[2]
        found = name if f'class {name}' in text else f'associate as {name}'
        init = tmp_path / file.replace(Path(file).name, '__init__.py')
        insert(init, f'from {module} import {found}', r'^from colortrack_ros.*$')
        insert(init, f'    {line},', rf'^{table}\b.*[{{(]')
    config = tmp_path / 'colortrack_ros' / 'detection' / 'config.py'
    where = 'colortrack_ros.detection.methods.brightness'
    insert(config, f'from {where} import BrightnessConfig', r'^from colortrack_ros.*$')
    insert(config, '    BrightnessConfig,', r'^class DetectorConfig\($')
    done = subprocess.run(
        [sys.executable, '-c', TRY], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
