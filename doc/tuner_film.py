"""The pictures of `doc/tuner.webp`: ``python doc/tuner_film.py FOLDER``.

Somebody clicks on a ball in a room of its colors, looks at the mask, has only what moves
detected, and goes on. Needs playwright, and chromium.
"""

from pathlib import Path
import shutil
import subprocess
import sys
import tempfile

from playwright.sync_api import Page
from playwright.sync_api import sync_playwright

SCENE = 'scene:clutter?width=640&height=360&duration=8'
FRAME, BALL, SIZE = 60, (546, 182), (640, 360)
RATE = 6
"""Pictures a second."""


class Film:
    """Takes pictures of a page, with a pointer where the mouse is."""

    def __init__(self, page: Page, folder: Path) -> None:
        self.page, self._folder, self._number = page, folder, 0

    def hold(self, seconds: float) -> None:
        """Stand still."""
        for _ in range(round(seconds * RATE)):
            self.page.screenshot(path=self._folder / f'{self._number:04d}.png')
            self._number += 1

    def move(self, x: float, y: float, steps: int = 4) -> None:
        """Move the pointer there [px of the window]."""
        for _ in range(steps):
            now = self.page.evaluate('[window.pointer.x, window.pointer.y]')
            way = [a + (b - a) * 0.5 for a, b in zip(now, (x, y), strict=True)]
            self.page.mouse.move(*way)
            self.hold(1 / RATE)
        self.page.mouse.move(x, y)

    def click(self, selector: str) -> None:
        """Move to something, and click on it."""
        found = self.page.locator(selector)
        found.scroll_into_view_if_needed()
        box = found.bounding_box()
        self.move(box['x'] + box['width'] / 2, box['y'] + box['height'] / 2)
        found.click()


POINTER = """
const mark = document.createElement('div');
mark.style.cssText = 'position:fixed;z-index:99;width:18px;height:18px;margin:-9px;'
    + 'border:3px solid #d55e00;border-radius:50%;pointer-events:none';
document.body.append(mark);
window.pointer = {x: 640, y: 500};
addEventListener('mousemove', (event) => {
    window.pointer = {x: event.clientX, y: event.clientY};
    mark.style.left = `${event.clientX}px`;
    mark.style.top = `${event.clientY}px`;
});
"""


def play_story(film: Film) -> None:
    """All that is seen."""
    page = film.page
    page.evaluate(
        """(number) => {
            const line = document.querySelector('#timeline');
            line.value = number;
            line.dispatchEvent(new Event('input'));
        }""",
        FRAME,
    )
    page.wait_for_selector(f'body[data-frame="{FRAME}"]:not([data-tracks=""])')
    page.fill('#name', 'ball')
    film.hold(1.0)
    box = page.locator('#picture').bounding_box()
    u, v = (a / b for a, b in zip(BALL, SIZE, strict=True))
    film.move(box['x'] + u * box['width'], box['y'] + v * box['height'])
    page.mouse.down()
    page.mouse.up()
    page.wait_for_selector('body[data-changes="1"]:not([data-tracks=""])')
    film.hold(1.5)
    page.fill('#search', 'moving_only')
    film.click('#all-detector-moving_only')
    page.wait_for_selector('body[data-changes="2"]:not([data-tracks=""])')
    film.hold(1.5)
    page.keyboard.press('Escape')
    page.locator('h1').click()
    for number in range(FRAME + 2, FRAME + 38, 2):
        page.keyboard.press('ArrowRight')
        page.keyboard.press('ArrowRight')
        page.wait_for_selector(f'body[data-frame="{number}"]')
        film.hold(1 / RATE)


def main() -> None:
    """Take the pictures."""
    pictures = Path(sys.argv[1])
    pictures.mkdir(parents=True, exist_ok=True)
    command = [Path(sys.executable).with_name('tuner'), '--port', '0', SCENE, '--folder']
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        server = subprocess.Popen([*command, folder], stdout=subprocess.PIPE, text=True)
        try:
            address = server.stdout.readline().split()[1]
            browser = shutil.which('chromium')
            found = playwright.chromium.launch(executable_path=browser, args=['--no-sandbox'])
            page = found.new_page(viewport={'width': 1100, 'height': 700}, color_scheme='light')
            page.goto(address)
            page.wait_for_selector('body[data-frame][data-changes]')
            page.evaluate(POINTER)
            play_story(Film(page, pictures))
            found.close()
        finally:
            server.terminate()
            server.wait()


if __name__ == '__main__':
    main()
