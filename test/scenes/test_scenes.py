import hashlib

import cv2
import numpy as np
import pytest

from colortrack_ros.scenes import open_scene
from colortrack_ros.scenes import SCENES
from colortrack_ros.scenes import TRUTH

SMALL = 'width=320&height=180&duration=20.8'

DIGESTS = {
    'single': '0e1f8ce1c7336556',
    'enter_exit': '1c7644bbdf2f5679',
    'five': '1c80b6b83cc7f042',
    'crossing': 'c839d92f80b2793b',
    'occlusion': 'ad344043c5f44493',
    'collision': '6851eccb1033f0b6',
    'swarm': 'a82a91bf3f72d8c5',
    'juggle': 'bc13f1718188ebde',
    'turns': 'ab92228d20bc7c95',
    'blackout': '0f538908d487c792',
    'flicker': 'bcd09e56ba881169',
    'vanish': '42fe1bfad8fdf6ed',
    'clutter': '81b5ad70e2882168',
    'light': '247655e48938b455',
    'fast': 'b32e0a1f71c8177f',
    'window_texture': '3af825f8b1d1afe5',
    'window_clutter': '6208d16e35924a11',
    'window_partial': 'c71d726b7ad06bd6',
    'window_hidden': 'db164c9e340e5b1c',
    'window_jump': '64be306c64324f10',
    'silhouette': 'bcded963cb4519cc',
    'approach': '7be16d6f1dd006ee',
    'red_object': '7d831611572d0c50',
    'red_pair': 'a0fda0886514d68d',
    'red_hidden': '148c3947c17ae8c4',
    'red_throw': 'cfeee5cc4f65b314',
    'red_curve': 'b8939d6df6f32453',
}
"""SHA-256 of frame 250 with all options at their defaults, first 16 digits."""


def all_truth(scene):
    return [scene.truth(k) for k in range(len(scene))]


def coverage(scene, k, background):
    """Where the picture differs from the background: blobs as a perfect detector sees them."""
    return (cv2.absdiff(scene.render(k), background) > 50).any(axis=2)


@pytest.mark.parametrize('name', SCENES)
def test_frames_are_the_same_on_every_machine(name):
    frame = open_scene(name).render(250)
    assert frame.shape == (720, 1280, 3)
    assert frame.dtype == np.uint8
    assert hashlib.sha256(frame.tobytes()).hexdigest()[:16] == DIGESTS[name]


@pytest.mark.parametrize('name', SCENES)
def test_frames_and_truth_can_be_asked_for_in_any_order(name):
    first, second = open_scene(f'{name}?{SMALL}'), open_scene(f'{name}?{SMALL}')
    for k in (0, 250, 499):
        first.render(k)
    np.testing.assert_array_equal(first.render(123), second.render(123))
    np.testing.assert_array_equal(first.truth(123), second.truth(123))


@pytest.mark.parametrize('name', SCENES)
def test_a_rendered_frame_is_never_overwritten(name):
    scene = open_scene(f'{name}?{SMALL}')
    frame = scene.render(200)
    before = frame.copy()
    scene.render(201)
    assert frame.flags.owndata
    np.testing.assert_array_equal(frame, before)


@pytest.mark.slow
def test_scenes_last_as_long_as_pegorettis_videos():
    for name in SCENES:
        scene = open_scene(name)
        assert (scene.width, scene.height, scene.rate, len(scene)) == (1280, 720, 24.0, 500)


@pytest.mark.parametrize('name', SCENES)
@pytest.mark.parametrize('query', ['width=16&height=16', 'width=33&height=999&duration=0.01'])
def test_every_scene_can_be_rendered_in_any_size(name, query):
    scene = open_scene(f'{name}?{query}')
    for k in (0, len(scene) // 2, len(scene) - 1):
        assert scene.render(k).shape == (scene.height, scene.width, 3)
        assert scene.truth(k).dtype == TRUTH


def test_options_set_size_rate_noise_and_length():
    scene = open_scene('five?width=641&height=479&rate=30&noise=0&seed=3&duration=10')
    assert scene.render(0).shape == (479, 641, 3)
    assert (scene.rate, len(scene)) == (30.0, 300)
    background = scene.render(0)
    empty = ~coverage(scene, 200, background)
    assert (scene.render(200) == background)[empty].mean() > 0.99


def test_motion_scales_with_the_picture_and_the_rate():
    large, small = open_scene('single'), open_scene('single?width=640&height=360&rate=48')
    a, b = large.truth(100)[0], small.truth(200)[0]
    assert a['u'] + 0.5 == pytest.approx(2 * (b['u'] + 0.5))
    assert a['v'] + 0.5 == pytest.approx(2 * (b['v'] + 0.5))
    assert a['radius'] == pytest.approx(2 * b['radius'])


@pytest.mark.parametrize(
    ('spec', 'words'),
    [
        ('fife', ['fife', 'five', 'occlusion']),
        ('', ['single', 'five']),
        ('five?size=3', ['size=3', 'width', 'seed']),
        ('five?width', ['width', 'whole number']),
        ('five?width=wide', ['width=wide', 'whole number']),
        ('five?noise=loud', ['noise=loud', 'number']),
        ('five?width=0', ['width=0', '16', '7680']),
        ('five?rate=nan', ['rate=nan', '1']),
        ('five?duration=0', ['duration=0', '20.8']),
        ('five?seed=-1', ['seed=-1']),
    ],
)
def test_a_bad_spec_is_refused_with_what_was_given_and_what_works(spec, words):
    with pytest.raises(ValueError, match='scene') as caught:
        open_scene(spec)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize('k', [-1, 500])
def test_a_frame_outside_the_scene_is_refused(k):
    scene = open_scene(f'single?{SMALL}')
    with pytest.raises(IndexError, match='499'):
        scene.render(k)
    with pytest.raises(IndexError, match='499'):
        scene.truth(k)


@pytest.mark.slow
@pytest.mark.parametrize('name', ['single', 'enter_exit', 'crossing'])
def test_truth_is_where_the_picture_shows_the_ball(name):
    scene = open_scene(f'{name}?noise=0')
    background = open_scene('five?noise=0').render(0)
    errors = []
    for k in range(0, len(scene), 10):
        truth = scene.truth(k)
        if len(truth) != 1 or truth['visible'][0] < 1:
            continue
        v, u = np.nonzero(coverage(scene, k, background))
        errors.append((u.mean() - truth['u'][0], v.mean() - truth['v'][0]))
        assert len(u) == pytest.approx(np.pi * truth['radius'][0] ** 2, rel=0.05)
    # A mask of whole pixels knows the center to about 0.05 px; test_shapes looks closer.
    assert len(errors) >= 8
    assert np.abs(errors).max() < 0.2
    assert np.abs(np.mean(errors, axis=0)).max() < 0.05


@pytest.mark.slow
def test_visible_is_the_part_of_the_disc_that_the_picture_shows():
    scene = open_scene('occlusion?noise=0')
    background = scene.render(0)
    seen = []
    for k in range(0, len(scene), 5):
        truth = scene.truth(k)
        expected = np.sum(truth['visible'] * np.pi * truth['radius'] ** 2)
        assert coverage(scene, k, background).sum() == pytest.approx(expected, rel=0.04, abs=110)
        seen.extend(truth['visible'])
    assert min(seen) == 0
    assert max(seen) == 1
    assert np.mean((np.array(seen) > 0) & (np.array(seen) < 1)) > 0.05


def test_noise_is_new_in_each_frame_and_channel():
    scene = open_scene('five?width=640&height=360&noise=3')
    clean = open_scene('five?width=640&height=360&noise=0').render(0)
    a, b = (scene.render(k).astype(float) - clean for k in (0, 1))
    assert a.std() == pytest.approx(3, rel=0.05)
    assert abs(a.mean()) < 0.05
    assert abs(np.corrcoef(a.ravel(), b.ravel())[0, 1]) < 0.01
    assert abs(np.corrcoef(a[..., 0].ravel(), a[..., 1].ravel())[0, 1]) < 0.01


def test_the_seed_changes_texture_and_noise():
    a, b = (open_scene(f'five?{SMALL}&noise=0&seed={seed}').render(0) for seed in (0, 1))
    assert (a != b).mean() > 0.5


def test_single_is_wholly_visible_from_first_to_last_frame():
    truth = np.concatenate(all_truth(open_scene('single')))
    assert truth.dtype == TRUTH
    assert len(truth) == 500
    assert (truth['id'] == 1).all()
    assert (truth['visible'] == 1).all()


def test_enter_exit_is_empty_at_both_ends():
    counts = np.array([len(rows) for rows in all_truth(open_scene('enter_exit'))])
    inside = np.flatnonzero(counts)
    assert counts.max() == 1
    assert 2 * 24 < inside[0] < 4 * 24
    assert 19 * 24 < inside[-1] < 499
    assert (np.diff(inside) == 1).all()


@pytest.mark.parametrize('name', ['five', 'occlusion'])
def test_five_objects_come_one_after_the_other_and_leave_on_the_right(name):
    rows = all_truth(open_scene(name))
    assert len(rows[0]) == len(rows[-1]) == 0
    entered = []
    for i in range(1, 6):
        path = np.array([row for frame in rows for row in frame if row['id'] == i])
        entered.append(next(k for k, frame in enumerate(rows) if i in frame['id']))
        assert (np.diff(path['u']) > 0).all()
        assert path['u'][0] < 0
        assert path['u'][-1] > 1279
        assert np.ptp(path['v']) < 0.1 * 720
    assert entered == sorted(set(entered))


def test_occlusion_hides_each_object_for_half_a_second_to_a_second():
    rows = np.concatenate(all_truth(open_scene('occlusion')))
    for i in range(1, 6):
        assert 12 <= np.sum(rows['visible'][rows['id'] == i] == 0) <= 24
    assert np.sum(rows['visible'] == 0) == np.sum(
        (np.abs(rows['u'] - 646) < 60) & (rows['visible'] == 0)
    )


def test_objects_of_five_and_crossing_never_touch():
    for name in ('five', 'crossing'):
        for truth in all_truth(open_scene(name)):
            for i in range(len(truth)):
                for j in range(i):
                    a, b = truth[i], truth[j]
                    apart = np.hypot(a['u'] - b['u'], a['v'] - b['v'])
                    assert apart > a['radius'] + b['radius'] + 8


def test_the_paths_of_crossing_cross_and_both_leave():
    rows = all_truth(open_scene('crossing'))
    assert len(rows[0]) == len(rows[-1]) == 0
    first, second = (
        np.array([(r['u'], r['v']) for frame in rows for r in frame if r['id'] == i])
        for i in (1, 2)
    )
    nearest = np.hypot(*(first[:, None] - second[None]).transpose(2, 0, 1)).min()
    assert nearest < 6
    pairs = [f for f in rows if len(f) == 2]
    assert min(np.hypot(np.ptp(f['u']), np.ptp(f['v'])) for f in pairs) < 200
