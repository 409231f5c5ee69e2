"""The whole story in a browser: open, click on a ball, look at the mask, drag a slider, save."""

import io
import json
import threading
import time
import zipfile

import cv2
import numpy as np
import pytest
from support.paths import DATA
from support.processors import children
from support.processors import stay_of
from support.tuner import browser
from support.tuner import click
from support.tuner import look_at
from support.tuner import NEEDS_BROWSER
from support.tuner import open_page
from support.tuner import place
from support.tuner import tuner
import yaml

from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.evaluation import read_record
from colortrack_ros.replay.command import replay
from colortrack_ros.scenes import open_scene
from colortrack_ros.tools.evaluate import main as evaluate
from colortrack_ros.tuner.settings import Settings

pytestmark = NEEDS_BROWSER

ROOM = 'scene:clutter?width=640&height=360&duration=10'

ORANGE = (230, 159, 0)
"""The first color of the page's palette."""


@pytest.fixture(scope='module')
def chromium():
    with browser() as found:
        yield found


def canvas(page):
    """What the canvas shows, (H, W, 3) RGB."""
    png = page.locator('#picture').screenshot()
    return cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]


def masked(page, inks=(ORANGE,)):
    """(H, W) where the page shows the mask and nothing else, when all other layers are off."""
    shown = canvas(page).astype(int)
    return np.any([np.abs(shown - ink).max(axis=2) < 12 for ink in inks], axis=0)


def only_the_mask(page):
    for layer in ('picture', 'blobs', 'tracks', 'trails', 'ellipses'):
        page.uncheck(f'#layer-{layer}')


def save(page, path='my.yaml'):
    page.click('#save')
    page.fill('#path', path)
    page.locator('#path').blur()
    page.wait_for_selector('#save-now:enabled')
    page.click('#save-now')
    page.wait_for_selector('body[data-saved]')


@pytest.mark.slow
def test_balls_picked_in_a_room_of_their_colors_are_tracked_with_what_is_saved(chromium, tmp_path):
    scene = open_scene(ROOM.removeprefix('scene:'))
    size = scene.width, scene.height
    with tuner(ROOM, '--folder', tmp_path) as url:
        began = time.monotonic()
        page = open_page(chromium, url)
        for name, frame in (('red', 20), ('yellow', 60), ('blue', 90)):
            look_at(page, frame)
            rows = scene.truth(frame)
            (ball,) = rows[rows['color'] == list(scene.colors).index(name)][-1:]
            page.fill('#name', name)
            page.click('#add')
            click(page, ball['u'], ball['v'], size)
        page.fill('#search', 'moving_only')
        page.check('#all-detector-moving_only')
        slider = page.locator('#shape .field', has_text='min_aspect').locator('input[type=range]')
        slider.scroll_into_view_if_needed()
        box = slider.bounding_box()
        page.mouse.move(box['x'] + 8, box['y'] + box['height'] / 2)
        page.mouse.down()
        page.mouse.move(box['x'] + 0.33 * box['width'], box['y'] + box['height'] / 2, steps=5)
        page.mouse.up()
        page.fill('#shape-detector-max_area', '1200')
        page.locator('#shape-detector-max_area').blur()
        page.wait_for_selector('body[data-changes="6"]')
        save(page)
        print(f'from the page to the saved file: {time.monotonic() - began:.1f} s')
        assert page.errors == []
    given = yaml.safe_load((tmp_path / 'my.yaml').read_text())['/**/detector']['ros__parameters']
    assert given['colors'] == ['red', 'yellow', 'blue']
    assert given['moving_only'] is True
    assert given['max_area'] == 1200
    assert 0.2 < given['min_aspect'] < 0.45
    files = ['--params-file', f'{tmp_path}/my.yaml', '--csv', f'{tmp_path}/t.csv']
    files += ['--output', f'{tmp_path}/t']
    assert replay([ROOM, *files], threading.Event()) == 0
    judge = [f'{tmp_path}/t.csv', '--truth', ROOM, '--radius', '20', '--visible', '0.25']
    assert evaluate([*judge, '--min', 'idf1=0.95']) == 0


@pytest.mark.slow
@pytest.mark.skipif(not (DATA / 'ball_toss').exists(), reason='no ../shared/data')
def test_the_mask_covers_a_ball_that_is_clicked_in_a_video_and_no_wall(chromium, tmp_path):
    video = DATA / 'ball_toss' / 'ball.mp4'
    number, u, v, radius, size = 25, 506, 59, 21, (1280, 720)  # read by eye
    with tuner(video, '--folder', tmp_path) as url:
        page = open_page(chromium, url)
        look_at(page, number)
        click(page, u, v, size)
        only_the_mask(page)
        mask = masked(page)
        spot = place(page, u, v, size)
        rows, columns = np.indices(mask.shape)
        scale = mask.shape[1] / size[0]
        away = np.hypot(columns - spot['x'], rows - spot['y']) / scale
        assert mask[away < 0.6 * radius].mean() > 0.8
        assert mask[away > 2 * radius].mean() < 0.02
        assert page.errors == []


@pytest.mark.slow
def test_a_region_that_is_drawn_is_not_looked_in_and_all_goes_by_keys(chromium, tmp_path):
    scene = open_scene('single?width=320&height=240&duration=2')
    (ball,) = scene.truth(10)
    with tuner('scene:single?width=320&height=240&duration=2', '--folder', tmp_path) as url:
        page = open_page(chromium, url, viewport={'width': 400, 'height': 800}, color_scheme='dark')
        look_at(page, 10)
        assert page.locator('#found').inner_text().startswith('1 blobs')
        page.locator('#picture').focus()
        across, down = round(ball['u']) - 160, round(ball['v']) - 120
        for key, way in (('Right', across), ('Left', -across), ('Down', down), ('Up', -down)):
            for _ in range(way):
                page.keyboard.press(f'Arrow{key}')
        page.keyboard.press('Enter')
        page.wait_for_selector('body[data-changes="1"]')
        page.locator('h1').click()
        page.keyboard.press('s')
        page.wait_for_selector('#save-now:enabled')
        page.locator('#save-now').press('Enter')
        page.wait_for_selector('body[data-saved]')
        given = yaml.safe_load((tmp_path / 'colortrack.yaml').read_text())
        assert given['/**/detector']['ros__parameters']['colors'] == ['ball']
        page.fill('#shape-detector-min_aspect', '7')
        page.locator('#shape-detector-min_aspect').blur()
        page.wait_for_selector('#notice:text("min_aspect: expected 0..1, got 7")')
        assert page.input_value('#shape-detector-min_aspect') == '0'
        page.click('#ignore')
        u, v, reach = float(ball['u']), float(ball['v']), float(ball['radius']) + 4
        for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            corner = min(max(u + x * reach, 0), 319), min(max(v + y * reach, 0), 239)
            page.locator('#picture').click(position=place(page, *corner, (320, 240)))
        page.keyboard.press('Enter')
        page.wait_for_selector('#regions .region')
        page.wait_for_selector('#found:text("0 blobs")')
        page.keyboard.press('u')
        page.wait_for_selector('#found:text("1 blobs")')
        assert page.errors == []


@pytest.mark.slow
def test_two_balls_are_labeled_by_a_click_each_and_saved(chromium, tmp_path):
    spec = 'five?width=320&height=180&duration=8'
    scene = open_scene(spec)
    seen = [scene.truth(k)[scene.truth(k)['visible'] == 1] for k in range(len(scene))]
    frame = next(k for k, balls in enumerate(seen) if len(balls) > 1)
    with tuner(f'scene:{spec}', '--folder', tmp_path) as url:
        page = open_page(chromium, url)
        look_at(page, frame)
        page.click('#labeling summary')
        page.wait_for_selector('body[data-surveyed="true"]')
        for k, ball in enumerate(seen[frame][:2]):
            page.fill('#label-id', str(k + 1))
            page.locator('#label-id').blur()
            spot = place(page, float(ball['u']), float(ball['v']), (320, 180))
            page.locator('#picture').hover(position=spot)
            page.mouse.wheel(0, -400)  # what is below the pointer stays there
            page.wait_for_timeout(100)
            page.locator('#picture').click(position=spot)
            page.locator('h1').click()
            page.keyboard.press('0')
            page.wait_for_selector(f'body[data-labels$="{k + 1}:1"]')
        page.click('#label-save')
        page.wait_for_selector('body[data-saved-labels]')
        assert page.errors == []
    truth = read_record(tmp_path / 'truth.csv')
    for k, ball in enumerate(seen[frame][:2]):
        (row,) = truth.rows[(truth.rows['frame'] == frame) & (truth.rows['id'] == k + 1)]
        assert abs(row['u'] - ball['u']) < 2
        assert abs(row['v'] - ball['v']) < 2
        assert np.count_nonzero(truth.rows['id'] == k + 1) > 20


MOVING = 'scene:clutter?width=320&height=180&duration=4&noise=0'


@pytest.mark.slow
def test_the_background_is_shown_and_a_snapshot_tells_all_that_a_report_needs(chromium, tmp_path):
    scene = open_scene(MOVING.removeprefix('scene:'))
    frame = next(k for k in range(50, len(scene)) if (scene.truth(k)['visible'] == 1).any())
    ball = scene.truth(frame)[scene.truth(frame)['visible'] == 1][0]
    with tuner(MOVING, '--folder', tmp_path) as url:
        page = open_page(chromium, url)
        look_at(page, frame)
        page.keyboard.press('8')
        page.wait_for_selector('#notice:text("No background is learned")')
        click(page, ball['u'], ball['v'], (320, 180))
        page.fill('#name', 'moving')
        page.click('#rename')
        page.wait_for_selector('#color-moving:checked')
        page.click('#color-title')
        assert 'lab' in page.locator('#color-fields').inner_text()
        page.locator('#reach canvas[aria-label*="within reach"]').first.wait_for()
        page.fill('#search', 'moving_only')
        page.check('#all-detector-moving_only')
        page.wait_for_selector('body[data-changes="3"]:not([data-tracks=""])')
        for layer in ('mask', 'blobs', 'tracks', 'trails', 'ellipses'):
            page.uncheck(f'#layer-{layer}')
        page.wait_for_function(
            """([x, y]) => document.querySelector('#picture').getContext('2d')
                .getImageData(x, y, 1, 1).data.slice(0, 3).every((level) => level > 150)""",
            arg=[round(a * page_scale(page)) for a in (float(ball['u']), float(ball['v']))],
        )
        with page.expect_download() as download:
            page.click('#snapshot')
        file = zipfile.ZipFile(io.BytesIO(download.value.path().read_bytes()))
        assert page.errors == []
    about, settings = json.loads(file.read('about.json')), file.read('settings.yaml').decode()
    assert about['source'] == MOVING
    assert set(about['versions']) >= {'colortrack_ros', 'opencv', 'numpy'}
    assert 'colors: [moving]' in settings
    image = cv2.imdecode(np.frombuffer(file.read('frame.png'), np.uint8), cv2.IMREAD_COLOR)
    detector = Detector(Settings(settings.replace('moving_only: true', '')).detector)
    found = detector.detect(Frame(image)).rows
    (blob,) = (b for b in about['blobs'] if abs(b['u'] - ball['u']) + abs(b['v'] - ball['v']) < 3)
    assert np.hypot(found['u'] - blob['u'], found['v'] - blob['v']).min() < 1


def page_scale(page):
    """Pixels of the canvas for each of the picture."""
    return page.evaluate("document.querySelector('#picture').width") / 320


@pytest.mark.alone
def test_a_slider_shows_in_the_next_picture_within_a_tenth_of_a_second(chromium, tmp_path):
    """By the clock, less the time that tuner and page wait for processors that others have."""
    with tuner('scene:clutter?width=640&height=480&duration=6', '--folder', tmp_path) as url:
        page = open_page(chromium, url)
        look_at(page, 100)
        threads = [one for process in children('bin/tuner') for one in process.glob('task/*')]
        threads += [one / 'task' / one.name for one in children('--type=renderer')]
        for _ in range(3):  # with others at work each step takes longer, too
            late = np.percentile([drag(page, threads, 0.1 + 0.01 * k) for k in range(40)], 95)
            print(f'from slider to picture: {1000 * late:.0f} ms in 95 of 100')
            if late < 0.1:
                break
        assert late < 0.1
        assert page.errors == []


def drag(page, threads, value):
    """How long a person waits whose machine has nothing else to do [s]."""
    before = stay_of(threads)
    waited = page.evaluate(DRAG, value)
    after = stay_of(threads)
    page.wait_for_timeout(5 if round(100 * value) % 3 else 150)  # while it still works, or no more
    alone = max(waited - after.queued + before.queued, after.running - before.running)
    return min(waited, alone)  # threads that run side by side take more time in sum than the clock


DRAG = """async (value) => {
    const field = [...document.querySelectorAll('#shape .field')]
        .find((one) => one.textContent.includes('min_aspect'));
    const slider = field.querySelector('input[type=range]');
    delete document.body.dataset.wait;
    slider.value = value;
    slider.dispatchEvent(new Event('input'));
    while (document.body.dataset.wait === undefined) await new Promise(requestAnimationFrame);
    return Number(document.body.dataset.wait) / 1000;
}"""
