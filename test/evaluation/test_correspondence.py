import numpy as np
import pytest

from colortrack_ros.evaluation import score


def wobbly(seed):
    """Three objects, tracks that swap, vanish and appear from nowhere."""
    rng = np.random.default_rng(seed)
    truth, tracks = [], []
    name = np.array([11, 12, 13])
    for k in range(60):
        here = np.array([[i, 100 * i + 2 * k, 50 + 10 * np.sin(k / 5 + i)] for i in range(3)])
        if rng.random() < 0.1:
            name = rng.permutation(name)
        if rng.random() < 0.05:
            name[rng.integers(3)] = 100 + k
        rows = np.column_stack([name, here[:, 1:] + rng.normal(0, 2, (3, 2))])
        rows = rows[rng.random(3) < 0.8]
        if rng.random() < 0.2:
            rows = np.vstack([rows, [500 + k // 10, *rng.uniform(0, 300, 2)]])
        truth.append(here[rng.random(3) < 0.9])
        tracks.append(rows)
    return truth, tracks


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(5))
def test_the_numbers_are_those_of_motmetrics(seed):
    motmetrics = pytest.importorskip('motmetrics')
    truth, tracks = wobbly(seed)
    accumulator = motmetrics.MOTAccumulator(auto_id=True)
    for a, b in zip(truth, tracks, strict=True):
        d2 = ((a[:, None, 1:] - b[None, :, 1:]) ** 2).sum(-1)
        d2[d2 > 10**2] = np.nan
        accumulator.update(a[:, 0].astype(int), b[:, 0].astype(int), np.sqrt(d2))
    names = ['num_switches', 'idf1', 'mota', 'num_misses', 'num_false_positives']
    names += ['num_fragmentations', 'precision', 'recall']
    expected = motmetrics.metrics.create().compute(accumulator, metrics=names).iloc[0]
    found = score(truth, tracks, 10.0)
    assert [found.switches, found.misses, found.false] == [
        expected[n] for n in ('num_switches', 'num_misses', 'num_false_positives')
    ]
    assert found.fragments == expected['num_fragmentations']
    assert found.precision == pytest.approx(expected['precision'])
    assert found.recall == pytest.approx(expected['recall'])
    assert found.idf1 == pytest.approx(expected['idf1'])
    assert found.mota == pytest.approx(expected['mota'])


def test_a_perfect_track_scores_one_and_a_stray_one_is_named():
    truth = [[(0, k, 0.0)] for k in range(10)]
    good = score(truth, [[(7, k, 3.0)] for k in range(10)], 5.0)
    assert (good.switches, good.idf1, good.mota, good.rmse) == (0, 1.0, 1.0, 3.0)
    assert (good.tracks_of, good.false_tracks) == ({0: [7]}, [])
    stray = score(truth, [[(7, k, 0.0), (8, 900.0, 9.0)] for k in range(10)], 5.0)
    assert stray.false_tracks == [8]
