"""What goes to the browsers."""

import asyncio
import json

import aiohttp
from support.tuner import tuner

from colortrack_ros.tuner.view import AS_BEFORE
from colortrack_ros.tuner.view import LENGTHS

SCENE = 'scene:single?width=160&height=120&duration=2'


def test_a_picture_is_sent_once_to_each_browser_whatever_is_changed(tmp_path):
    """While somebody drags a slider, all that changes is what is found in it."""

    async def sizes(url):
        async with (
            aiohttp.ClientSession() as session,
            session.ws_connect(f'{url}socket') as one,
            session.ws_connect(f'{url}socket') as other,
        ):
            found = [await next_view(one), await next_view(other)]
            values = {'node': 'detector', 'values': {'min_aspect': 0.3}, 'follows': False}
            await one.send_str(json.dumps({'do': 'set'} | values))
            found.append(await view_of(one, lambda view: view['revision'] == 1))
            for frame in (7, 0):
                await one.send_str(json.dumps({'do': 'seek', 'frame': frame}))
                found.append(await view_of(one, lambda view, at=frame: view['number'] == at))
            async with session.ws_connect(f'{url}socket') as third:
                return [*found, await next_view(third)]

    with tuner(SCENE, '--folder', tmp_path) as url:
        (_, first), (_, other), (_, changed), *others = asyncio.run(sizes(url))
    assert changed == AS_BEFORE
    assert first == other
    assert all(0 < size < AS_BEFORE for _, size in ((_, first), *others))


async def view_of(wire, fits):
    """The first such view."""
    while True:
        view, size = await next_view(wire)
        if fits(view):
            return view, size


async def next_view(wire):
    """The JSON of the next view, which is answered, and the size of its picture [bytes]."""
    async for got in wire:
        if got.type == aiohttp.WSMsgType.BINARY:
            text, jpeg, _ = LENGTHS.unpack_from(got.data)
            await wire.send_str(json.dumps({'do': 'shown'}))
            return json.loads(got.data[LENGTHS.size :][:text]), jpeg
    return None
