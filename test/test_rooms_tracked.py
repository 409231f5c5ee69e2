"""Thrown balls in a room full of their colors, detected and tracked with the preset for it."""

import numpy as np
import pytest
from support.pipeline import run

from colortrack_ros.data import TENTATIVE
from colortrack_ros.evaluation import Tally
from colortrack_ros.scenes import open_scene

SEEN = 0.25
"""An object of which no such part is visible is hidden: no track can be asked for."""

FALSE = 1.5
"""Radii away from every ball of its color from which on a blob is a false one."""


@pytest.mark.slow
@pytest.mark.parametrize(
    'spec', ['clutter?duration=10', 'clutter?seed=7&noise=5&rate=30&duration=8']
)
def test_balls_are_found_and_tracked_in_a_room_full_of_their_colors(spec):
    scene = open_scene(spec)
    tally, sought, found, false = Tally(max_distance=20.0), 0, 0, 0
    for k, step in enumerate(run(f'scene:{spec}', 'clutter.yaml')):
        truth, blobs, tracks = scene.truth(k), step.detections.rows, step.tracks.rows
        away = np.hypot(*(truth[name][:, None] - blobs[name] for name in 'uv'))
        away = away / truth['radius'][:, None]
        away[truth['color'][:, None] != blobs['color']] = np.inf
        sought += np.count_nonzero(truth['visible'] >= 0.5)
        found += np.count_nonzero(away[truth['visible'] >= 0.5].min(axis=1, initial=np.inf) < 1)
        false += np.count_nonzero(away.min(axis=0, initial=np.inf) > FALSE)
        seen = truth[truth['visible'] >= SEEN]
        live = tracks[tracks['state'] != TENTATIVE]
        tally.add(
            np.stack([seen['id'], seen['u'], seen['v']], axis=1),
            np.stack([live['track_id'], live['u'], live['v']], axis=1),
            hidden=len(truth) - len(seen),
        )
    score = tally.score()
    assert found / sought >= 0.95
    assert false / len(scene) <= 0.2
    assert score.idf1 >= 0.95
    assert score.switches == 0
