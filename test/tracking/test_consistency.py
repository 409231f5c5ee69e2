"""Monte Carlo: with a matched model, errors are as large as the covariances say.

Bar-Shalom, Li and Kirubarajan 2001, 5.4: the normalized squared error of a consistent filter,
averaged over runs, is chi-square distributed. Each run is a track of a single bank.
"""

import numpy as np
import pytest
from scipy.special import chdtri

from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.motion import MOTION_MODELS

RUNS, BATCH, DT, SIGMA_S, SIGMA_W, SPEED = 1000, 200, 1 / 24, 300.0, 1.5, 200.0
GRAVITY = (30.0, 900.0)


class Simulation:
    """Truth and filter bank of RUNS objects with one motion model."""

    def __init__(self, name, seed):
        self.rng = np.random.default_rng(seed)
        self.model = MOTION_MODELS[name](GRAVITY)
        self.spread = np.repeat([0.0, SPEED, SIGMA_S], 2)[: self.model.size]
        self.x = self.rng.normal(0, 1, (RUNS, self.model.size)) * self.spread
        self.x[:, :2] += self.rng.uniform(0, 1000, (RUNS, 2))
        stay = self.model.switching(1e3)[0]
        self.mode = self.rng.choice(self.model.modes, RUNS, p=stay)
        self.R = np.broadcast_to(SIGMA_W**2 * np.eye(2), (RUNS, 2, 2))
        self.bank = Bank(self.model)
        self.bank.extend(self.bank.at_rest(self.measure(), self.R, self.spread))

    def measure(self):
        return self.x[:, :2] + self.rng.normal(0, SIGMA_W, (RUNS, 2))

    def step(self, measured=True):
        """Move, predict, and correct; return the normalized innovations squared (NIS)."""
        switch = np.cumsum(self.model.switching(DT)[self.mode], axis=1)
        if not self.model.selected:
            self.mode = (self.rng.random((RUNS, 1)) > switch).sum(axis=1)
        F, Q = self.model.transition(DT)[self.mode], self.model.noise(DT)[self.mode]
        values, vectors = np.linalg.eigh(SIGMA_S**2 * Q)
        noise = vectors * np.sqrt(np.maximum(values, 0))[:, None]
        self.x = (F @ self.x[..., None])[..., 0] + self.model.drift(DT)
        self.x += (noise @ self.rng.normal(0, 1, (RUNS, self.model.size, 1)))[..., 0]
        self.bank.predict(DT, SIGMA_S**2)
        if not measured:
            self.bank.correct(np.zeros(0, int), np.zeros((0, 2)), np.zeros((0, 2, 2)))
            return None
        z, track = self.measure(), np.arange(RUNS)
        mean, cov = self.bank.estimate()
        nis = squared(z - mean[:, :2], cov[:, :2, :2] + self.R)
        self.bank.correct(track, z, self.R)
        return nis

    def nees(self):
        mean, cov = self.bank.estimate()
        return squared(self.x[:, :4] - mean[:, :4], cov[:, :4, :4])


def squared(e, S):
    return (e * np.linalg.solve(S, e[..., None])[..., 0]).sum(axis=1)


def within(values, freedom):
    """Return whether the average over all runs is within the 95 % interval of BATCH runs.

    The average of a correct filter over BATCH runs would be outside in one test of twenty.
    """
    low, high = chdtri(BATCH * freedom, [0.975, 0.025]) / BATCH
    return low < values.mean() < high


@pytest.mark.slow
@pytest.mark.parametrize('name', MOTION_MODELS)
@pytest.mark.parametrize('frames', [1, 2, 40])
def test_nees_after_so_many_frames(name, frames):
    simulation = Simulation(name, 1)
    for _ in range(frames):
        nis = simulation.step()
    assert within(simulation.nees(), 4)
    assert within(nis, 2)


@pytest.mark.slow
@pytest.mark.parametrize('name', MOTION_MODELS)
@pytest.mark.parametrize('coasting', [1, 5, 20])
def test_nees_after_coasting(name, coasting):
    simulation = Simulation(name, 2)
    for _ in range(30):
        simulation.step()
    for _ in range(coasting):
        simulation.step(measured=False)
    assert within(simulation.nees(), 4)


@pytest.mark.slow
@pytest.mark.parametrize('name', MOTION_MODELS)
def test_covariances_stay_symmetric_and_positive(name):
    """A filter makes 100,000 steps of 1 ms to 10 s, every third without a measurement."""
    rng = np.random.default_rng(0)
    bank, steps, tracks = Bank(MOTION_MODELS[name](GRAVITY)), 1000, 100
    R = np.broadcast_to(0.003 * np.eye(2), (tracks, 2, 2))
    spread = np.repeat([0.0, SPEED, SIGMA_S], 2)[: bank.model.size]
    bank.extend(bank.at_rest(np.zeros((tracks, 2)), R, spread))
    for _ in range(steps):
        bank.predict(10 ** rng.uniform(-3, 1), SIGMA_S**2)
        hit = np.flatnonzero(rng.random(tracks) < 2 / 3)
        z = bank.estimate()[0][hit, :2] + rng.normal(0, 1, (len(hit), 2))
        bank.correct(hit, z, R[hit])
        assert np.abs(bank.cov - bank.cov.swapaxes(-1, -2)).max() <= 1e-9 * np.abs(bank.cov).max()
        scale = np.sqrt(np.diagonal(bank.cov, axis1=-2, axis2=-1))
        correlation = bank.cov / scale[..., None] / scale[..., None, :]
        assert np.linalg.eigvalsh(correlation).min() > 0
