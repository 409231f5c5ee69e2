from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.cameras import encode
from support.contour_pictures import EMPTY
from support.contour_pictures import errors
from support.contour_pictures import follow
from support.contour_pictures import frame
from support.contour_pictures import pictures
from support.contour_pictures import QUICK
from support.contour_pictures import straight

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours import ContourTracker
from colortrack_ros.data import Frame
from colortrack_ros.encodings import LAYOUTS


@pytest.mark.slow
@pytest.mark.parametrize('k', [-5, 400])
def test_a_jump_of_the_stamps_starts_afresh(k):
    tracker = ContourTracker(QUICK)
    shown = pictures('quadrilateral', 60)
    for i, image in enumerate(shown[:30]):
        tracks = tracker.update(frame(image, i))
    assert len(tracks.rows) == 1
    tracks = tracker.update(frame(shown[30], k))
    assert ('went back' if k < 0 else 'jumped ahead') in tracks.restarted
    assert len(tracks.rows) == 0
    for i, image in enumerate(shown[31:]):
        tracks = tracker.update(frame(image, k + 1 + i))
        assert tracks.restarted == ''
    assert tracks.rows['track_id'].tolist() == [2]


@pytest.mark.slow
def test_after_a_reset_targets_start_again_before_the_background_that_is_known():
    tracker, shown, counts = ContourTracker(QUICK), pictures('quadrilateral', 60), []
    for i, image in enumerate(shown):
        if i == 30:
            tracker.reset('because')
        if i == 45:
            tracker.learn_background()
        tracks = tracker.update(frame(image, i))
        assert tracks.restarted == ('because' if i == 30 else '')
        counts.append(len(tracks.rows))
    assert counts[EMPTY + 4 : 30] == [1] * (26 - EMPTY)
    assert counts[30:] == [0] + [1] * 29
    assert tracks.rows['track_id'].tolist() == [2]


@pytest.mark.parametrize('start', ['background', 'difference'])
@pytest.mark.parametrize(('w', 'h', 'count'), [(1, 40, 0), (40, 1, 0), (4, 4, 0), (5, 5, 1)])
def test_what_an_outline_does_not_enclose_starts_nothing(start, w, h, count):
    """The area of a line is 0, and its middle is nowhere."""
    fine = ContourConfig(start=start, min_area=16, opening_size=1, blur_sigma=0.0)
    tracker = ContourTracker(replace(fine, learn_seconds=0.1))
    for i in range(60):
        image = np.full((240, 320), 100, np.uint8)
        if i >= 20:
            image[80 + i :, 40 + 2 * i :][:h, :w] = 220
        rows = tracker.update(frame(image, i)).rows
        assert np.isfinite(rows['u']).all()
    assert rows['track_id'].tolist() == count * [1]


def test_what_encloses_nothing_takes_no_place():
    """A line above a square, of which one may be followed."""
    fine = ContourConfig(start='background', min_area=16, opening_size=1, blur_sigma=0.0)
    tracker = ContourTracker(replace(fine, learn_seconds=0.1, max_targets=1))
    for i in range(40):
        image = np.full((240, 320), 100, np.uint8)
        if i >= 20:
            image[20 + i :, 40 + 2 * i :][:40, :1] = 220
            image[120:, 40 + 2 * i :][:20, :20] = 220
        rows = tracker.update(frame(image, i)).rows
    np.testing.assert_allclose(rows['v'], [129.5], atol=1)


@pytest.mark.parametrize('config', [QUICK, ContourConfig(), replace(QUICK, start='difference')])
def test_pictures_of_other_sizes_and_encodings_do_no_harm(config):
    tracker = ContourTracker(config)
    for i, image in enumerate(pictures('quadrilateral', 25)):
        tracker.update(frame(image, i))
    for i, shape in enumerate([(40, 50), (3, 3), (0, 0), (0, 40), (40, 0), (1, 2000)]):
        tracker.update(Frame(np.zeros(shape, np.uint8), 'mono8', frame(image, 25 + i).stamp))
    for i, (encoding, channels) in enumerate([('rgb8', 3), ('bgra8', 4), ('rgba8', 4)]):
        image = np.zeros((240, 320, channels), np.uint8)
        tracker.update(Frame(image, encoding, frame(image, 31 + i).stamp))


@pytest.mark.parametrize('start', ['background', 'difference'])
@pytest.mark.parametrize('shape', [(120, 160), (3, 3), (0, 0)])
def test_a_stream_that_changes_its_size_goes_on(start, shape):
    tracker = ContourTracker(ContourConfig(start=start, start_interval=0.05))
    for k, image in enumerate(pictures('quadrilateral', 40)):
        small = np.full(shape, 90, np.uint8)
        tracks = tracker.update(frame(image if k % 20 < 15 else small, k))
    assert np.isfinite(tracks.rows['u']).all()


@cache
def person():
    """The tracks of a person, followed once."""
    return follow(pictures('person', 40), QUICK)


@pytest.mark.slow
def test_the_encoding_changes_nothing_but_the_channels():
    tracker = ContourTracker(QUICK)
    for k, image in enumerate(pictures('person', 40)):
        four = np.dstack([image, image, image, np.full_like(image, 255)])
        tracks = tracker.update(Frame(four, 'bgra8', frame(image, k).stamp))
    np.testing.assert_allclose(tracks.rows['u'], person()[-1].rows['u'], atol=0.1)


@pytest.mark.slow
def test_the_same_stamp_twice_does_no_harm():
    tracker = ContourTracker(QUICK)
    for k, image in enumerate(pictures('quadrilateral', 40)):
        for _ in range(2):
            rows = tracker.update(frame(image, k)).rows
    assert abs(rows['u'][0] - straight(39)[0][0]) < 0.3


@pytest.mark.slow
def test_the_same_frames_give_the_same_tracks_to_the_bit():
    again = follow(pictures('person', 40), QUICK)
    assert [t.rows.tobytes() for t in again] == [t.rows.tobytes() for t in person()]


@pytest.mark.slow
def test_targets_live_through_another_configuration_and_start_again_with_other_nodes():
    tracker = ContourTracker(QUICK)
    for k, image in enumerate(pictures('person', 70)):
        if k == 20:
            tracker.configure(replace(QUICK, filters='two', sigma=4.0))
        if k == 30:
            tracker.configure(QUICK)
        if k == 40:
            tracker.configure(replace(QUICK, points=20))
        tracks = tracker.update(frame(image, k))
        assert ('points' in tracks.restarted) == (k == 40)
        if 20 < k < 40:
            assert tracks.rows['track_id'].tolist() == [1]
    assert tracks.rows['track_id'].tolist() == [2]
    assert tracks.outlines.shape == (1, 80, 2)


@pytest.mark.parametrize(
    ('name', 'value'),
    [
        ('start', 'contrast'), ('outline', 'hull'), ('filters', 'three'), ('points', 5),
        ('line_length', 2), ('sigma', 0.0), ('min_contrast', -1.0), ('no_edge', float('nan')),
        ('outlier', -1.0), ('min_found', 1.5), ('edge_variance', 0.0), ('motion_noise', -1.0),
        ('rate', 0.0), ('min_area', 0), ('opening_size', 4), ('max_targets', 0), ('max_dt', 0.0),
        ('mask', (1.0, 2.0)), ('mask', (1.0, 2.0, 1.0)), ('mask', (0.0, 0.0, 0.0)),
    ],
)  # fmt: skip
def test_a_bad_setting_is_refused_by_its_name(name, value):
    with pytest.raises(ValueError, match=f'^{name}: expected .*got'):
        ContourConfig(**{name: value})


@pytest.mark.slow
@pytest.mark.parametrize('encoding', list(LAYOUTS))
def test_the_target_is_followed_in_every_encoding(encoding):
    tracker = ContourTracker(QUICK)
    for k, image in enumerate(pictures('quadrilateral', 30)):
        shown = encode(np.dstack([image] * 3), encoding)
        tracks = tracker.update(replace(shown, stamp=frame(image, k).stamp))
    (_, error, covered), *_ = errors('quadrilateral', [tracks], lambda _: straight(29))
    assert error < 1.0
    assert covered > 0.85


@pytest.mark.parametrize(
    ('encoding', 'shape', 'kind'),
    [
        ('mono16', (240, 320), np.uint16),
        ('mono8', (240, 320), np.uint16),
        ('bgr8', (240, 320), np.uint8),
        ('nv12', (241, 320), np.uint8),
    ],
)
def test_a_frame_that_is_not_what_it_says_is_refused_and_changes_nothing(encoding, shape, kind):
    tracker = ContourTracker(QUICK)
    for k, image in enumerate(pictures('quadrilateral', 30)):
        tracks = tracker.update(frame(image, k))
        with pytest.raises(ValueError, match=r'^(encoding|image\.\w+): expected '):
            tracker.update(Frame(np.zeros(shape, kind), encoding, frame(image, k + 0.5).stamp))
    assert tracks.rows['track_id'].tolist() == [1]
