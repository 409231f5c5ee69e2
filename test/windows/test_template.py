import cv2
import numpy as np
import pytest
from support.window_pictures import frame
from support.window_pictures import texture

from colortrack_ros.windows.crop import Crop
from colortrack_ros.windows.template import PROVEN_MATCHES
from colortrack_ros.windows.template import Template

CENTER = np.array([80.0, 60.0])


def changed(picture, angle=0.0, scale=1.0, shift=(0.0, 0.0)):
    """The picture turned and scaled about CENTER, and moved."""
    matrix = cv2.getRotationMatrix2D(tuple(CENTER), angle, scale)
    matrix[:, 2] += shift
    size = picture.shape[::-1]
    return Crop(cv2.warpAffine(picture, matrix, size, flags=cv2.INTER_CUBIC), np.zeros(2, int))


@pytest.mark.parametrize(('angle', 'scale'), [(0, 1), (4, 1), (-4, 1), (0, 1.06), (0, 0.94)])
def test_turns_and_changes_of_size_are_told_from_motion(angle, scale):
    plain, aligned = [], []
    for seed in range(8):
        picture = texture(seed, cell=4.0)
        template = Template(changed(picture).window(CENTER, (41, 41)))
        crop = changed(picture, angle, scale, (0.4, -0.3))
        place, similarity, correlation = template.align(crop, CENTER)
        aligned.append(np.linalg.norm(place - CENTER - [0.4, -0.3]))
        assert similarity > 0.98
        assert similarity >= correlation - 1e-6
        region = crop.gray[35:86, 55:106]
        plain.append(cv2.minMaxLoc(cv2.matchTemplate(region, template.picture, 0))[2])
    assert np.mean(aligned) < 0.1


def test_light_changes_nothing():
    picture = texture(9)
    template = Template(changed(picture).window(CENTER, (31, 31)))
    crop = changed(picture * 0.7 + 20, shift=(0.3, 0.2))
    place, similarity, _ = template.align(crop, CENTER)
    np.testing.assert_allclose(place - CENTER, [0.3, 0.2], atol=0.05)
    assert similarity > 0.99


def test_a_cover_lowers_the_similarity_and_the_opposite_has_none():
    picture = texture(10)
    template = Template(changed(picture).window(CENTER, (31, 31)))
    covered = picture.copy()
    covered[60:] = 90
    assert template.align(Crop(covered, np.zeros(2, int)), CENTER)[1] < 0.9
    _, similarity, correlation = template.align(Crop(255 - picture, np.zeros(2, int)), CENTER)
    assert similarity == 0.0
    assert correlation < -0.9


@pytest.mark.parametrize('plain', [0.0, 100.0])
def test_what_has_no_texture_is_like_nothing(plain):
    flat = np.full((120, 160), plain, np.float32)
    template = Template(np.full((31, 31), plain, np.float32))
    for picture in (flat, texture(11)):
        place, similarity, correlation = template.align(Crop(picture, np.zeros(2, int)), CENTER)
        assert np.isfinite(place).all()
        assert (similarity, correlation) == (0.0, 0.0)


def test_a_template_wears_out_by_a_turn_at_once_and_by_another_look_after_a_while():
    template = Template(texture(12, 15, 15))
    assert not template.record_match(0.99, 0.99, 0.03)
    assert not template.record_match(0.99, 0.97, 0.03)
    assert template.record_match(0.98, 0.95, 0.03)
    assert [template.record_match(0.94, 0.94, 0.03) for _ in range(3)] == [False, True, True]
    template = Template(texture(12, 15, 15))
    worn = [template.record_match(s, s, 0.03) for s in (0.99, 0.95, 0.94, 0.99, 0.95, 0.95, 0.95)]
    assert worn == [False, False, False, False, False, False, True]


def test_a_template_remembers_the_last_one_that_has_proved_itself():
    proved = Template(texture(13, 15, 15))
    for _ in range(PROVEN_MATCHES):
        proved.record_match(0.99, 0.99, 0.03)
    brief = Template(texture(14, 15, 15), proved)
    latest = Template(texture(15, 15, 15), brief)
    assert brief.former is proved
    assert latest.former is proved
    assert Template(texture(16, 15, 15)).former is None


def test_a_large_window_is_aligned_from_as_many_of_its_own_pixels_away():
    center, picture = np.array([320.0, 240.0]), texture(12, 480, 640, cell=9.0)
    template = Template.of(frame(picture), center, 261, 201)
    assert template.times == 3
    crop = Crop.of(frame(picture), np.array([100, 60]), np.array([540, 420]), 3)
    place, similarity, _ = template.align(crop, np.add(center, (2.1, -1.8)))
    np.testing.assert_allclose(place, center, atol=0.05)
    assert similarity > 0.99
