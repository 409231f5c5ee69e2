"""How long clicks on a large picture keep everybody waiting."""

import time

import cv2
import pytest
from support.tuner import only
from support.tuner import talk
from support.tuner import tuner

from colortrack_ros.scenes import open_scene

ROOM, FRAME = 'clutter?width=1920&height=1080&duration=2', 30
ROUNDS = 3
"""Of the same clicks: the least times are those with the least else to do."""


@pytest.mark.alone
def test_what_a_thing_is_not_is_learned_in_a_few_times_as_long_as_the_thing(tmp_path):
    scene = open_scene(ROOM)
    ball = scene.truth(FRAME)[0]
    cv2.imwrite(f'{tmp_path}/room.png', scene.render(FRAME))
    places = [(True, round(ball['u']), round(ball['v'])), (False, 50, 50), (False, 1000, 1000)]
    users = {'OPENBLAS_NUM_THREADS': ''}  # as many as it wants to, which tests take from it
    with tuner(f'{tmp_path}/room.png', '--folder', tmp_path, **users) as url:
        took = []
        for _ in range(ROUNDS):
            took.append([wait_for(url, *place) for place in places])
            talk(url, [{'do': 'undo'}] * len(places))
    first, *others = map(min, zip(*took, strict=True))
    print(f'the thing: {first:.2f} s, what is not it:', *(f'{seconds:.2f} s' for seconds in others))
    assert max(others) < 9 * first


def wait_for(url, is_it, u, v):
    """How long somebody who clicks waits until the color is learned [s]."""
    click = {'color': 'ball', 'is_it': is_it, 'u': u, 'v': v, 'width': 1, 'height': 1}
    began = time.monotonic()
    assert only(talk(url, [{'do': 'sample', **click}]), 'set')
    return time.monotonic() - began
