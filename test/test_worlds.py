import sys

import numpy as np
import pytest
from support.paths import ROOT

sys.path.append(str(ROOT / 'benchmark'))

from worlds.following import follow
from worlds.following import kept
from worlds.following import known
from worlds.identities import post
from worlds.motions import bouncing
from worlds.motions import straight
from worlds.motions import weaving
from worlds.report import choose
from worlds.report import measure
from worlds.report import WORLDS
from worlds.rivals import textbook
from worlds.textbook import matched
from worlds.world import Figure
from worlds.world import judge
from worlds.world import observe
from worlds.world import play

from colortrack_ros.data import TRACK


@pytest.mark.parametrize('motion', [straight, weaving, bouncing])
def test_velocity_is_the_derivative_of_position(motion):
    position, velocity = motion(np.random.default_rng(1), 4, 40)
    difference = (position[2:] - position[:-2]) * 15
    error = np.abs(difference - velocity[1:-1])
    assert np.quantile(error, 0.85) < 2.0  # the rest are bounces


def test_the_filter_that_knows_the_noise_holds_what_its_ellipses_say():
    rng = np.random.default_rng(2)
    world = observe(straight(rng, 50, 100), rng, noise=3.0)
    book = known(world, *matched(world, 3.0, density=1e-6))
    end = book.take(book.frame == 99)
    nees = np.einsum('ni,nij,nj->n', end.error, np.linalg.inv(end.cov), end.error)
    assert nees.mean() == pytest.approx(4.0, abs=1.2)
    assert end.inside(0) == pytest.approx(95.0, abs=5.0)


def test_the_textbook_tracker_follows_who_is_apart():
    rng = np.random.default_rng(3)
    sequence = observe(straight(rng, 8, 90), rng).sequence()
    score = judge(sequence, textbook()(sequence))
    assert score.switches == 0
    assert score.idf1 > 0.95


def as_tracks(world, names):
    """Perfect tracks with these IDs, (K, N), and a standard deviation of 1 px and 1 px/s."""
    frames = []
    for k in range(len(names)):
        rows = np.zeros(names.shape[1], TRACK)
        rows['track_id'], (rows['u'], rows['v']) = names[k], world.position[k].T
        rows['du'], rows['dv'] = world.velocity[k].T
        rows['covariance'] = np.eye(4)
        frames.append(rows)
    return frames


def test_who_comes_back_under_another_name_is_told():
    rng, seen = np.random.default_rng(4), np.ones((60, 2), bool)
    seen[20:35] = False
    world = observe(straight(rng, 2, 60), rng, seen=seen)
    names = np.tile([1, 2], (60, 1))
    assert kept(world, as_tracks(world, names)).tolist() == [True, True]
    assert follow(world, as_tracks(world, names)).unseen.max() == 15
    names[35:, 1] = 3
    assert kept(world, as_tracks(world, names)).tolist() == [True, False]


def test_an_error_of_three_sigma_is_outside_of_the_ellipse():
    rng = np.random.default_rng(5)
    world = observe(straight(rng, 2, 30), rng)
    frames = as_tracks(world, np.tile([1, 2], (30, 1)))
    assert follow(world, frames).inside(0) == 100.0
    for rows in frames:
        rows['u'] += 3.0
    followed = follow(world, frames)
    assert (followed.inside(0), followed.inside(2)) == (0.0, 100.0)
    assert followed.rmse(0) == pytest.approx(3.0)


def test_an_option_that_the_tracker_does_not_have_is_left_out():
    rng = np.random.default_rng(6)
    world = observe(straight(rng, 2, 10), rng)
    assert len(play(world.detections, no_such_option=1)[-1]) == 2


@pytest.mark.slow
@pytest.mark.parametrize('name', ['3 time', '9 hidden for 1.4 s'])
def test_a_world_gives_the_same_figures_for_the_same_seed(name):
    assert repr(measure(WORLDS[name], [1], [])) == repr(measure(WORLDS[name], [1], []))


def test_means_are_taken_over_seeds_and_leave_out_what_is_not_known():
    def world(seed, rivals):
        yield Figure('number', seed, rival=np.nan if seed else 7.0)

    (line,) = measure(world, range(3), [])
    assert (line.now, line.rival) == (1.0, 7.0)


def test_worlds_are_chosen_by_point_and_by_name():
    assert choose(['4', 'vanish']) == ['4 mixed crowd', '5 vanish']
    assert len(choose(['1'])) == 8
    with pytest.raises(ValueError, match=r'unknown world .zebra.: there are 1 noise'):
        choose(['zebra'])


@pytest.mark.parametrize('seed', [2, 3, 5])
def test_pairs_of_unlike_sizes_that_bounce_behind_a_post_keep_their_ids(seed):
    swapped, own = post(seed, [])
    assert swapped.now == 0
    assert own.now == 100
