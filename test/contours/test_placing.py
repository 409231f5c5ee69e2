from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
import pytest
from support.contour_pictures import corners_of
from support.contour_pictures import overlap
from support.contour_pictures import SHAPES

from colortrack_ros.contours import placing
from colortrack_ros.contours.placing import along_outline
from colortrack_ros.contours.placing import equally_spaced
from colortrack_ros.contours.spline import Spline

CENTER = (150.0, 120.0)


def dense(polygon, count=400):
    """Points all along a polygon."""
    closed = np.concatenate([polygon, polygon[:1]])
    way = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    s = np.arange(count) / count * way[-1]
    return np.stack([np.interp(s, way, column) for column in closed.T], axis=1)


@pytest.mark.parametrize('shape', SHAPES)
@pytest.mark.parametrize('backward', [False, True])
def test_twelve_nodes_follow_an_outline(shape, backward):
    outline = corners_of(shape, CENTER, 40.0)
    spline = Spline(12)
    nodes, miss = along_outline(dense(outline)[:: -1 if backward else 1], spline)
    assert spline.area(nodes) > 0
    assert overlap(spline.outline(nodes), outline) > 0.95
    assert np.hypot(*(spline.centroid(nodes)[0] - CENTER)) < 0.3
    assert 0.1 < miss < 2.5


def test_more_nodes_follow_better_than_equally_spaced_ones():
    outline = dense(corners_of('person', CENTER, 40.0))
    misses = [along_outline(outline, Spline(n))[1] for n in (12, 16, 24, 32)]
    assert misses == sorted(misses, reverse=True)
    equal = outline[(np.arange(12) / 12 * len(outline)).astype(int)]
    placed = along_outline(outline, Spline(12))[0]
    better = overlap(Spline(12).outline(placed), outline)
    assert better > overlap(Spline(12).outline(equal), outline) + 0.01


@pytest.mark.slow
@given(st.integers(0, 1000), st.integers(6, 20))
@settings(max_examples=20, deadline=None)
def test_nodes_lie_on_the_outline_whatever_it_is(seed, n):
    rng = np.random.default_rng(seed)
    polygon = rng.uniform(0, 100, (int(rng.integers(3, 12)), 2))
    nodes, miss = along_outline(polygon, Spline(n))
    assert nodes.shape == (n, 2)
    assert np.isfinite(nodes).all()
    assert miss >= 0
    far = np.linalg.norm(nodes[:, None] - dense(polygon, 20_000), axis=2).min(axis=1)
    assert far.max() < 0.1


@pytest.mark.parametrize('outline', [[[5, 5]] * 9, [[1, 1], [2, 2], [3, 3]], [[4, 4]]])
def test_outlines_without_an_area_do_no_harm(outline):
    nodes, _ = along_outline(np.array(outline, float), Spline(12))
    assert np.isfinite(nodes).all()


def test_along_a_box_they_are_equally_spaced():
    box = np.array([(10, 20), (40, 20), (40, 80), (10, 80)], float)
    nodes = equally_spaced(box, Spline(12))
    assert nodes[0].tolist() == [10, 20]
    steps = np.abs(np.diff(nodes, axis=0)).sum(axis=1)
    np.testing.assert_allclose(steps, 15)
    assert (nodes.min(axis=0) == [10, 20]).all()
    assert (nodes.max(axis=0) == [40, 80]).all()


@pytest.mark.parametrize('n', [12, 64])
def test_placing_is_bounded_work_whatever_the_outline(n, monkeypatch):
    """The longest work of a frame, counted in curves: it made one take ten times the others."""
    curves, cost = [], placing._Outline.cost
    monkeypatch.setattr(
        placing._Outline, 'cost', lambda self, place: curves.append(len(place)) or cost(self, place)
    )
    random = np.random.default_rng(0)
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    ragged = np.stack([np.cos(angle), np.sin(angle)], axis=1) * random.uniform(20, 90, (400, 1))
    along_outline(ragged, Spline(n))
    assert sum(curves) <= placing.PHASES + placing.MAX_ROUNDS * 2 * n
