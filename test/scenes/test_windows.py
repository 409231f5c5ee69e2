import numpy as np
import pytest

from colortrack_ros.scenes import open_scene
from colortrack_ros.scenes.patches import relief


def paths(name, options='width=640&height=480'):
    """The scene, the centers (frames, objects, 2) and what is visible, (frames, objects)."""
    scene = open_scene(f'window_{name}?{options}')
    truth = np.stack([scene.truth(k) for k in range(len(scene))])
    return scene, np.stack([truth['u'], truth['v']], axis=2), truth['visible']


@pytest.mark.slow
@pytest.mark.parametrize('seed', [0, 1])
@pytest.mark.parametrize('name', ['texture', 'clutter', 'partial', 'hidden', 'jump'])
def test_all_patches_are_in_the_picture_from_the_first_frame_to_the_last(name, seed):
    _, center, visible = paths(name, f'width=640&height=480&seed={seed}')
    assert (visible[0] == 1).all()
    assert ((center > 0) & (center < [640, 480])).all()
    if name in ('texture', 'clutter', 'jump'):
        assert visible.min() > 0.9


@pytest.mark.parametrize(('name', 'left'), [('partial', 0.5), ('hidden', 0.0)])
def test_a_cover_hides_what_it_can_for_ten_frames_on_each_way(name, left):
    _, _, visible = paths(name)
    assert abs(visible.min() - left) < 0.02
    least = visible < left + 0.004
    for column in least.T:
        starts = np.flatnonzero(np.diff(column.astype(int)) == 1)
        lengths = np.flatnonzero(np.diff(column.astype(int)) == -1) - starts
        assert len(starts) == 4
        assert (np.abs(lengths - 10) <= 1).all()


def test_patches_jump_by_all_angles_at_the_same_speed():
    _, center, _ = paths('jump')
    step = np.diff(center, axis=0)
    speed = np.linalg.norm(step, axis=2)
    assert np.median(speed) == pytest.approx(0.206 * 640 / 24)
    cosine = (step[1:] * step[:-1]).sum(axis=2) / speed[1:] / speed[:-1]
    assert ((cosine < 0.9).sum(axis=0) > 15).all()
    assert cosine.min() < -0.8


def test_textures_alike_are_alike_and_others_are_not():
    scene, center, _ = paths('clutter')
    image = scene.render(0).mean(axis=2)
    looks = []
    for u, v in np.rint(center[0]).astype(int):
        looks.append(image[v - 20 : v + 21, u - 20 : u + 21].ravel())
    alike = np.corrcoef(looks)[0, 1:]
    assert (alike > 0.5).all()
    assert (alike < 0.95).all()
    apart = np.corrcoef([relief((0, i)).ravel() for i in range(6)])
    assert np.abs(apart - np.eye(6)).max() < 0.5


def test_a_patch_turns_about_its_center_and_grows():
    scene, center, _ = paths('texture', 'width=640&height=480&noise=0')
    sizes = [scene.truth(k)['radius'] for k in (0, 100, 200, 300)]
    assert np.ptp(sizes, axis=0).min() > 3
    for k in (0, 100, 300):
        mask = scene.segments(k)
        for (u, v), row in zip(center[k], scene.truth(k), strict=True):
            r = int(1.5 * row['radius'])
            part = mask[int(v) - r : int(v) + r + 1, int(u) - r : int(u) + r + 1]
            y, x = np.nonzero(part)
            assert len(x) == pytest.approx(4 * row['radius'] ** 2, rel=0.03)
            assert abs(x.mean() + int(u) - r - u) < 0.3
            assert abs(y.mean() + int(v) - r - v) < 0.3
