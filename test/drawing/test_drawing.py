from dataclasses import replace

import cv2
from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
import pytest
from support.full_disk import file_size_limit

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import TRACK
from colortrack_ros.data import Tracks
from colortrack_ros.drawing import draw_tracks
from colortrack_ros.drawing import track_color
from colortrack_ros.drawing import Trails
from colortrack_ros.drawing import VideoFile
from colortrack_ros.drawing import write_picture


def tracks_of(*positions, state=CONFIRMED, size=40.0, variance=9.0, first_id=1):
    rows = np.zeros(len(positions), TRACK)
    rows['track_id'] = np.arange(len(positions)) + first_id
    rows['u'], rows['v'] = np.array(positions, float).reshape(-1, 2).T
    rows['state'] = state
    rows['box_w'] = rows['box_h'] = size
    with np.errstate(over='ignore'):  # some are farther away than singles reach
        rows['box_u'], rows['box_v'] = rows['u'] - (size - 1) / 2, rows['v'] - (size - 1) / 2
    rows['covariance'][:, :2, :2] = variance * np.eye(2)
    return Tracks(rows)


def drawn(tracks, trails=None, height=240, width=320):
    image = np.zeros((height, width, 3), np.uint8)
    if trails is None:
        trails = Trails()
        trails.update(tracks)
    draw_tracks(image, tracks, trails)
    return image


def test_box_and_ellipse_are_where_the_track_is():
    image = drawn(tracks_of((160, 120), size=100.0, variance=100.0)).any(axis=2)
    v, u = np.nonzero(image)
    assert (u.min(), u.max()) == pytest.approx((110, 210), abs=2)
    assert v.max() == pytest.approx(170, abs=2)
    ellipse = np.flatnonzero(image[120, 112:209]) + 112
    radius = np.sqrt(5.991 * 100)
    assert (ellipse[0], ellipse[-1]) == pytest.approx((160 - radius, 160 + radius), abs=2)


def test_without_trails_all_but_trails_is_drawn():
    tracks, image = tracks_of((160, 120), size=100.0), np.zeros((240, 320, 3), np.uint8)
    draw_tracks(image, tracks)
    np.testing.assert_array_equal(image, drawn(tracks))


def test_a_box_is_drawn_where_it_is_not_around_the_centroid():
    tracks = tracks_of((160, 120), size=100.0, variance=0.01, state=TENTATIVE)
    tracks.rows['box_u'] -= 30
    tracks.rows['box_v'] += 40
    v, u = np.nonzero(drawn(tracks).any(axis=2))
    assert (u.min(), u.max()) == pytest.approx((80, 180), abs=2)
    assert (v[u < 150].min(), v.max()) == pytest.approx((110, 210), abs=2)


@pytest.mark.parametrize('state', [TENTATIVE, CONFIRMED, COASTING])
def test_an_outline_takes_the_place_of_the_box(state):
    tracks = tracks_of((160, 120), (60, 60), state=state, variance=0.01)
    outlines = np.array([[(150, 90), (210, 200), (110, 190)], [(np.nan, 0)] * 3], float)
    image = drawn(replace(tracks, outlines=outlines)).any(axis=2)
    sides = [(150, 90, 210, 200), (210, 200, 110, 190), (110, 190, 150, 90)]
    share = 1.0 if state != COASTING else 0.5
    for a, b, c, d in sides:
        t = np.linspace(0.05, 0.95, 50)
        near = image[np.rint(b + t * (d - b)).astype(int), np.rint(a + t * (c - a)).astype(int)]
        assert near.mean() == pytest.approx(share, abs=0.3)
    assert not image[100, 140]
    assert image[40:81, 40].mean() > 0.3  # what has no outline has its box


@pytest.mark.parametrize('lean', [150, -150])
def test_the_ellipse_leans_with_the_covariance(lean):
    tracks = tracks_of((160, 120), size=200.0)
    covariance = np.array([[300, lean], [lean, 100]])
    tracks.rows['covariance'][0, :2, :2] = covariance
    v, u = np.nonzero(drawn(tracks).any(axis=2)[40:200, 80:240])
    offsets = np.stack([u - 80, v - 80]).astype(float)
    distance = np.einsum('in,ij,jn->n', offsets, np.linalg.inv(covariance), offsets)
    assert np.median(distance) == pytest.approx(5.991, rel=0.05)
    assert np.mean(np.abs(np.sqrt(distance / 5.991) - 1) < 0.3) > 0.8


def test_each_state_looks_different():
    states = TENTATIVE, CONFIRMED, COASTING
    images = [drawn(tracks_of((160, 120), state=state)) for state in states]
    inked = [np.count_nonzero(image.any(axis=2)) for image in images]
    assert inked[1] > 1.2 * inked[2] > 1.2 * inked[0]
    gray = images[0].astype(int)
    assert (np.ptp(gray, axis=2) == 0).all()


def test_a_color_belongs_to_an_id_and_differs_from_its_neighbors():
    colors = np.array([track_color(i) for i in range(1, 41)])
    assert track_color(7) == track_color(7)
    apart = np.linalg.norm(colors[:, None] - colors[None], axis=2)
    assert all(apart[i, max(0, i - 4) : i].min(initial=999) > 60 for i in range(40))
    assert len(np.unique(colors, axis=0)) == 40


def test_a_trail_keeps_the_last_50_positions_and_fades():
    trails = Trails()
    for k in range(80):
        tracks = tracks_of((20 + 3 * k, 200), size=4.0, variance=0.1)
        trails.update(tracks)
    np.testing.assert_array_equal(trails.points[0, :, 0], 20 + 3.0 * np.arange(30, 80))
    line = drawn(tracks, trails)[200].max(axis=1)
    assert (line[:108] == 0).all()
    assert line[112] < 60 < line[170] < line[220] < line[250]


def test_trails_follow_ids_and_forget_tracks_that_are_gone():
    trails = Trails()
    trails.update(tracks_of((1, 1), (2, 2), (3, 3)))
    trails.update(tracks_of((20, 20), (30, 30), (40, 40), first_id=2))
    assert trails.ids.tolist() == [2, 3, 4]
    np.testing.assert_array_equal(trails.points[:, -2, 0], [2, 3, np.nan])
    np.testing.assert_array_equal(trails.points[:, -1, 0], [20, 30, 40])
    trails.update(Tracks())
    assert len(trails.ids) == len(trails.points) == 0


def test_a_track_of_a_tracker_that_was_started_again_has_a_trail_of_its_own():
    trails = Trails()
    before, after = tracks_of((20.0, 30.0)), tracks_of((300.0, 30.0))
    before.rows['age'] = 2.0
    for tracks in (before, before, after, after):
        trails.update(tracks)
    assert np.nanmin(trails.points[0, :, 0]) == 300.0
    assert np.isfinite(trails.points[0]).all(axis=1).sum() == 2


def test_no_tracks_leave_the_picture_as_it_is():
    assert not drawn(Tracks()).any()


def test_the_label_grows_with_the_picture_and_stays_inside():
    small, large = (drawn(tracks_of((5, 5)), height=h, width=2 * h) for h in (240, 1440))
    sizes = [np.count_nonzero((image == track_color(1)).all(axis=2)) for image in (small, large)]
    assert sizes[0] > 50
    assert sizes[1] > 5 * sizes[0]


numbers = st.floats(-1e300, 1e300)
sizes = st.floats(0, 2.0**100, width=32)


@pytest.mark.slow
@settings(max_examples=80, deadline=None)
@given(position=st.tuples(numbers, numbers), size=sizes, variance=st.floats(0, 1e300))
def test_anything_finite_can_be_drawn(position, size, variance):
    drawn(tracks_of(position, size=size, variance=variance))
    for state in (TENTATIVE, COASTING):
        drawn(tracks_of(position, (160, 120), state=state, size=size, variance=variance))


def test_a_box_much_wider_than_the_picture_crosses_it():
    tracks = tracks_of((160, 120))
    tracks.rows['box_u'], tracks.rows['box_w'] = -5e11, 1e12
    image = drawn(tracks).any(axis=2)
    assert image[100].all()
    assert image[140].all()


def test_what_is_around_the_picture_leaves_its_inside_as_it_is():
    assert not drawn(tracks_of((160, 120), size=1e20, variance=1e40))[50:, 100:].any()


def test_what_is_outside_the_picture_leaves_it_as_it_is():
    far = [(-500, 120), (900, 120), (160, -500), (160, 900)]
    for place in far:
        assert not drawn(tracks_of(place)).any()


def test_a_video_that_is_cut_short_leaves_what_was_there(tmp_path):
    film = tmp_path / 'film.mp4'
    film.write_bytes(b'old')
    noise = np.random.default_rng(1).integers(0, 255, (120, 160, 3), np.uint8)
    video = VideoFile(film, 30.0, (160, 120))
    with file_size_limit(20_000):
        for k in range(40):
            video.write(np.roll(noise, k, axis=1))
        with pytest.raises(OSError, match='0 of 40 frames have been written; is the disk full'):
            video.close()
    assert [(file.name, file.read_bytes()) for file in tmp_path.iterdir()] == [('film.mp4', b'old')]
    VideoFile(film, 30.0, (160, 120)).write(noise)  # nobody closes it
    assert [(file.name, file.read_bytes()) for file in tmp_path.iterdir()] == [('film.mp4', b'old')]


def test_a_single_picture_of_no_rate_is_a_video(tmp_path):
    video = VideoFile(tmp_path / 'film.mp4', 0.0, (64, 48))
    video.write(np.zeros((48, 64, 3), np.uint8))
    video.close()
    assert cv2.VideoCapture(str(tmp_path / 'film.mp4')).read()[0]


@pytest.mark.parametrize('rate', [0.05, 29.97, 149.7387, 997.009, 1e9])
def test_a_video_has_any_rate(tmp_path, rate):
    """Three digits of it were one too many for MPEG-4 at many rates above 65 Hz."""
    film = tmp_path / 'film.mp4'
    video = VideoFile(film, rate, (64, 48))
    for _ in range(2):
        video.write(np.zeros((48, 64, 3), np.uint8))
    video.close()
    written = cv2.VideoCapture(str(film)).get(cv2.CAP_PROP_FPS)
    assert written == pytest.approx(min(rate, 65535), rel=1e-3)


def test_pictures_too_small_for_a_video_are_told_by_their_size(tmp_path):
    with pytest.raises(OSError, match='no video of 1x1 px can be written'):
        VideoFile(tmp_path / 'film.mp4', 30.0, (1, 1))
    assert not list(tmp_path.iterdir())


def test_a_picture_on_a_full_disk_is_told_with_its_name(tmp_path):
    picture = tmp_path / 'picture.png'
    noise = np.random.default_rng(1).integers(0, 255, (120, 160, 3), np.uint8)
    with file_size_limit(20_000), pytest.raises(OSError, match='large') as raised:
        write_picture(picture, noise)
    assert raised.value.filename == str(picture)
    assert not list(tmp_path.iterdir())
