"""What a recording tells without a truth: the nodes' own counts, their latency, the innovations."""

import json

from diagnostic_msgs.msg import DiagnosticArray
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_msgs.msg import KeyValue
import numpy as np
import pytest
from rclpy.serialization import serialize_message
from support.damaged import damaged_video
from support.recorded import frames
from support.recorded import short_bag
from support.recorded import write_bag

from colortrack_ros.bags import BagWriter
from colortrack_ros.chain import ColorTracker
from colortrack_ros.evaluation.comparison import FalseTrack
from colortrack_ros.evaluation.report import picture_of
from colortrack_ros.messages import cloud_of_detections
from colortrack_ros.messages import cloud_of_tracks
from colortrack_ros.messages import stamp_of
from colortrack_ros.node_kit.detections_intake import CLOUD
from colortrack_ros.sources import open_source
from colortrack_ros.tools.evaluate import main
from colortrack_ros.tools.evaluation_task import _pictures
from colortrack_ros.tools.health_of_bag import KIND

SCENE = 'scene:single?width=160&height=120&rate=20&duration=3&noise=3'
SECONDS = [
    {'refused': 0, 'skipped': 0, 'latency from stamp, median [ms]': 'none'},
    {'refused': 2, 'skipped': 5, 'latency from stamp, median [ms]': '12.0'},
    {'refused': 0, 'skipped': 1, 'latency from stamp, median [ms]': '30.0'},  # started again
    {'refused': '\u00b2', 'skipped': '9' * 5000},  # of no node of this package
]


def status(name, level, message, values):
    pairs = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
    return DiagnosticStatus(name=name, level=level, message=message, values=pairs)


@pytest.fixture(scope='module')
def night(tmp_path_factory):
    path = tmp_path_factory.mktemp('bags') / 'night'
    bag = BagWriter(path, {'/d': CLOUD, '/t': CLOUD, '/diagnostics': KIND}, 'mcap')
    track = ColorTracker()
    for frame in open_source(SCENE):
        tracks = track(frame)
        when = frame.stamp + 20_000_000
        bag.write('/d', when, serialize_message(cloud_of_detections(track.detections)))
        bag.write('/t', when, serialize_message(cloud_of_tracks(tracks)))
    for k, values in enumerate(SECONDS):
        level = DiagnosticStatus.WARN if k in (1, 2) else DiagnosticStatus.OK
        ours = status('robot1/detector: messages', level, 'too slow' if k else 'working', values)
        theirs = status('lidar: spin', DiagnosticStatus.ERROR, 'stuck', {'refused': '99'})
        bag.write(
            '/diagnostics', k * 10**9, serialize_message(DiagnosticArray(status=[ours, theirs]))
        )
    bag.close()
    return path


@pytest.mark.slow
def test_a_nightly_recording_tells_what_was_refused_skipped_and_late(night, tmp_path, capsys):
    out, page = tmp_path / 'out.json', tmp_path / 'page.html'
    assert main([str(night), '--json', str(out), '--html', str(page)]) == 0
    (result,) = json.loads(out.read_text())
    measures = result['measures']
    assert measures['robot1/detector.refused'] == 2
    assert measures['robot1/detector.skipped'] == 6
    assert measures['robot1/detector.latency'] == pytest.approx(0.021)
    assert measures['robot1/detector.latency_most'] == pytest.approx(0.030)
    assert measures['delay'] == pytest.approx(0.020)
    assert 0.1 < measures['nis'] < 3
    assert measures['noise'] > 0
    assert result['said'] == {'robot1/detector: too slow': 2}
    assert 'night: robot1/detector: too slow (2 s)' in capsys.readouterr().out
    assert 'What the nodes warned of' in page.read_text()
    assert main([str(night), '--max', 'robot1/detector.refused=1']) == 3


def test_pictures_of_a_bag_are_found_by_their_stamps_as_some_may_be_missing(tmp_path):
    images = list(open_source(SCENE))
    bag = write_bag(tmp_path / 'pictures', {'/camera/image_raw': frames(SCENE)[::2]})
    stamps = np.array([image.stamp for image in images])
    there, missing = (FalseTrack(frame, 3, 5, 80.0, 60.0) for frame in (8, 9))
    found, lost = _pictures(str(bag), [there, missing], stamps)
    assert set(found) == {there}
    assert np.array_equal(found[there], picture_of(there, images[8].image))
    assert not lost


@pytest.mark.parametrize('kind', ['bag', 'video'])
def test_pictures_that_cannot_be_read_are_told_and_the_others_shown(tmp_path, capsys, kind):
    if kind == 'bag':
        pictures = short_bag(tmp_path / 'pictures', {'/camera/image_raw': frames(SCENE)})
        told = 'metadata.yaml tells of 65 messages on /camera/image_raw, 60 were read'
    else:
        pictures = damaged_video(tmp_path / 'pictures.mp4', 'mp4v')
        told = 'cannot be read'
    for name, new_ids in (('truth', []), ('run', [10, 250])):
        rows = [f'{k},{1 + sum(k >= new for new in new_ids)},80,60' for k in range(300)]
        (tmp_path / f'{name}.csv').write_text('\n'.join(['frame,id,u,v', *rows]))
    page = tmp_path / 'report.html'
    arguments = [str(tmp_path / 'run.csv'), '--truth', str(tmp_path / 'truth.csv'), '--radius=9']
    assert main([*arguments, '--html', str(page), '--pictures', str(pictures)]) == 0
    assert told in ' '.join(capsys.readouterr().out.split())
    assert page.read_text().count('<img') == 1


def bag_of_tracks(path, messages):
    bag = BagWriter(path, {'/t': CLOUD}, 'mcap')
    for message in messages:
        bag.write('/t', stamp_of(message.header), serialize_message(message))
    bag.close()
    return str(path)


def test_a_run_that_skipped_pictures_is_compared_by_stamps(tmp_path, capsys):
    """By their numbers, all frames after a gap would be compared with others."""
    track = ColorTracker()
    messages = [cloud_of_tracks(track(frame)) for frame in open_source(SCENE)]
    whole = bag_of_tracks(tmp_path / 'whole', messages)
    gap = bag_of_tracks(tmp_path / 'gap', messages[:20] + messages[25:])
    out = tmp_path / 'out.json'
    assert main([gap, '--against', whole, '--radius', '5', '--json', str(out)]) == 0
    (result,) = json.loads(out.read_text())
    measures = result['measures']
    assert (measures['misses'], measures['false'], measures['rmse']) == (5, 0, 0.0)
    assert measures['lost'] > 0
    assert 'message n' not in capsys.readouterr().out
    assert main([gap, '--truth', SCENE, '--radius', '5']) == 0
    assert 'message n is taken for frame n - 1' in ' '.join(capsys.readouterr().out.split())
