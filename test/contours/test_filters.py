import numpy as np
import pytest
from scipy.special import chdtri

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours.filters import Contours
from colortrack_ros.contours.filters import motion_matrix
from colortrack_ros.contours.filters import MOTION_SIZE
from colortrack_ros.contours.gating import gate
from colortrack_ros.contours.spline import Spline

N = 12
SPLINE = Spline(N)
JOINT = ContourConfig(rotation=True, motion_noise=0.05, shape_noise=0.02)
TWO = ContourConfig(filters='two', motion_noise=0.05, shape_noise=0.02)


def circle(count=1, radius=30.0):
    angle = 2 * np.pi * np.arange(N) / N
    nodes = 100 + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.tile(nodes, (count, 1, 1))


def textbook_motion_matrix(nodes):
    """H of (6), with rotation, row by row."""
    center = nodes.mean(axis=0)
    rows = []
    for x, y in nodes - center:
        rows += [[1, 0, x, -y], [0, 1, y, x]]
    return np.array(rows)


def filled(seed, config, count=3):
    """Contours in the middle of their life, with edges to take in."""
    rng = np.random.default_rng(seed)
    contours = Contours.new(circle(count), rng.normal(0, 2, (count, 2)), config)
    contours.nodes += rng.normal(0, 1, contours.nodes.shape)
    contours.motion += rng.normal(0, 0.01, contours.motion.shape) * [1, 1, 1, config.rotation]
    found = rng.random((count, N)) < 0.8
    return contours, rng.normal(0, 1, (count, N)) * found, found


def test_the_prediction_is_that_of_the_textbook():
    contours, _, _ = filled(1, JOINT)
    before = Contours(*(part.copy() for part in vars(contours).values()))
    contours.predict(1.7, JOINT)
    for k in range(3):
        H = 1.7 * textbook_motion_matrix(before.nodes[k])
        np.testing.assert_allclose(motion_matrix(before.nodes)[k] * 1.7, H)
        F = np.block([[np.eye(2 * N), H], [np.zeros((MOTION_SIZE, 2 * N)), np.eye(MOTION_SIZE)]])
        Q = np.diag([0.02] * 2 * N + [0.05, 0.05, JOINT.scale_noise, JOINT.turn_noise])
        np.testing.assert_allclose(contours.cov[k], F @ before.cov[k] @ F.T + 1.7 * Q, atol=1e-12)
        np.testing.assert_allclose(contours.node_design[k], before.node_design[k] + 1.7 * 0.02)
        grown = before.motion_design[k] + 1.7 * Q[2 * N :, 2 * N :]
        np.testing.assert_allclose(contours.motion_design[k], grown)
        moved = before.nodes[k].ravel() + H @ before.motion[k]
        np.testing.assert_allclose(contours.nodes[k].ravel(), moved)


@pytest.mark.parametrize('config', [JOINT, ContourConfig()], ids=['rotation', 'none'])
def test_the_one_filter_is_the_textbooks(config):
    contours, offset, found = filled(2, config)
    contours.predict(1.0, config)
    normals = SPLINE.normals(contours.nodes)
    before = Contours(*(part.copy() for part in vars(contours).values()))
    contours.correct(offset, found, normals, 1.0, config)
    for k in range(3):
        seen = np.flatnonzero(found[k])
        H = np.zeros((len(seen), 2 * N + MOTION_SIZE))
        for row, i in enumerate(seen):
            H[row, 2 * i : 2 * i + 2] = normals[k, i]
        P, R = before.cov[k], config.edge_variance * np.eye(len(seen))
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        step = K @ offset[k, seen]
        np.testing.assert_allclose(
            contours.nodes[k].ravel(), before.nodes[k].ravel() + step[: 2 * N], atol=1e-6
        )
        np.testing.assert_allclose(contours.motion[k], before.motion[k] + step[2 * N :], atol=1e-6)
        A = np.eye(len(P)) - K @ H
        np.testing.assert_allclose(contours.cov[k], A @ P @ A.T + K @ R @ K.T, atol=1e-6)
        assert np.linalg.eigvalsh(contours.cov[k])[0 if config.rotation else 1] > 0


def test_deviations_are_those_of_the_nodes_along_the_normals():
    contours, _, _ = filled(5, JOINT)
    contours.predict(2.0, JOINT)
    normals = SPLINE.normals(contours.nodes)
    for k, deviations in enumerate(contours.sigma_along(normals)):
        for i, deviation in enumerate(deviations):
            block = contours.cov[k, 2 * i : 2 * i + 2, 2 * i : 2 * i + 2]
            assert deviation**2 == pytest.approx(normals[k, i] @ block @ normals[k, i])


def test_two_filters_are_7_and_then_8():
    contours, offset, found = filled(3, TWO)
    found[:] = True
    contours.predict(1.0, TWO)
    normals = SPLINE.normals(contours.nodes)
    before = Contours(*(part.copy() for part in vars(contours).values()))
    contours.correct(offset, found, normals, 1.0, TWO)
    v = TWO.edge_variance
    for k in range(3):
        predicted = before.nodes[k].ravel()  # X_{k-1} + H M'
        H, P = textbook_motion_matrix(before.nodes[k]), before.motion_design[k]
        Z = predicted + (offset[k][:, None] * normals[k]).ravel()
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + v * np.eye(2 * N))
        motion = before.motion[k] + K @ (Z - predicted)
        np.testing.assert_allclose(contours.motion[k], motion, atol=1e-9)
        np.testing.assert_allclose(
            contours.motion_design[k], (np.eye(MOTION_SIZE) - K @ H) @ P, atol=1e-9
        )
        ahead = predicted + H @ (motion - before.motion[k])
        P = np.repeat(before.node_design[k], 2)
        X = ahead + P / (P + v) * (Z - ahead)
        np.testing.assert_allclose(contours.nodes[k].ravel(), X, atol=1e-9)
        after = P[::2] * (1 - P[::2] / (P[::2] + v))
        np.testing.assert_allclose(contours.node_design[k], after, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(('config', 'frames'), [(JOINT, 1), (JOINT, 30), (TWO, 5), (TWO, 30)])
def test_the_covariance_is_that_of_the_errors_whatever_the_gain(config, frames):
    """Simulated as modeled; the gains of two filters in turn are not the best, but the covariance
    is of their errors all the same."""
    rng, runs = np.random.default_rng(4), 600
    turn = 1.0 if config.rotation else 0.0
    truth = circle(runs) + rng.normal(0, 2, (runs, N, 2))
    spread = np.array([1.0, 1.0, 1e-2, 1e-2 * turn])
    motion = rng.normal(0, 1, (runs, MOTION_SIZE)) * spread
    contours = Contours.new(circle(runs), np.zeros((runs, 2)), config)
    q = np.sqrt([0.05, 0.05, config.scale_noise, config.turn_noise * turn])
    for _ in range(frames):
        truth += (motion_matrix(truth) @ motion[..., None]).reshape(truth.shape)
        truth += rng.normal(0, np.sqrt(0.02), truth.shape)
        motion += rng.normal(0, 1, motion.shape) * q
        contours.predict(1.0, config)
        normals = SPLINE.normals(contours.nodes)
        noise = rng.normal(0, np.sqrt(config.edge_variance), (runs, N))
        offset = ((truth - contours.nodes) * normals).sum(axis=2) + noise
        contours.correct(offset, rng.random((runs, N)) < 0.9, normals, 1.0, config)
    change = SPLINE.centroid(contours.nodes)[1].reshape(runs, 2, 2 * N)
    P = change @ contours.cov[:, : 2 * N, : 2 * N] @ change.swapaxes(1, 2)
    e = SPLINE.centroid(truth)[0] - SPLINE.centroid(contours.nodes)[0]
    nees = (e * np.linalg.solve(P, e[..., None])[..., 0]).sum(axis=1)
    low, high = chdtri(2 * 100, [0.999, 0.001]) / 100
    assert low < nees.mean() < high


def test_edges_of_what_covers_a_part_are_told_from_those_of_the_target():
    nodes, offset = circle(), np.zeros((1, N))
    normals = SPLINE.normals(nodes)
    offset[0, :4] = -2.5  # a cover comes in from the front
    spread = np.full((1, N), 0.3)
    found = np.ones((1, N), bool)
    good = gate(offset, found, spread, normals, nodes, ContourConfig())
    assert good[0].tolist() == [False] * 4 + [True] * 8
    everything = gate(offset, found, spread, normals, nodes, ContourConfig(outlier=0.0))
    assert everything.all()


@pytest.mark.parametrize('motion', [(6, 2, 0, 0), (-5, 5, 0.05, 0), (0, 0, 0.2, 0)])
def test_edges_that_agree_on_another_motion_all_count(motion):
    nodes = circle()
    normals = SPLINE.normals(nodes)
    moved = (motion_matrix(nodes) @ np.array(motion, float)).reshape(1, N, 2)
    offset = (moved * normals).sum(axis=2)
    spread = np.full((1, N), 0.3)
    found = np.ones((1, N), bool)
    found[0, 5] = False
    offset[0, 2] += 9
    good = gate(offset, found, spread, normals, nodes, ContourConfig())
    assert good[0].tolist() == [i not in (2, 5) for i in range(N)]
