"""Films whose pictures come at uneven times."""

import cv2
import numpy as np
import pytest
from support.paths import DATA

from colortrack_ros.sources import open_source
from colortrack_ros.sources import SourceError


def video_with(times, path, monkeypatch, count, rate):
    """A file as OpenCV tells of it: times of its pictures [ms], their number, and the rate."""
    place = [-1]

    class Capture:
        def __init__(self, path, interface):
            place[0] = -1

        def get(self, which):
            if which == cv2.CAP_PROP_POS_MSEC:
                return times[place[0]]
            return {cv2.CAP_PROP_FPS: rate, cv2.CAP_PROP_FRAME_COUNT: count}[which]

        def read(self):
            place[0] += 1
            return place[0] < len(times), np.zeros((4, 4, 3), np.uint8)

        def set(self, which, value):
            return False

        def grab(self):
            return self.read()[0]

        def release(self):
            pass

    monkeypatch.setattr(cv2, 'VideoCapture', Capture)
    path.touch()
    return open_source(str(path))


def test_the_last_picture_of_a_varying_rate_keeps_its_time(tmp_path, monkeypatch):
    times = [0.0, 100.0, 250.0, 400.0]
    source = video_with(times, tmp_path / 'a.mp4', monkeypatch, count=4, rate=4 / 0.3)
    assert [frame.stamp / 1e6 for frame in source] == pytest.approx(times)
    source.rewind()
    assert source.read().stamp / 1e6 > times[-1]


PLACES = np.arange(120)
"""Of pictures at 25 Hz, of which a file promises as many as fit into its duration."""

GAP = (PLACES < 40) | (PLACES >= 70)


@pytest.mark.parametrize(
    ('there', 'lost'),
    [
        (np.random.default_rng(0).random(120) < 0.5, 0),
        ((PLACES < 60) | (PLACES % 4 == 3), 0),
        (PLACES % 3 == 0, 0),
        (GAP, 30),
        (PLACES < 80, 40),
        ((PLACES < 60) & (PLACES % 2 == 0), 90),
    ],
    ids=['at random', 'slower', 'one in three', 'damaged', 'cut off', 'slow and cut off'],
)
def test_pictures_that_a_varying_rate_leaves_out_are_not_lost(tmp_path, monkeypatch, there, lost):
    """Matroska and others tell the duration, which times the rate is no number of pictures."""
    times = 40.0 * PLACES[there]
    source = video_with(times, tmp_path / 'a.mkv', monkeypatch, count=120, rate=25.0)
    frames = []
    if lost:
        with pytest.raises(SourceError, match=f'{lost} more are missing'):
            frames += source
    frames += source
    assert source.lost == lost


@pytest.mark.slow
@pytest.mark.skipif(not DATA.exists(), reason='needs ../shared/data')
def test_pictures_at_uneven_times_keep_their_times():
    source = open_source(str(DATA / 'ball_toss' / 'ball4.mp4'))
    stamps = [frame.stamp for frame in source]
    capture, times = cv2.VideoCapture(str(DATA / 'ball_toss' / 'ball4.mp4'), cv2.CAP_FFMPEG), []
    while capture.grab():
        times.append(capture.get(cv2.CAP_PROP_POS_MSEC) * 1e6)
    assert source.lost == 0
    np.testing.assert_allclose(stamps, times, rtol=0, atol=0.51e6)
    assert np.abs(times - np.arange(len(times)) * source.period).max() > 30e6
