"""The five example videos of Pegoretti, chapter 4, at default parameters."""

import numpy as np
import pytest
from scipy.special import chdtri
from support.pipeline import run

from colortrack_ros.data import TENTATIVE
from colortrack_ros.evaluation import Tally
from colortrack_ros.scenes import open_scene

SCENES = ('single', 'enter_exit', 'five', 'crossing', 'occlusion')


@pytest.fixture(scope='module', params=SCENES)
def played(request):
    """Truth and live confirmed or coasting tracks of each frame of a scene."""
    scene = open_scene(request.param)
    truth = [scene.truth(k) for k in range(len(scene))]
    tracks = [step.tracks.rows for step in run(f'scene:{request.param}')]
    assert len(truth) == len(tracks)
    return truth, [rows[rows['state'] != TENTATIVE] for rows in tracks]


def score(truth, tracks, least_visible, max_distance):
    tally = Tally(max_distance)
    for objects, rows in zip(truth, tracks, strict=True):
        seen = objects[objects['visible'] >= least_visible]
        tally.add(
            [(row['id'], row['u'], row['v']) for row in seen],
            [(row['track_id'], row['u'], row['v']) for row in rows],
        )
    return tally.score()


@pytest.mark.slow
def test_every_object_keeps_one_id_and_no_track_is_false(played):
    truth, tracks = played
    result = score(truth, tracks, 0.0, max_distance=60.0)
    assert result.switches == 0
    assert {len(ids) for ids in result.tracks_of.values()} == {1}
    assert set(result.tracks_of) == {int(i) for rows in truth for i in rows['id']}
    followed = {ids[0] for ids in result.tracks_of.values()}
    assert {int(i) for rows in tracks for i in rows['track_id']} == followed


@pytest.mark.slow
def test_an_object_is_tracked_in_every_frame_from_its_confirmation_to_its_exit(played):
    truth, tracks = played
    track_of = score(truth, tracks, 0.0, max_distance=60.0).tracks_of
    assert track_of
    for one, (track,) in track_of.items():
        alive = np.array([track in rows['track_id'] for rows in tracks])
        present = np.array([one in rows['id'] for rows in truth])
        first, last = np.flatnonzero(alive)[0], np.flatnonzero(present)[-1]
        assert alive[first : last + 1].all()
        wholly = [
            k for k, rows in enumerate(truth) if (rows['visible'][rows['id'] == one] == 1).any()
        ]
        assert first <= wholly[0] + 5


@pytest.mark.slow
def test_the_position_is_within_a_pixel_of_the_truth_while_visible(played):
    truth, tracks = played
    result = score(truth, tracks, 1.0, max_distance=60.0)
    assert result.rmse < 1.0
    assert result.misses <= 5 * len(result.tracks_of)


@pytest.mark.slow
def test_the_published_95_percent_ellipse_holds_the_truth_and_is_not_far_too_large(played):
    """The errors are mostly systematic, so that their squares are no chi-square."""
    squares, partly = [], []
    for objects, rows in zip(*played, strict=True):
        for row in rows:
            error = np.stack([objects['u'] - row['u'], objects['v'] - row['v']], axis=1)
            far = np.hypot(*error.T)
            if far.min(initial=60.0) < 60.0:  # else it coasts after its object has left
                e = error[far.argmin()]
                squares.append(e @ np.linalg.solve(row['covariance'][:2, :2], e))
                partly.append(objects['visible'][far.argmin()] < 1)
    inside = np.array(squares) < chdtri(2, 0.05)
    assert inside.mean() >= 0.9
    assert not any(partly) or inside[partly].mean() >= 0.9
    assert np.median(squares) > 0.25
