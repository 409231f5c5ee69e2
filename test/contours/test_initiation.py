from dataclasses import replace

import numpy as np
import pytest
from support.contour_pictures import corners_of
from support.contour_pictures import frame
from support.contour_pictures import overlap
from support.contour_pictures import picture

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours.initiation import Initiation
from colortrack_ros.contours.spline import Spline

CONFIG = ContourConfig(learn_seconds=0.0, start_interval=0.0)
NOBODY = np.zeros((0, 48, 2)), np.zeros(0, bool)


def both(first, second, level=45):
    """A quadrilateral and a person."""
    one = picture('quadrilateral', first, 20.0, level=level)
    return np.minimum(one, picture('person', second, 26.0, level=level, seed=1))


def shown(start, pictures, known=NOBODY):
    """What comes of each picture after six of the background alone."""
    empty = [picture('person', None, 0.0, seed=k) for k in range(6)]
    return [start.search(frame(p, k), *known) for k, p in enumerate([*empty, *pictures])][6:]


def test_areas_of_two_pictures_are_new_targets_with_their_outlines_and_velocities():
    results = shown(Initiation(CONFIG), [both((80, 60), (200, 150)), both((83, 61), (198, 154))])
    assert len(results[0][0]) == 0
    new, again = results[1]
    assert len(new) == 2
    assert len(again) == 0
    order = np.argsort(new.center[:, 0])
    np.testing.assert_allclose(new.center[order], [(83, 61), (198, 154)], atol=0.5)
    np.testing.assert_allclose(new.velocity[order] / 24, [(3, 1), (-2, 4)], atol=0.5)
    outlines = Spline(12).outline(new.nodes[order])
    assert overlap(outlines[0], corners_of('quadrilateral', (83, 61), 20.0)) > 0.82
    assert overlap(outlines[1], corners_of('person', (198, 154), 26.0)) > 0.82
    assert (new.misfit > 0).all()


def test_an_area_that_is_in_one_picture_alone_is_no_target():
    alone = picture('quadrilateral', (80, 60), 20.0)
    results = shown(Initiation(CONFIG), [alone, both((83, 61), (200, 150)), alone])
    assert [len(new) for new, _ in results] == [0, 1, 0]
    np.testing.assert_allclose(results[1][0].center, [(83, 61)], atol=0.5)


def test_where_something_has_been_nothing_starts():
    start, thing = Initiation(CONFIG), picture('quadrilateral', (80, 60), 20.0)
    empty = picture('person', None, 0.0)
    results = [start.search(frame(p, k), *NOBODY) for k, p in enumerate([thing] * 6 + [empty] * 6)]
    assert start._detector.mask.any()
    assert [len(new) for new, _ in results] == [0] * 12


@pytest.mark.parametrize('center', [(10, 60), (160, 232), (318, 100)])
def test_what_is_not_wholly_in_the_picture_does_not_start(center):
    results = shown(Initiation(CONFIG), [picture('quadrilateral', center, 20.0)] * 4)
    assert [len(new) for new, _ in results] == [0] * 4


def test_an_area_of_a_target_is_not_new_but_renews_it_when_it_is_worn():
    outline = corners_of('quadrilateral', (80, 60), 18.0)[None]
    pictures = [both((80, 60), (200, 150))] * 2
    known = np.repeat(outline, 12, axis=1), np.array([False])
    results = shown(Initiation(CONFIG), pictures, known)
    assert [(len(new), len(again)) for new, again in results] == [(0, 0), (1, 0)]
    results = shown(Initiation(CONFIG), pictures, (known[0], np.array([True])))
    assert [(len(new), len(again)) for new, again in results] == [(0, 1), (1, 1)]
    assert results[1][1].target.tolist() == [0]
    np.testing.assert_allclose(results[1][1].center, [(80, 60)], atol=0.5)


def test_when_most_of_the_picture_changes_nothing_starts():
    big = np.minimum(both((80, 60), (200, 150)), picture('quadrilateral', (200, 120), 95.0))
    assert [len(new) for new, _ in shown(Initiation(CONFIG), [big] * 4)] == [0] * 4


def test_it_is_time_for_a_look_now_and_then_and_for_a_second_one_at_once():
    start = Initiation(replace(CONFIG, start_interval=0.5))
    shown(start, [])
    times = []
    for k in range(6, 36):
        if start.is_time(round(k * 1e9 / 24)):
            times.append(k)
            start.search(frame(both((80, 60), (200, 150)), k), *NOBODY)
    assert times == [17, 18, 30, 31]


def test_on_the_box_nodes_are_equally_spaced_and_miss_nothing_that_is_known():
    results = shown(Initiation(replace(CONFIG, outline='box')), [both((80, 60), (200, 150))] * 2)
    new = results[1][0]
    steps = np.abs(np.diff(new.nodes, axis=1)).sum(axis=2)
    np.testing.assert_allclose(steps, np.tile(steps[:, :1], 11), rtol=0.35)
    assert (new.misfit == 0).all()
