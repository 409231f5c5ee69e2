import cv2
import numpy as np
import pytest

from colortrack_ros.scenes import open_scene


def lab(bgr):
    return cv2.cvtColor(np.asarray(bgr, np.float32) / 255, cv2.COLOR_BGR2Lab)


def difference(image, color):
    """CIELAB distance (2.1) of each pixel from R, G, B."""
    return np.linalg.norm(lab(image) - lab([[color[::-1]]]), axis=2)


@pytest.mark.slow
def test_the_room_of_clutter_holds_the_colors_of_the_balls():
    scene = open_scene('clutter')
    assert list(scene.colors) == ['red', 'yellow', 'blue']
    image = scene.render(0)
    assert len(scene.truth(0)) == 0
    for color in scene.colors.values():
        assert np.sum(difference(image, color) < 20) > 5000


@pytest.mark.slow
def test_balls_of_clutter_have_the_color_that_the_truth_says():
    scene = open_scene('clutter')
    colors = list(scene.colors.values())
    seen, most = set(), 0
    for k in range(0, len(scene), 8):
        truth, image = scene.truth(k), None
        most = max(most, len(truth))
        for row in truth[truth['visible'] == 1]:
            image = scene.render(k) if image is None else image
            u, v = round(row['u']), round(row['v'])
            patch = image[v - 4 : v + 5, u - 4 : u + 5]
            assert np.median(difference(patch, colors[row['color']])) < 15
            seen.add((int(row['id']), int(row['color'])))
    assert len(seen) == 9
    assert most == 3


@pytest.mark.slow
def test_somebody_in_blue_walks_through_clutter():
    scene = open_scene('clutter?noise=0')
    blue = [difference(scene.render(k), scene.colors['blue']) < 15 for k in (0, 60)]
    assert np.sum(blue[0] & ~blue[1]) > 10_000


def test_the_light_of_light_falls_to_a_third_and_turns_yellow():
    scene = open_scene('light?noise=0')
    first, last = (scene.render(k).reshape(-1, 3).mean(axis=0) for k in (0, 480))
    assert last.mean() / first.mean() == pytest.approx(1 / 3, abs=0.05)
    blue, green, red = last / first
    assert blue < 0.5 * green < green < red
    levels = [scene.render(k).mean() for k in range(0, 500, 24)]
    assert (np.diff(levels) < 0.5).all()
    for k in range(0, 500, 50):
        assert (scene.truth(k)['visible'] == 1).all()
        assert len(scene.truth(k)) == 3


@pytest.mark.slow
def test_balls_of_fast_move_more_than_their_diameter_a_frame_and_are_smeared():
    scene = open_scene('fast?noise=0')
    background = open_scene('five?noise=0').render(0)
    compared = 0
    for k in range(1, len(scene)):
        now, before = scene.truth(k), scene.truth(k - 1)
        if len(now) != 1 or len(before) != 1 or now['id'] != before['id']:
            continue
        moved = np.hypot(now['u'] - before['u'], now['v'] - before['v'])[0]
        assert moved > 2 * now['radius'][0]
        if k % 5 == 0 and now['visible'] == 1:
            weight = np.minimum(cv2.absdiff(scene.render(k), background).sum(axis=2), 60)
            count, _, stats, _ = cv2.connectedComponentsWithStats((weight > 30).astype(np.uint8))
            v, u = np.nonzero(weight > 30)
            assert count == 2
            assert (u.mean(), v.mean()) == pytest.approx((now['u'][0], now['v'][0]), abs=0.3)
            assert max(stats[1, 2:4]) > 1.6 * 2 * now['radius'][0] / np.sqrt(2)
            compared += 1
    assert compared > 20
