"""The bank's moments against the textbook's, written out plainly."""

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest

from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.motion.constant_acceleration import ConstantAcceleration
from colortrack_ros.estimation.motion.constant_velocity import ConstantVelocity
from colortrack_ros.estimation.motion.constant_velocity import REFERENCE_PERIOD
from colortrack_ros.estimation.motion.imm import InteractingModels
from colortrack_ros.estimation.motion.imm import ROUGH
from colortrack_ros.estimation.motion.imm import SMOOTH

SPREAD = np.array([0.0, 0.0, 40.0, 30.0, 200.0, 300.0])
STEPS = st.floats(1e-3, 2.0)


def bank_of(model, tracks=3):
    """Tracks that have moved for a while, all entries of their covariances in use."""
    random = np.random.default_rng(4)
    z, A = random.normal(0, 50, (tracks, 2)), random.normal(size=(tracks, 2, 2))
    bank = Bank(model)
    bank.extend(bank.at_rest(z, A @ A.swapaxes(1, 2) + np.eye(2), SPREAD[: model.size]))
    for _ in range(3):
        bank.predict(0.1, 400.0)
        z = z + random.normal(0, 5, z.shape)
        bank.correct(np.arange(tracks), z, np.broadcast_to(np.diag([2.0, 3.0]), (tracks, 2, 2)))
    bank.predict(0.1, 400.0)
    return bank


@pytest.mark.slow
@pytest.mark.parametrize(
    ('model', 'driven', 'scale'),
    [(ConstantVelocity(), 1, REFERENCE_PERIOD), (ConstantAcceleration(), 2, 1.0)],
    ids=['white acceleration', 'white jerk'],
)
@given(dt=STEPS)
def test_process_noise_is_the_integral_of_white_noise_over_the_step(model, driven, scale, dt):
    nodes, weights = np.polynomial.legendre.leggauss(6)
    expected = np.zeros((model.size, model.size))
    for age, weight in zip(dt * (nodes + 1) / 2, dt * weights / 2, strict=True):
        gain = model.transition(age)[0][:, 2 * driven : 2 * driven + 2]
        expected += weight * scale * gain @ gain.T
    np.testing.assert_allclose(model.noise(dt)[0], expected, rtol=1e-9, atol=1e-12)


@given(first=STEPS, second=STEPS)
def test_modes_switch_as_a_markov_process_in_continuous_time_does(first, second):
    switching = InteractingModels().switching
    np.testing.assert_allclose(switching(first).sum(axis=1), 1)
    np.testing.assert_allclose(switching(first) @ switching(second), switching(first + second))
    rates = (switching(1e-7) - np.eye(2)) / 1e-7
    np.testing.assert_allclose(1 / -np.diag(rates), [SMOOTH, ROUGH], rtol=1e-5)


def test_a_change_of_velocity_at_any_time_alike_has_the_moments_of_many_such_changes():
    bank, T, variance = bank_of(ConstantVelocity()), 0.4, 900.0
    before = bank.cov.copy()
    bank.add_turn(np.array([1]), np.array([T]), np.array([variance]))
    age = T * (np.arange(2000) + 0.5) / 2000
    per_axis = variance * np.array([[(age**2).mean(), age.mean()], [age.mean(), 1.0]])
    np.testing.assert_allclose(bank.cov[0, 1] - before[0, 1], np.kron(per_axis, np.eye(2)), 1e-6)
    np.testing.assert_array_equal(bank.cov[0, [0, 2]], before[0, [0, 2]])


def test_a_forgotten_velocity_is_zero_and_independent_of_the_position():
    bank = bank_of(ConstantVelocity())
    place, doubt = bank.mean[..., :2].copy(), bank.cov[..., :2, :2].copy()
    bank.forget_velocity(70.0)
    np.testing.assert_array_equal(bank.mean, np.concatenate([place, 0 * place], axis=-1))
    expected = np.zeros_like(bank.cov)
    expected[..., :2, :2], expected[..., 2:, 2:] = doubt, 4900 * np.eye(2)
    np.testing.assert_array_equal(bank.cov, expected)


def mixture(weights, means, covariances):
    """Mean and covariance of a mixture of normal distributions."""
    mean = sum(w * m for w, m in zip(weights, means, strict=True))
    cov = sum(
        w * (P + np.outer(m - mean, m - mean))
        for w, m, P in zip(weights, means, covariances, strict=True)
    )
    return mean, cov


@pytest.mark.parametrize('model', [ConstantVelocity(), InteractingModels()], ids=['one', 'modes'])
def test_several_doubtful_measurements_give_the_mixture_of_what_each_would_make(model):
    bank = bank_of(model)
    z = bank.estimate()[0][1, :2] + [[3.0, -2.0], [-5.0, 4.0]]
    R, beta, none = np.diag([2.0, 4.0]), [0.5, 0.3], 0.2
    weight, means, covariances = (v[:, 1].copy() for v in (bank.weight, bank.mean, bank.cov))
    H = np.eye(2, model.size)
    hypotheses = {m: [(none * weight[m], means[m], covariances[m])] for m in range(model.modes)}
    for b, measured in zip(beta, z, strict=True):
        likelihood, posterior = [], []
        for mode in range(model.modes):
            x, P = means[mode], covariances[mode]
            S, e = H @ P @ H.T + R, measured - H @ x
            K = P @ H.T @ np.linalg.inv(S)
            rest = np.eye(model.size) - K @ H
            density = np.exp(-e @ np.linalg.solve(S, e) / 2) / np.sqrt(np.linalg.det(S))
            likelihood.append(weight[mode] * density)
            posterior.append((x + K @ e, rest @ P @ rest.T + K @ R @ K.T))
        for mode in range(model.modes):
            share = b * likelihood[mode] / sum(likelihood)
            hypotheses[mode].append((share, *posterior[mode]))
    bank.correct(np.array([1, 1]), z, np.stack([R, R]), np.array(beta))
    for mode in range(model.modes):
        shares, *moments = zip(*hypotheses[mode], strict=True)
        mean, cov = mixture(np.array(shares) / sum(shares), *moments)
        np.testing.assert_allclose(bank.weight[mode, 1], sum(shares), rtol=1e-9)
        np.testing.assert_allclose(bank.mean[mode, 1], mean, rtol=1e-9)
        np.testing.assert_allclose(bank.cov[mode, 1], cov, rtol=1e-7, atol=1e-9)
