import itertools
import tracemalloc

import numpy as np
import pytest

from colortrack_ros.evaluation.hota import HotaTally
from colortrack_ros.evaluation.hota import SIMILARITIES


def textbook(frames):
    """HOTA, DetA and AssA as Luiten et al. (2021) write them, one level and one match at a time."""
    lives, names, pairs = {}, {}, {}
    for ids, tracks, similarity in frames:
        for i in ids:
            lives[i] = lives.get(i, 0) + 1
        for j in tracks:
            names[j] = names.get(j, 0) + 1
        for a, i in enumerate(ids):
            for b, j in enumerate(tracks):
                union = similarity[a].sum() + similarity[:, b].sum() - similarity[a, b]
                pairs[i, j] = pairs.get((i, j), 0) + similarity[a, b] / max(union, 1e-16)
    aligned = {(i, j): s / (lives[i] + names[j] - s) for (i, j), s in pairs.items()}
    results = []
    for level in SIMILARITIES:
        hits, matches = 0, {}
        for ids, tracks, similarity in frames:
            for a, b in best(ids, tracks, similarity, aligned):
                if similarity[a, b] >= level - 1e-15:
                    hits += 1
                    key = ids[a], tracks[b]
                    matches[key] = matches.get(key, 0) + 1
        deta = hits / (sum(lives.values()) + sum(names.values()) - hits)
        assa = sum(n * n / (lives[i] + names[j] - n) for (i, j), n in matches.items())
        assa /= max(hits, 1)
        results.append([np.sqrt(deta * assa), deta, assa])
    return np.mean(results, axis=0)


def best(ids, tracks, similarity, aligned):
    """The assignment of all with the greatest sum, by trying each."""
    if len(ids) > len(tracks):
        turned = {key[::-1]: value for key, value in aligned.items()}
        return [(a, b) for b, a in best(tracks, ids, similarity.T, turned)]
    value = np.array([[aligned[i, j] for j in tracks] for i in ids]).reshape(similarity.shape)
    value = value * similarity
    choices = itertools.permutations(range(len(tracks)), len(ids))
    return list(enumerate(max(choices, key=lambda c: sum(value[a, b] for a, b in enumerate(c)))))


@pytest.mark.parametrize('seed', range(6))
def test_the_numbers_are_those_of_the_textbook(seed):
    rng = np.random.default_rng(seed)
    frames = []
    for _ in range(30):
        ids = rng.choice(4, rng.integers(0, 5), replace=False)
        names = rng.choice(5, rng.integers(0, 5), replace=False) + 10
        similarity = rng.uniform(0, 0.4, (len(ids), len(names)))
        similarity[ids[:, None] + 10 == names] += 0.5
        frames.append((ids, names, similarity))
    tally = HotaTally()
    for frame in frames:
        tally.add(*frame)
    assert tally.score()[:3] == pytest.approx(textbook(frames))


def test_nothing_found_is_zero_and_no_division_by_it():
    tally = HotaTally()
    assert tally.score() == (0, 0, 0, 0)
    tally.add(np.array([1]), np.zeros(0, int), np.zeros((1, 0)))
    assert tally.score() == (0, 0, 0, 0)
    tally.add(np.zeros(0, int), np.array([7]), np.zeros((0, 1)))
    assert tally.score()[:3] == (0, 0, 0)


def test_many_short_tracks_take_little_memory():
    """As of a night: a table of all pairs for each threshold would have been 0.5 GB here."""
    tally = HotaTally()
    for k in range(4000):
        tally.add(np.array([k // 5]), np.array([k]), np.array([[0.7]]))
    tracemalloc.start()
    score = tally.score()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert score.deta == pytest.approx(14 / 19)
    assert score.assa == pytest.approx(14 / 19 / 5)
    assert peak < 50e6
