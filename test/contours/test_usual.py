import numpy as np
import pytest
from support.contour_pictures import EMPTY
from support.contour_pictures import follow
from support.contour_pictures import frame
from support.contour_pictures import known
from support.contour_pictures import noise
from support.contour_pictures import QUICK
from support.contour_pictures import SHAPES

from colortrack_ros.contours import ContourTracker
from colortrack_ros.contours.usual import UsualArea
from colortrack_ros.scenes.silhouettes import draw_polygon
from colortrack_ros.scenes.silhouettes import placed

SIZE = (240, 320)
LARGE, SMALL = [100.0, 50, 139, 149], [100.0, 50, 109, 59]  # 4000 and 100 px^2
FAR_AWAY = [257.0, 209, 266, 218]


def learned(*seen):
    """What is usual after boxes, each for so many seconds."""
    usual = UsualArea()
    for box, seconds in seen:
        for _ in range(round(10 * seconds)):
            usual.learn(np.array([box]), SIZE, 0.1)
    return usual


def at(usual, box):
    return usual.at(np.array([box]))[0]


def test_nothing_is_usual_before_anything_was_seen():
    usual = UsualArea()
    assert usual.at(np.zeros((0, 4))).tolist() == []
    assert at(usual, SMALL) == 0
    usual.learn(np.zeros((0, 4)), SIZE, 0.1)
    assert at(usual, SMALL) == 0


def test_what_was_seen_anywhere_is_usual_where_nothing_was():
    assert at(learned((LARGE, 1.0)), FAR_AWAY) == pytest.approx(4000)
    assert at(learned((LARGE, 1.0)), LARGE) == pytest.approx(4000)


def test_more_of_what_is_large_is_usual_than_of_its_parts():
    assert at(learned((LARGE, 1.0), (SMALL, 1.0)), FAR_AWAY) > 2000


def test_what_is_small_is_usual_where_it_is_often():
    seen = [learned((LARGE, 5.0), (FAR_AWAY, seconds)) for seconds in (0.0, 3.0, 30.0)]
    values = [at(usual, FAR_AWAY) for usual in seen]
    assert values[0] == pytest.approx(4000)
    assert 500 < values[1] < 700  # halfway, by ratio
    assert values[2] < 150
    assert all(at(usual, LARGE) > 2000 for usual in seen)


def test_what_was_usual_is_forgotten_in_minutes():
    usual = learned((LARGE, 5.0), (FAR_AWAY, 300.0))
    assert at(usual, LARGE) < 300


def test_boxes_beyond_the_border_belong_to_its_places():
    usual = learned(([-50.0, -50, 9, 9], 9.0))
    assert at(usual, [-90.0, -90, -10, -10]) == pytest.approx(3600)
    assert at(usual, [400.0, 300, 500, 400]) == pytest.approx(3600)


def test_pictures_of_another_size_begin_anew():
    usual = learned((LARGE, 5.0))
    usual.learn(np.array([SMALL]), (480, 640), 0.1)
    assert at(usual, LARGE) == pytest.approx(100)


def scene(k, small, person=True):
    """Somebody walks to and fro, and from picture 60 on something small is there, too."""
    image = np.full((*SIZE, 3), 215, np.uint8)
    if person and k >= EMPTY:
        place = (160 + 100 * np.sin((k - EMPTY) / 30), 90.0)
        draw_polygon(image, placed(SHAPES['person'], np.array(place), 40.0, 0.0), (45, 45, 45))
    if k >= 60:
        place = np.array(small(k - 60), float)
        draw_polygon(image, placed(SHAPES['quadrilateral'], place, 10.0, 0.0), (45, 45, 45))
    return np.clip(image[..., 0] + noise(k, SIZE), 0, 255).astype(np.uint8)


def to_and_fro(k):
    return 60 + 12 * np.sin(k / 6), 215


def away(k):
    return 20 + 3.0 * k, 215


@pytest.mark.slow
@pytest.mark.parametrize(
    ('small', 'person', 'within'),
    [(to_and_fro, False, (10, 24)), (to_and_fro, True, (48, 90)), (away, True, (45, 60))],
)
def test_what_is_much_smaller_than_usual_is_told_when_it_has_gone_far_or_stays(
    small, person, within
):
    results = follow([scene(k, small, person) for k in range(150)], QUICK)
    counts = [np.count_nonzero(known(tracks)) for tracks in results]
    assert max(counts[:60]) == person
    assert within[0] < counts.index(person + 1) - 60 < within[1]


@pytest.mark.slow
def test_what_somebody_named_is_told_whatever_its_size():
    tracker, results = ContourTracker(QUICK), []
    for k in range(90):
        if k == 64:
            tracker.start([[57, 205, 20, 20]])
        results.append(tracker.update(frame(scene(k, to_and_fro), k)))
    assert [np.count_nonzero(known(tracks)) for tracks in results[65:]] == [2] * 25
