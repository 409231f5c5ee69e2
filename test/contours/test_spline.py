from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
import pytest

from colortrack_ros.contours.spline import SEGMENT_POINTS
from colortrack_ros.contours.spline import Spline


def contour(seed, n, count=None):
    """Random star-shaped nodes (n, 2), or (count, n, 2)."""
    rng = np.random.default_rng(seed)
    angle = 2 * np.pi * (np.arange(n) + rng.uniform(0, 0.5, (count or 1, n))) / n
    radius = rng.uniform(15, 40, (count or 1, n))
    nodes = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    nodes += rng.uniform(-100, 300, (count or 1, 1, 2))
    return nodes if count else nodes[0]


def textbook(control, t, i):
    """A point of segment i of a closed quadratic B-spline, and its derivative."""
    n = len(control)
    before, at, after = control[(i - 1) % n], control[i], control[(i + 1) % n]
    point = (1 - t) ** 2 / 2 * before + (0.5 + t - t * t) * at + t * t / 2 * after
    return point, (t - 1) * before + (1 - 2 * t) * at + t * after


def control_of(nodes):
    """The control points of a curve that passes through the nodes, by solving for them."""
    n = len(nodes)
    matrix = np.zeros((n, n))
    for i in range(n):
        matrix[i, (i - 1) % n], matrix[i, i], matrix[i, (i + 1) % n] = 0.125, 0.75, 0.125
    return np.linalg.solve(matrix, nodes)


def polygon_moments(points):
    """Area and centroid of a polygon, corner by corner."""
    area, moment = 0.0, np.zeros(2)
    for p, q in zip(points, np.roll(points, -1, axis=0), strict=True):
        cross = p[0] * q[1] - p[1] * q[0]
        area += cross / 2
        moment += (p + q) * cross / 6
    return area, moment / area


@pytest.mark.slow
@given(st.integers(0, 1000), st.integers(6, 20), st.booleans())
@settings(max_examples=30, deadline=None)
def test_outlines_and_normals_are_those_of_the_textbook(seed, n, interpolating):
    nodes = contour(seed, n)
    spline = Spline(n, interpolating=interpolating)
    control = control_of(nodes) if interpolating else nodes
    steps = (np.arange(SEGMENT_POINTS) + 0.5) / SEGMENT_POINTS
    wanted = [textbook(control, t, i)[0] for i in range(n) for t in steps]
    np.testing.assert_allclose(spline.outline(nodes), wanted, atol=1e-9)
    for i, normal in enumerate(spline.normals(nodes)):
        point, tangent = textbook(control, 0.5, i)
        assert abs(normal @ tangent) < 1e-9 * np.hypot(*tangent)
        assert np.hypot(*normal) == pytest.approx(1)
        if interpolating:
            np.testing.assert_allclose(point, nodes[i], atol=1e-9)


def test_normals_of_positive_areas_point_outward():
    nodes = contour(3, 12)
    spline = Spline(12)
    assert spline.area(nodes) > 0
    assert spline.area(nodes + 2 * spline.normals(nodes)) > spline.area(nodes)
    assert spline.area(nodes[::-1]) < 0


@pytest.mark.slow
@given(st.integers(0, 1000), st.integers(6, 20), st.booleans())
@settings(max_examples=20, deadline=None)
def test_area_and_centroid_are_those_of_a_polygon_of_very_many_corners(seed, n, interpolating):
    nodes = contour(seed, n, count=2)
    spline = Spline(n, interpolating=interpolating)
    center = spline.center(nodes)
    np.testing.assert_array_equal(center, spline.centroid(nodes)[0])
    for k in range(2):
        control = control_of(nodes[k]) if interpolating else nodes[k]
        dense = [textbook(control, t, i)[0] for i in range(n) for t in np.arange(100) / 100]
        area, middle = polygon_moments(np.array(dense))
        assert spline.area(nodes)[k] == pytest.approx(area, rel=1e-3)
        np.testing.assert_allclose(center[k], middle, atol=0.01)


@given(st.integers(0, 1000), st.integers(6, 20))
@settings(max_examples=20, deadline=None)
def test_the_derivatives_of_the_centroid_are_its_differences(seed, n):
    nodes, spline = contour(seed, n), Spline(n)
    change = spline.centroid(nodes)[1]
    for i in range(n):
        for axis in range(2):
            step = np.zeros((n, 2))
            step[i, axis] = 1e-4
            ahead, behind = spline.centroid(nodes + step)[0], spline.centroid(nodes - step)[0]
            np.testing.assert_allclose(change[:, i, axis], (ahead - behind) / 2e-4, atol=1e-6)


def test_the_covariance_of_the_centroid_is_that_of_many_contours():
    rng = np.random.default_rng(1)
    nodes, spline = contour(5, 12), Spline(12)
    root = rng.normal(0, 0.3, (24, 24))
    moved = nodes + (rng.normal(size=(20_000, 24)) @ root.T).reshape(-1, 12, 2)
    change = spline.centroid(nodes)[1].reshape(2, 24)
    carried = change @ (root @ root.T) @ change.T
    seen = np.cov(spline.centroid(moved)[0].T)
    np.testing.assert_allclose(carried, seen, atol=0.05 * np.trace(seen))


def test_a_contour_without_area_has_no_centroid_and_does_no_harm():
    center, _ = Spline(8).centroid(np.zeros((1, 8, 2)))
    assert np.isnan(center).all()
