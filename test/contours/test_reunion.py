"""Targets that come out from behind a cover beside where they are expected."""

import numpy as np
import pytest
from support.contour_pictures import EMPTY
from support.contour_pictures import follow
from support.contour_pictures import known
from support.contour_pictures import picture
from support.contour_pictures import pictures
from support.contour_pictures import QUICK
from support.contour_pictures import straight

from colortrack_ros.data import CONFIRMED

GONE = 30
"""The picture in which nothing is seen any more."""


def reappears(shift):
    """A person who walks, is not seen for four pictures, and comes out so far beside its way [px].

    What is seen first are the feet.
    """

    def place(k):
        (u, v), _ = straight(k)
        return (u + (shift if k > GONE else 0.0), v), 40.0

    shown = pictures('person', 60, place)
    for k in range(GONE, GONE + 4):
        shown[k] = picture('person', None, 0.0, seed=k)
    for k in range(GONE + 4, GONE + 10):
        shown[k] = picture('person', *place(k), cover=(slice(150), 215), seed=k)
    return place, follow(shown, QUICK)


def every_id(results):
    return {i for tracks in results for i in tracks.rows['track_id'].tolist()}


@pytest.mark.slow
def test_what_comes_out_beside_its_way_goes_on_with_its_id():
    place, results = reappears(50.0)
    assert results[GONE - 1].rows['track_id'].tolist() == [1]
    (row,) = results[-1].rows
    assert row['state'] == CONFIRMED
    assert np.hypot(row['u'] - place(59)[0][0], row['v'] - place(59)[0][1]) < 1.0
    assert every_id(results) == {1}


@pytest.mark.slow
def test_what_comes_out_elsewhere_is_something_else():
    _, results = reappears(90.0)
    assert every_id(results) == {1, 2}
    assert 1 not in results[-1].rows['track_id'][results[-1].rows['state'] == CONFIRMED]


@pytest.mark.slow
@pytest.mark.parametrize('speed', [2.5, -2.5])
def test_the_feet_of_somebody_behind_a_sign_are_not_told(speed):
    """A person stops behind a sign for 2.5 s, comes out, and is told again with the same ID.

    Its contour holds its height for 0.8 s more.
    """

    def place(k):
        walked = np.clip(k - EMPTY, 0, 44) + np.clip(k - 110, 0, None)
        return (170.0 + speed * (walked - 44), 120.0), 40.0

    cover = (np.s_[:148, 130:210], 215)
    results = follow(pictures('person', 136, place, cover=cover), QUICK)
    before, behind, after = results[40], results[75:93], results[-1]
    assert before.rows['box_h'].tolist() == pytest.approx([90.0], abs=2.0)
    assert not any(known(tracks).any() for tracks in behind)
    assert after.rows['track_id'][known(after)].tolist() == [1]
    assert after.rows['box_h'][known(after)].tolist() == pytest.approx([90.0], abs=4.0)
