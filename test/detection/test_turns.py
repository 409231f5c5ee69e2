"""Sought colors take turns: no picture waits until all of them are updated."""

import numpy as np
import pytest
from support.lit_balls import draw_lit_ball
from support.lit_balls import hues
from support.lit_balls import wheel
from support.sought import sought

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import named_color
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection import sought_color
from colortrack_ros.detection.sought_color import SoughtColor

SHOWN = (
    (200, 40, 40), (230, 125, 35), (230, 200, 50), (50, 150, 60), (40, 180, 190), (30, 70, 170),
    (190, 45, 150),
)  # fmt: skip
"""A ball of each of seven names."""


def eight_balls():
    """Noisy pictures of the balls of a wheel, and a detector of the colors of their middles."""
    image, places = wheel(hues(8).round(), 0.6)
    noisy = image + np.random.default_rng(0).normal(0, 3, (4, *image.shape))
    pictures = noisy.clip(0, 255).astype(np.uint8)
    return pictures, sought(*(tuple(image[v, u][::-1].tolist()) for u, v in places))


@pytest.mark.slow
def test_of_many_colors_one_is_updated_in_each_picture(monkeypatch):
    """All eight were, in one picture of eight, which took fifty times as long as the others."""
    renew, find, calls = SoughtColor.renew, sought_color.find_extent, {'extents': 0, 'colors': []}

    def counted_find(*given, **more):
        calls['extents'] += 1
        return find(*given, **more)

    def counted_renew(self, *given):
        calls['colors'].append(self.color.name)
        return renew(self, *given)

    monkeypatch.setattr(sought_color, 'find_extent', counted_find)
    monkeypatch.setattr(SoughtColor, 'renew', counted_renew)
    pictures, detector = eight_balls()
    renewed = []
    for k in range(60):
        calls |= {'extents': 0, 'colors': []}
        frame = Frame(pictures[k % 4], stamp=k * NANOSECONDS // 30)
        assert len(detector.detect(frame).rows) == 8
        assert k == 0 or (calls['extents'] <= 3 and len(calls['colors']) <= 1)
        renewed.append(calls['colors'])
    for k in range(8, 52):
        assert len({name for names in renewed[k : k + 8] for name in names}) == 8, 'within 0.27 s'


@pytest.mark.slow
@pytest.mark.parametrize(('hertz', 'most'), [(60, 1), (15, 2), (8, 4), (4, 8), (1, 8)])
def test_each_color_is_updated_as_often_however_few_pictures_come(hertz, most, monkeypatch):
    renewed = []
    monkeypatch.setattr(SoughtColor, 'renew', lambda self, *_: renewed.append(self.color.name))
    pictures, detector = eight_balls()
    numbers = []
    for k in range(2 * hertz + 1):
        renewed.clear()
        detector.detect(Frame(pictures[k % 4], stamp=k * NANOSECONDS // hertz))
        numbers.append(len(renewed))
    assert max(numbers) == most
    assert sum(numbers) >= min(8 * 6, 8 * 2 * hertz)


@pytest.mark.slow
@pytest.mark.parametrize('turn', [1, -1])
def test_a_thing_that_comes_between_two_turns_is_of_the_name_that_fits_it_best(turn):
    """Else it is, for good, of the name whose turn it is when it comes."""
    names = ('red', 'orange', 'green', 'blue')[::turn]
    wall = np.full((120, 200, 3), (190, 190, 180), np.float64)
    ball = wall.copy()
    draw_lit_ball(ball, 100, 60, 30, (225, 80, 35))
    noise = np.random.default_rng(0).normal(0, 3, wall.shape)
    wall, ball = ((image + noise).clip(0, 255).astype(np.uint8) for image in (wall, ball))
    colors = tuple(ReferenceColor.from_preset(name, name) for name in names)
    for first in range(8, 16):
        detector = Detector(DetectorConfig(colors=colors))
        for k in range(first + 8):
            image = wall if k < first else ball
            rows = detector.detect(Frame(image, stamp=k * NANOSECONDS // 30)).rows
        assert [names[color] for color in rows['color']] == ['red']


@pytest.mark.slow
def test_a_name_is_chosen_anew_only_where_another_has_come_between(monkeypatch):
    """Each was for every one that was found: 28 times, up to six searches each, with seven."""
    chosen, choose = [], named_color.choose

    def counted(*given, **more):
        chosen.append(given[2].name)
        return choose(*given, **more)

    monkeypatch.setattr(named_color, 'choose', counted)
    names = ('red', 'orange', 'yellow', 'green', 'cyan', 'blue', 'magenta')
    colors = tuple(ReferenceColor.from_preset(name, name) for name in names)
    detector = Detector(DetectorConfig(colors=colors))
    detector.detect(Frame(wheel(SHOWN, 0.6)[0]))
    assert set(chosen) == set(names)
    assert len(chosen) <= len(names) + 3
