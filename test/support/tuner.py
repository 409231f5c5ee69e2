"""The tuner as a user starts it, and a browser in front of it."""

import asyncio
from collections.abc import Iterator
import contextlib
import importlib.util
import json
import os
import shutil
import signal
import subprocess

import aiohttp
import pytest
from support.ros_domain import executable
from support.waiting import PATIENCE

TEXT = aiohttp.WSMsgType.TEXT
BROWSER = next(
    filter(None, map(shutil.which, ('chromium', 'google-chrome', 'chromium-browser'))), ''
)
DRIVEN = BROWSER and importlib.util.find_spec('playwright')
NEEDS_BROWSER = pytest.mark.skipif(not DRIVEN, reason='there is no chromium, or no playwright')


@contextlib.contextmanager
def tuner(*arguments: object, killed: bool = False, **env: str) -> Iterator[str]:
    """The address of a tuner, which has to end well, unless it is killed in the middle."""
    command = [executable('tuner'), '--port', '0', *map(str, arguments)]
    environment = {**os.environ, **env}
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
    try:
        line = process.stdout.readline()
        assert 'http://' in line, line
        yield line.split()[1]
        if killed:
            return
        process.send_signal(signal.SIGINT)
        assert process.wait(PATIENCE) == 0
    finally:
        process.kill()
        process.wait()


def talk(url, messages, **headers):
    """The server's answers to messages."""

    async def told():
        answers = []
        async with (
            aiohttp.ClientSession() as session,
            session.ws_connect(f'{url}socket', headers=headers) as wire,
        ):
            for message in messages:
                await wire.send_str(message if isinstance(message, str) else json.dumps(message))
            await wire.send_str(json.dumps({'do': 'the end'}))
            async for got in wire:
                if got.type != TEXT:
                    continue
                answers.append(json.loads(got.data))
                if 'the end' in answers[-1].get('why', ''):
                    return answers

    return asyncio.run(told())


def state_of(url):
    """What a browser that comes now gets to know."""
    return asyncio.run(
        _first(url, lambda got: got.type == TEXT and got.json()['is'] == 'state')
    ).json()


def see_a_picture(url):
    """Wait until a browser that comes now has got a picture."""
    asyncio.run(_first(url, lambda got: got.type == aiohttp.WSMsgType.BINARY))


async def _first(url, fits):
    async with aiohttp.ClientSession() as session, session.ws_connect(f'{url}socket') as wire:
        async for got in wire:
            if fits(got):
                return got


def only(answers, kind):
    return [answer for answer in answers if answer['is'] == kind]


@contextlib.contextmanager
def browser() -> Iterator[object]:
    """Chromium without a window."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path=BROWSER, args=['--no-sandbox'])
        try:
            yield found
        finally:
            found.close()


def open_page(found, url: str, **options):
    """A page of the tuner that shows its first picture; any error of its code fails the test."""
    page = found.new_page(**{'viewport': {'width': 1280, 'height': 900}} | options)
    page.set_default_timeout(1000 * PATIENCE)
    errors = page.errors = []
    page.on('pageerror', lambda error: errors.append(str(error)))
    page.on('console', lambda message: message.type == 'error' and errors.append(message.text))
    page.goto(url)
    page.wait_for_selector('body[data-frame][data-changes]')
    return page


def look_at(page, number: int) -> None:
    """Scrub to a frame, and wait until it is shown with its tracks."""
    page.evaluate(
        """number => {
            const line = document.querySelector('#timeline');
            line.value = number;
            line.dispatchEvent(new Event('input'));
            line.dispatchEvent(new Event('change'));
        }""",
        number,
    )
    page.wait_for_selector(f'body[data-frame="{number}"]:not([data-tracks=""])')


def place(page, u: float, v: float, size: tuple[int, int]) -> dict[str, float]:
    """Where on the canvas a pixel of the picture is."""
    box = page.locator('#picture').bounding_box()
    return {'x': (u + 0.5) * box['width'] / size[0], 'y': (v + 0.5) * box['height'] / size[1]}


def click(page, u: float, v: float, size: tuple[int, int], *modifiers: str) -> None:
    """Click on a pixel of the picture, and wait until that has changed something."""
    before = page.get_attribute('body', 'data-changes')
    page.locator('#picture').click(position=place(page, u, v, size), modifiers=list(modifiers))
    page.wait_for_selector(f'body:not([data-changes="{before}"])')
    page.wait_for_selector('body:not([data-tracks=""])')
