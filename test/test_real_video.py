"""Three real videos of a ball, tracked with the preset that was chosen from their pictures."""

import numpy as np
import pytest
from support.paths import DATA
from support.pipeline import run

from colortrack_ros.data import TENTATIVE

VIDEOS = DATA / 'ball_toss'
IN_PICTURE = {
    'ball': [(17, 36)],
    'ball2': [(28, 462), (488, 787), (825, 962)],
    'ball4': [(117, 437)],
}
"""First and last frame of each stretch with the ball in the picture and not mostly covered."""


PRESET = {
    'ball': 'ball_toss_thrown.yaml',
    'ball2': 'ball_toss.yaml',
    'ball4': 'ball_toss.yaml',
}


@pytest.mark.slow
@pytest.mark.skipif(not VIDEOS.is_dir(), reason=f'no videos at {VIDEOS}; set COLORTRACK_DATA')
@pytest.mark.parametrize('name', IN_PICTURE)
def test_the_ball_is_found_and_no_two_tracks_live_at_a_time(name):
    confirmed, found = [], []
    for step in run(str(VIDEOS / f'{name}.mp4'), PRESET[name]):
        rows = step.tracks.rows
        confirmed.append(np.count_nonzero(rows['state'] != TENTATIVE))
        found.append(np.any(rows['time_since_update'] == 0))
    assert max(confirmed) == 1
    frames = np.arange(len(found))
    seen = [k for first, last in IN_PICTURE[name] for k in frames[first : last + 1]]
    assert np.mean(np.array(found)[seen]) >= 0.9
