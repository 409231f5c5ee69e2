"""What goes to the browsers."""

import asyncio
import json

import aiohttp
from support.tuner import tuner

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
            values = {'node': 'detector', 'values': {'min_aspect': 0.3}, 'follows': False}
            found = [await next_view(one), await next_view(other)]
            await one.send_str(json.dumps({'do': 'set'} | values))
            while found[-1][0]['revision'] == found[0][0]['revision']:
                found.append(await next_view(one))
            found.append(await next_view(other))
            return found

    with tuner(SCENE, '--folder', tmp_path) as url:
        (first, size), (_, of_other), *later = asyncio.run(sizes(url))
    assert size == of_other > 0
    assert {size for view, size in later if view['number'] == first['number']} == {0}


async def next_view(wire):
    """The JSON of the next view, which is answered, and the size of its picture [bytes]."""
    async for got in wire:
        if got.type == aiohttp.WSMsgType.BINARY:
            text, jpeg, _ = LENGTHS.unpack_from(got.data)
            await wire.send_str(json.dumps({'do': 'shown'}))
            return json.loads(got.data[LENGTHS.size :][:text]), jpeg
    return None
