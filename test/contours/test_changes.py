import numpy as np
import pytest
from support.contour_pictures import EMPTY
from support.contour_pictures import follow
from support.contour_pictures import known
from support.contour_pictures import picture
from support.contour_pictures import QUICK
from support.contour_pictures import straight
from support.contour_pictures import texture

from colortrack_ros.contours.areas import find_areas
from colortrack_ros.contours.changes import has_changed
from colortrack_ros.contours.changes import remember
from colortrack_ros.contours.records import CONTOUR_FIELDS

WALL = texture(3)


def remembered(image, *boxes):
    mask = np.zeros(image.shape[:2], np.uint8)
    for left, top, right, bottom in boxes:
        mask[top : bottom + 1, left : right + 1] = 255
    areas = find_areas(mask, 16, np.array(boxes, float))
    records = np.zeros(len(areas), CONTOUR_FIELDS)
    remember(records, areas, image)
    return records


@pytest.mark.parametrize('channels', [1, 3])
def test_what_leaves_its_place_changes_it_and_what_stands_does_not(channels):
    image = np.full((120, 200, channels), 200, np.uint8)
    before, after = image.copy(), image.copy()
    before[20:60, 20:50] = before[20:60, 100:130] = 90
    after[20:60, 28:58] = after[20:60, 100:130] = 90
    records = remembered(before, (20, 20, 49, 59), (100, 20, 129, 59))
    assert not has_changed(records, before).any()
    assert has_changed(records, after).tolist() == [True, False]
    records['told'] = True
    assert has_changed(records, before).all()


def test_a_smaller_picture_an_empty_one_and_areas_of_a_few_pixels_do_no_harm():
    image = np.full((120, 200, 1), 200, np.uint8)
    records = remembered(image, (150, 80, 155, 85))
    assert not has_changed(records, image[:40, :60]).any()
    assert not has_changed(records, image[:0]).any()


def ghost(k):
    """Something stands there at once, of which the background soon takes in the paler half."""
    gray = WALL.copy()
    if k >= EMPTY:
        gray[100:135, 100:150] -= 23
        gray[100:135, 150:180] -= 90
    return picture('person', None, 0, background=gray, seed=k)


@pytest.mark.slow
def test_what_the_background_takes_in_bit_by_bit_has_not_moved():
    assert not any(known(tracks).any() for tracks in follow(map(ghost, range(110)), QUICK))


@pytest.mark.slow
def test_what_moves_on_before_a_textured_wall_is_confirmed_as_before():
    pictures = (
        picture('person', *straight(k, radius=30.0), background=WALL, seed=k) for k in range(40)
    )
    assert any(known(tracks).any() for tracks in follow(pictures, QUICK))
