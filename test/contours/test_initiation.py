import numpy as np

from colortrack_ros.contours.areas import Areas
from colortrack_ros.contours.areas import find_areas
from colortrack_ros.contours.initiation import Initiation

NOBODY = np.zeros((0, 4))


def areas(*places, size=20):
    """Squares with their left and top there."""
    mask = np.zeros((240, 320), np.uint8)
    for u, v in places:
        mask[v : v + size, u : u + size] = 255
    return find_areas(mask, 16, NOBODY)


def found(*frames):
    """Candidates of the last of some frames, a 25th of a second apart."""
    start = Initiation()
    for k, shown in enumerate(frames):
        result = start.candidates(shown, 10**9 + 40_000_000 * k)
    return result


def test_areas_of_two_frames_are_candidates_with_their_velocities():
    result = found(areas((80, 60), (200, 150)), areas((198, 154), (83, 61)))
    order = np.argsort(result.areas.center[:, 0])
    np.testing.assert_allclose(result.areas.center[order], [(92.5, 70.5), (207.5, 163.5)])
    np.testing.assert_allclose(result.velocity[order], [(75, 25), (-50, 100)])


def test_an_area_that_is_in_one_frame_alone_is_no_candidate():
    result = found(areas((80, 60)), areas((83, 61), (200, 150)))
    np.testing.assert_allclose(result.areas.center, [(92.5, 70.5)])


def test_what_is_farther_away_than_it_is_large_is_another_thing():
    assert len(found(areas((80, 60)), areas((99, 60)))) == 1
    assert len(found(areas((80, 60)), areas((101, 60)))) == 0


def test_after_a_restart_it_takes_two_frames_again():
    start = Initiation()
    start.candidates(areas((80, 60)), 0)
    start.restart()
    assert len(start.candidates(areas((83, 61)), 10**9)) == 0
    assert len(start.candidates(areas((86, 62)), 2 * 10**9)) == 1


def test_the_same_stamp_twice_makes_no_candidates():
    start = Initiation()
    assert len(start.candidates(areas((80, 60)), 7)) == 0
    assert len(start.candidates(areas((80, 60)), 7)) == 0
    assert len(start.candidates(Areas.none(), 8)) == 0
