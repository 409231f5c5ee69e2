"""The same input gives the same bytes, wherever its arrays lie in memory.

NumPy 1.26 (Ubuntu 24.04) has two kernels with different last bits for exp, log, arctan2 and others.
It takes the slower one when the result may overlap the argument, and counts as the argument's end
one stride past its last element: for a column of a table the allocator decides.
"""

from collections.abc import Iterator
import functools

import numpy as np
import pytest
from support.pipeline import run

from colortrack_ros.messages import MarkerWriter
from colortrack_ros.world import CameraModel
from colortrack_ros.world.directions import pixels_of

FUNCTIONS = ('arctan2', 'arctan', 'arccos', 'exp', 'expm1', 'log', 'log1p', 'log2', 'cbrt', 'power')


@pytest.fixture(autouse=True)
def only_whole_arrays(monkeypatch) -> Iterator[dict[str, int]]:
    """Refuse strided arguments; how often each function was called."""
    calls = dict.fromkeys(FUNCTIONS, 0)

    def guard(function):
        @functools.wraps(function, updated=())
        def guarded(*arrays, **options):
            calls[function.__name__] += 1
            for array in map(np.asarray, arrays):
                assert array.flags.forc or not array.ndim, f'{function.__name__} of {array.strides}'
            return function(*arrays, **options)

        return guarded

    for name in FUNCTIONS:
        monkeypatch.setattr(np, name, guard(getattr(np, name)))
    return calls


@pytest.mark.slow
def test_of_markers_and_all_that_leads_to_them(only_whole_arrays):
    markers = MarkerWriter()
    for step in run('scene:clutter?width=320&height=240&duration=3'):
        markers.write(step.tracks, 0.001)
    assert min(only_whole_arrays[name] for name in ('arctan2', 'exp', 'log')) > 0


@pytest.mark.parametrize('model', [('plumb_bob', 5), ('equidistant', 4)])
def test_of_directions_in_space(only_whole_arrays, model):
    name, coefficients = model
    K = (400, 0, 320, 0, 400, 240, 0, 0, 1)
    camera = CameraModel.of(640, 480, K, (0.02,) * coefficients, name)
    rays = np.array([[0.0, 0, 1], [0.6, 0, 0.8], [0, 0.8, -0.6], [1, 0, 0]])
    pixels_of(camera, rays)
    assert only_whole_arrays['arctan2']
