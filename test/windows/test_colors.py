"""Which colors are a target's."""

import numpy as np
import pytest

from colortrack_ros.windows.colors import COLOR_RATE
from colortrack_ros.windows.colors import Colors
from colortrack_ros.windows.colors import INNER
from colortrack_ros.windows.colors import LEVELS
from colortrack_ros.windows.colors import OUTER

SHAPE, TARGET = (40, 32), np.array([16.0, 20.0])


def patch_of(seed, channels):
    """Of few colors: other ones in the middle than around it, but not always."""
    rng = np.random.default_rng(seed)
    patch = rng.integers(40, 70, (*SHAPE, *channels), dtype=np.uint8)
    patch[8:30, 6:24] += rng.integers(0, 20, (22, 18, *channels), dtype=np.uint8)
    return patch


def share(patch, color, where):
    alike = patch // (256 // LEVELS) == color
    return (alike.all(axis=2) if patch.ndim == 3 else alike)[where].mean()


@pytest.mark.parametrize('channels', [(), (3,)])
def test_a_color_is_as_likely_as_its_shares_inside_and_outside_say(channels):
    patches = [patch_of(seed, channels) for seed in range(4)]
    colors = Colors(patches[0], TARGET)
    for patch in patches[1:]:
        colors.learn(patch)
    v, u = (np.abs(np.arange(n) - (n - 1) / 2) for n in SHAPE)
    outward = 2 * np.maximum(v[:, None] / TARGET[1], u / TARGET[0])
    found = colors.likelihood(patches[-1])
    for place in [(3, 3), (20, 16), (12, 8), (28, 22)]:
        color = patches[-1][place] // (256 // LEVELS)
        pair = np.array(
            [[share(p, color, w) for w in (outward <= INNER, outward > OUTER)] for p in patches]
        )
        kept = pair[0]
        for new in pair[1:]:
            kept = kept + COLOR_RATE * (new - kept)
        assert found[place] == pytest.approx(kept[0] / kept.sum(), rel=1e-6)


@pytest.mark.parametrize('channels', [(), (3,)])
def test_a_color_that_was_never_seen_says_nothing(channels):
    colors = Colors(patch_of(0, channels), TARGET)
    assert (colors.likelihood(np.full((*SHAPE, *channels), 255, np.uint8)) == 0.5).all()
