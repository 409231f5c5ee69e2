"""Frames by number, and what is found in them while somebody plays, scrubs and tunes."""

import numpy as np
import pytest

from colortrack_ros.chain import ColorTracker
from colortrack_ros.data import Frame
from colortrack_ros.sources import open_source
from colortrack_ros.tuner import footage as footage_file
from colortrack_ros.tuner import opening
from colortrack_ros.tuner.footage import LiveFootage
from colortrack_ros.tuner.footage import RecordedFootage
from colortrack_ros.tuner.running import RunningNodes
from colortrack_ros.tuner.settings import Settings
from colortrack_ros.tuner.view import AS_BEFORE
from colortrack_ros.tuner.view import LENGTHS
from colortrack_ros.tuner.workbench import Workbench

SCENE = 'scene:five?width=320&height=180&duration=6'


def recorded(spec=SCENE):
    return RecordedFootage(spec, lambda: open_source(spec))


def caught_up(bench):
    while bench.catch_up():
        pass
    return bench.view


def test_a_frame_is_the_same_whichever_way_one_comes_to_it(monkeypatch):
    frames = list(open_source(SCENE))
    monkeypatch.setattr(footage_file, 'KEPT_BYTES', 10 * frames[0].image.nbytes)
    footage = recorded()
    for number in (0, 5, 3, 100, 20, 143, 0):
        found = footage.frame(number)
        assert found.stamp == frames[number].stamp
        assert np.array_equal(found.image, frames[number].image)
    assert footage.frame(144) is None
    assert footage.total == 144


@pytest.mark.slow
def test_the_tracks_of_a_frame_are_those_of_the_chain_however_one_comes_to_it():
    track = ColorTracker()
    expected = [track(frame).rows for frame in open_source(SCENE)]
    bench = Workbench(recorded(), Settings())
    for number in (100, 60, 61):
        bench.seek(number)
        assert bench.view.tracks is None
        assert len(bench.view.detections.rows) > 0
        assert np.array_equal(caught_up(bench).tracks.rows, expected[number])
    bench.step()
    assert np.array_equal(bench.view.tracks.rows, expected[62])
    bench.play()
    while bench.playing:
        bench.step()
    assert bench.view.number == 143
    assert np.array_equal(bench.view.tracks.rows, expected[143])


def test_a_change_shows_in_the_frame_that_is_looked_at_and_in_its_tracks():
    bench = Workbench(recorded(), Settings())
    bench.seek(60)
    assert len(caught_up(bench).tracks.rows) > 0
    bench.settings.change('detector', {'min_area': 100_000})
    bench.configure()
    assert len(bench.view.detections.rows) == 0
    assert len(caught_up(bench).tracks.rows) == 0
    bench.settings.undo()
    bench.configure()
    assert len(bench.view.detections.rows) > 0


def test_a_camera_is_shown_as_it_is_now_and_its_last_frames_again(monkeypatch):
    frames = list(open_source(SCENE))
    monkeypatch.setattr(footage_file, 'KEPT_BYTES', 20 * frames[0].image.nbytes)
    footage = LiveFootage('/camera')
    bench = Workbench(footage, Settings())
    assert bench.view is None
    assert not bench.step()
    assert bench.playing
    for frame in frames[:50]:
        footage.put(frame)
    assert bench.step()
    assert bench.view.number == 49
    assert not bench.step()
    bench.seek(0)
    assert caught_up(bench).number == 30
    bench.seek(35)
    assert caught_up(bench).number == 35
    assert len(bench.view.tracks.rows) > 0
    footage.put(frames[50])
    bench.play()
    bench.step()
    assert bench.view.number == 50


def live(frames, monkeypatch, *, kept):
    """A camera of which only the last frames are kept, and its workbench."""
    monkeypatch.setattr(footage_file, 'KEPT_BYTES', kept * frames[0].image.nbytes)
    footage = LiveFootage('/camera')
    for frame in frames:
        footage.put(frame)
    return footage, Workbench(footage, Settings())


@pytest.mark.parametrize('more', [5, 15, 60])
def test_a_camera_that_is_paused_shows_that_frame_while_those_before_it_are_dropped(
    monkeypatch, more
):
    frames = list(open_source(SCENE))
    footage, bench = live(frames[:50], monkeypatch, kept=20)
    bench.step()
    bench.pause()
    paused = bench.view
    for frame in frames[50 : 50 + more]:
        footage.put(frame)
    for _ in range(2):
        bench.configure()
        shown = caught_up(bench)
        assert shown.number == paused.number == 49
        assert shown.frame is paused.frame
        assert shown.tracks.stamp == shown.detections.stamp == paused.frame.stamp


def test_frames_that_a_camera_drops_while_it_catches_up_are_not_shown_as_others(monkeypatch):
    frames = list(open_source(SCENE))
    footage, bench = live(frames[:50], monkeypatch, kept=20)
    bench.step()
    bench.pause()
    bench.configure()
    given = footage.frame

    def given_late(number):
        frame = given(number)
        footage.put(frames[footage.total % len(frames)])
        footage.put(frames[footage.total % len(frames)])
        return frame

    monkeypatch.setattr(footage, 'frame', given_late)
    shown = caught_up(bench)
    assert shown.number == 49
    assert shown.frame.stamp == frames[49].stamp
    assert shown.tracks.stamp == shown.detections.stamp == frames[49].stamp


def test_the_first_frame_of_a_camera_has_its_own_number_when_it_is_dropped_meanwhile(monkeypatch):
    frames = list(open_source(SCENE))
    footage, bench = live(frames[:50], monkeypatch, kept=20)
    given = footage.frame

    def given_and_dropped(number):
        frame = given(number)
        footage.put(frames[footage.total])
        return frame

    monkeypatch.setattr(footage, 'frame', given_and_dropped)
    bench.seek(0)
    assert bench.view.frame.stamp == frames[bench.view.number].stamp


def test_a_picture_without_pixels_is_shown_as_nothing():
    footage = LiveFootage('/camera')
    footage.put(Frame(np.zeros((0, 0, 3), np.uint8)))
    bench = Workbench(footage, Settings())
    assert LENGTHS.unpack_from(bench.view.encoded())[1] == 0
    assert LENGTHS.unpack_from(bench.view.encoded(has_picture=True))[1] == AS_BEFORE


@pytest.mark.parametrize('encoding', ['bgr8', 'mono8', 'yuyv'])
def test_pictures_of_any_encoding_are_shown(encoding):
    shape = {'bgr8': (20, 30, 3), 'mono8': (20, 30), 'yuyv': (20, 30, 2)}[encoding]
    footage = LiveFootage('/camera')
    footage.put(Frame(np.full(shape, 90, np.uint8), encoding))
    assert b'JFIF' in Workbench(footage, Settings()).view.encoded()


def test_the_address_of_a_stream_is_shown_without_its_password(monkeypatch):
    class Stream(list):
        live = True

        def close(self):
            pass

    monkeypatch.setattr(opening, 'open_source', lambda *_: Stream())
    footage = opening.open_footage('rtsp://me:secret@camera/front?key=5', RunningNodes())
    assert footage.label == 'rtsp://me:***@camera/front?***'
    footage.close()
