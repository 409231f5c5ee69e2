import numpy as np
import pytest

from colortrack_ros.scenes import open_scene
from colortrack_ros.scenes.outlines import PERSON
from colortrack_ros.scenes.outlines import QUADRILATERAL
from colortrack_ros.scenes.silhouettes import draw_polygon
from colortrack_ros.scenes.silhouettes import normalized
from colortrack_ros.scenes.silhouettes import placed
from colortrack_ros.scenes.silhouettes import Silhouette

SIZE = 'width=320&height=240'
COUNTS = {'silhouette': 2, 'approach': 4}


@pytest.mark.parametrize('name', COUNTS)
def test_after_a_second_of_the_background_alone_all_come_in_and_stay(name):
    scene = open_scene(f'{name}?{SIZE}')
    assert len(scene) > 300
    assert all(len(scene.truth(k)) == 0 for k in range(25))
    for k in range(85, len(scene)):
        truth = scene.truth(k)
        assert len(truth) == COUNTS[name]
        assert (truth['visible'] == 1).all()
    lone = [scene.segments(k) for k in range(0, 25, 6)]
    assert not np.any(lone)


@pytest.mark.parametrize('name', COUNTS)
@pytest.mark.parametrize('k', [100, 300, 480])
def test_truth_outlines_and_segments_agree(name, k):
    scene = open_scene(f'{name}?width=640&height=480')
    truth, outlines, mask = scene.truth(k), scene.outlines(k), scene.segments(k)
    assert list(outlines) == truth['id'].tolist()
    for row in truth:
        v, u = np.nonzero(mask == row['color'] + 1)
        assert len(u) == pytest.approx(np.pi * row['radius'] ** 2, abs=1.5 * float(row['radius']))
        assert np.hypot(u.mean() - row['u'], v.mean() - row['v']) < 0.35
        center = normalized(outlines[int(row['id'])])[1]
        np.testing.assert_allclose(center, [row['u'], row['v']], atol=1e-4)


def test_they_change_their_size_and_the_robots_grow():
    scene = open_scene(f'silhouette?{SIZE}')
    radius = np.stack([scene.truth(k)['radius'] for k in range(60, 499)])
    assert (radius.max(axis=0) > 1.1 * radius.min(axis=0)).all()
    scene = open_scene(f'approach?{SIZE}')
    radius = np.stack([scene.truth(k)['radius'] for k in range(85, 499)])
    assert (np.diff(radius, axis=0) > -0.01).all()
    assert (radius[-1] > 3 * radius[0]).all()


def test_they_are_dark_on_light():
    scene = open_scene(f'silhouette?{SIZE}&noise=0')
    image, mask = scene.render(200).max(axis=2), scene.segments(200)
    assert image[mask > 0].mean() < 70
    assert image[mask == 0].mean() > 200


@pytest.mark.parametrize('shape', [PERSON, QUADRILATERAL])
def test_a_polygon_covers_its_area_wherever_it_is(shape):
    outline = normalized(shape)[0]
    x, y = outline.T
    assert abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2 == pytest.approx(np.pi)
    for turn, center in ((0.0, (40.0, 40.0)), (0.7, (40.3, 39.6)), (-2.0, (44.5, 41.5))):
        image = np.full((80, 80, 3), 200, np.uint8)
        draw_polygon(image, placed(outline, np.array(center), 20.0, turn), (0, 100, 200))
        cover = (200 - image[..., 0].astype(float)) / 200
        assert cover.sum() == pytest.approx(np.pi * 400, rel=2e-3)
        v, u = np.indices(cover.shape)
        middle = (u * cover).sum() / cover.sum(), (v * cover).sum() / cover.sum()
        np.testing.assert_allclose(middle, center, atol=0.02)
        assert (image[..., 2] == 200).all()


@pytest.mark.parametrize('center', [(-15.0, 30.0), (75.0, 78.0), (-90.0, 500.0)])
def test_a_polygon_at_the_edge_is_drawn_as_far_as_it_is_inside(center):
    wide = np.zeros((280, 280, 3), np.uint8)
    image = np.zeros((80, 80, 3), np.uint8)
    outline = normalized(PERSON)[0]
    draw_polygon(image, placed(outline, np.array(center), 20.0, 0.3), (90, 90, 90))
    draw_polygon(wide, placed(outline, np.array(center) + 100, 20.0, 0.3), (90, 90, 90))
    np.testing.assert_array_equal(image, wide[100:180, 100:180])


def test_a_covered_silhouette_is_less_visible():
    scene = open_scene(f'approach?{SIZE}')
    assert all(isinstance(thing, Silhouette) for thing in scene._things)
    entering = np.concatenate([scene.truth(k)['visible'] for k in range(25, 60)])
    assert ((entering > 0) & (entering < 1)).any()
