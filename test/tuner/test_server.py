"""Whom the server lets in, what it writes, and what it makes of nonsense."""

import asyncio
import contextlib
import json
import random
import socket

import aiohttp
import pytest
from support.tuner import only
from support.tuner import state_of
from support.tuner import talk
from support.tuner import tuner
from support.waiting import PATIENCE
from support.waiting import wait_until

SCENE = 'scene:single?width=160&height=120&duration=2'


@pytest.fixture(scope='module')
def served(tmp_path_factory):
    folder = tmp_path_factory.mktemp('settings')
    with tuner(SCENE, '--folder', folder) as url:
        yield url, folder


def answer_of(url, path='', **headers):
    async def get():
        async with (
            aiohttp.ClientSession() as session,
            session.get(url + path, headers=headers, allow_redirects=False) as answer,
        ):
            return answer.status, dict(answer.headers), await answer.text()

    return asyncio.run(get())


def test_the_page_may_load_nothing_from_elsewhere(served):
    status, headers, _ = answer_of(served[0])
    assert status == 200
    assert "default-src 'none'" in headers['Content-Security-Policy']
    for path in (
        'page/app.js',
        'page/wire.js',
        'page/stage.js',
        'page/fields.js',
        'page/style.css',
    ):
        status, _, part = answer_of(served[0], path)
        assert status == 200
        assert 'https:' not in part
        assert '//cdn' not in part


@pytest.mark.parametrize(
    'name', ['evil.example', '127.0.0.1.evil.example', 'a@127.0.0.1', '', '::1:']
)
def test_other_names_that_point_here_are_refused(served, name):
    port = served[0].rstrip('/').rpartition(':')[2]
    assert answer_of(served[0], Host=f'{name}:{port}')[0] in (400, 403)
    assert answer_of(served[0], Host=f'localhost:{port}')[0] == 200
    assert answer_of(served[0], Host='127.0.0.1:1')[0] == 403


@pytest.mark.parametrize('origin', ['http://evil.example', 'null', 'http://127.0.0.1:1', 'file://'])
def test_pages_of_other_sites_are_refused(served, origin):
    assert answer_of(served[0], Origin=origin)[0] == 403
    with pytest.raises(aiohttp.WSServerHandshakeError, match='403'):
        talk(served[0], [], Origin=origin)


@pytest.mark.parametrize('path', ['page/../server.py', 'page/%2e%2e/server.py', '../etc/passwd'])
def test_nothing_but_the_page_is_served(served, path):
    host, port = served[0].removeprefix('http://').rstrip('/').split(':')
    with socket.create_connection((host, int(port))) as wire:
        wire.sendall(f'GET /{path} HTTP/1.1\r\nHost: {host}:{port}\r\n\r\n'.encode())
        assert int(wire.recv(1000).split()[1]) in (403, 404)


@pytest.mark.slow
def test_elsewhere_than_on_this_machine_the_token_is_needed(tmp_path):
    with tuner(SCENE, '--folder', tmp_path, '--address', '0.0.0.0') as url:
        port = url.split(':')[2].partition('/')[0]
        token = url.partition('token=')[2]
        here = f'http://127.0.0.1:{port}/'
        assert len(token) >= 20
        assert answer_of(here)[0] == 403
        assert answer_of(here, f'?token={token[:-1]}')[0] == 403
        status, headers, _ = answer_of(here, f'?token={token}')
        assert (status, headers['Location']) == (302, '/')
        assert f'tuner_token={token}; HttpOnly' in headers['Set-Cookie']
        assert answer_of(here, 'page/app.js')[0] == 403
        assert answer_of(here, 'page/app.js', Cookie=f'tuner_token={token}')[0] == 200
        assert answer_of(here, f'?token={token}', Host=f'evil.example:{port}')[0] == 403


def test_a_file_is_written_after_its_difference_was_shown_and_keeps_its_comments(served):
    url, folder = served
    text = '# mine\n/**/detector:\n  ros__parameters: {min_area: 30}  # px\n'
    (folder / 'a.yaml').write_text(text)
    change = {'do': 'set', 'node': 'detector', 'values': {'min_area': 44}, 'follows': False}
    answers = talk(
        url, [{'do': 'load', 'path': 'a.yaml'}, change, {'do': 'diff', 'path': 'a.yaml'}]
    )
    (seen,) = only(answers, 'diff')
    assert (
        '-  ros__parameters: {min_area: 30}  # px\n+  ros__parameters: {min_area: 44}'
        in seen['diff']
    )
    assert (folder / 'a.yaml').read_text() == text
    save = {'do': 'save', 'path': 'a.yaml', 'digest': seen['digest']}
    assert only(talk(url, [save | {'digest': '0'}]), 'saved') == []
    assert len(only(talk(url, [save]), 'saved')) == 1
    assert (folder / 'a.yaml').read_text() == text.replace('30', '44')
    assert only(talk(url, [save]), 'saved') == []  # what was seen is no longer so


def test_a_file_that_somebody_else_changes_is_not_overwritten(served):
    url, folder = served
    (folder / 'b.yaml').write_text('/**/tracker:\n  ros__parameters: {}\n')
    (seen,) = only(talk(url, [{'do': 'diff', 'path': 'b.yaml'}]), 'diff')
    (folder / 'b.yaml').write_text('/**/tracker:\n  ros__parameters: {max_detections: 9}\n')
    answers = talk(url, [{'do': 'save', 'path': 'b.yaml', 'digest': seen['digest']}])
    assert any('look again' in answer['why'] for answer in only(answers, 'refused'))
    assert 'max_detections: 9' in (folder / 'b.yaml').read_text()


def test_a_bad_value_is_refused_with_the_reason_of_the_node_and_the_old_one_stays(served):
    change = {'do': 'set', 'node': 'detector', 'values': {'min_aspect': 1.5}, 'follows': False}
    answers = talk(served[0], [{'do': 'play'}, change])
    assert any('min_aspect: expected 0..1, got 1.5' in a['why'] for a in only(answers, 'refused'))
    assert state_of(served[0])['values']['detector']['min_aspect'] == 0.0


PATHS = [
    '/tmp/evil.yaml', '../evil.yaml', 'a/../../evil.yaml', 'link.yaml', 'out/evil.yaml', 'evil.py',
    'evil.yaml\0', '.', '', 'folder.yaml', '~/evil.yaml', 'loop.yaml', 'new/evil.yaml',
]  # fmt: skip


@pytest.mark.parametrize('path', PATHS)
def test_nothing_is_read_or_written_outside_of_the_folder(served, tmp_path, path):
    url, folder = served
    elsewhere = tmp_path / 'elsewhere.yaml'
    elsewhere.write_text('/**/detector: {ros__parameters: {min_area: 1}}')
    for name, target in (('link.yaml', elsewhere), ('out', tmp_path), ('loop.yaml', 'loop.yaml')):
        (folder / name).unlink(missing_ok=True)
        (folder / name).symlink_to(target)
    (folder / 'folder.yaml').mkdir(exist_ok=True)
    before = sorted(p for p in [*folder.rglob('*'), *tmp_path.rglob('*'), *folder.parent.glob('*')])
    commands = [{'do': 'diff', 'path': path}, {'do': 'load', 'path': path}]
    answers = talk(url, [*commands, {'do': 'save', 'path': path, 'digest': ''}])
    assert len(only(answers, 'refused')) == 4
    assert only(answers, 'diff') == only(answers, 'saved') == []
    after = sorted(p for p in [*folder.rglob('*'), *tmp_path.rglob('*'), *folder.parent.glob('*')])
    assert after == before
    assert 'min_area: 1}' in elsewhere.read_text()


GOOD = [
    {'do': 'shown'}, {'do': 'pause'}, {'do': 'seek', 'frame': 3}, {'do': 'step', 'by': -1},
    {'do': 'set', 'node': 'detector', 'values': {'min_area': 9}, 'follows': True}, {'do': 'undo'},
    {'do': 'sample', 'color': 'x', 'is_it': True, 'u': 5, 'v': 5, 'width': 1, 'height': 1},
    {'do': 'survey'}, {'do': 'gone', 'id': 1, 'frame': 2}, {'do': 'unlabel', 'id': 1, 'frame': 2},
    {'do': 'label', 'id': 1, 'frame': 2, 'u': 5, 'v': 5, 'width': 1, 'height': 1}, {'do': 'plane'},
    {'do': 'labels_at', 'frame': 2}, {'do': 'save_labels', 'path': 'none', 'overwrite': True},
    {'do': 'rename_color', 'color': 'x', 'to': 'y'}, {'do': 'background'},
    {'do': 'load_labels', 'path': 'none.csv'}, {'do': 'remove_color', 'color': 'x'},
    {'do': 'learn_background'}, {'do': 'lines'},
    {'do': 'load', 'path': 'none.yaml'}, {'do': 'diff', 'path': 'none.yaml'},
    {'do': 'save', 'path': 'none.yaml', 'digest': 'none'},
]  # fmt: skip
VALUES = [
    None,
    True,
    -1,
    0,
    1e300,
    1 << 70,
    '',
    'x' * 9000,
    '\ud800',
    '../x',
    [],
    {},
    [[]],
    {'a': 1},
]


def mutated(chance):
    """A command with one thing in it changed."""
    message = dict(chance.choice(GOOD))
    kind = chance.randrange(5)
    if kind == 0:
        message[chance.choice(list(message))] = chance.choice(VALUES)
    elif kind == 1:
        message.pop(chance.choice(list(message)))
    elif kind == 2:
        message[str(chance.choice(VALUES))[:50]] = chance.choice(VALUES)
    text = json.dumps(message)
    if kind == 3:
        at = chance.randrange(len(text))
        text = text[:at] + chr(chance.randrange(32, 400)) + text[at + chance.randrange(3) :]
    return (
        text
        if kind < 4
        else chance.choice(['[' * 5000, 'NaN', '{"do": NaN}', '1' * 5000, '', text])
    )


@pytest.mark.slow
def test_ten_thousand_mutated_messages_are_answered_and_nothing_is_written(served, tmp_path):
    url, folder = served
    before = {p: p.read_bytes() for p in folder.rglob('*') if p.is_file()}
    chance = random.Random(7)

    async def flood():
        async with aiohttp.ClientSession() as session:
            for _ in range(10):
                async with session.ws_connect(f'{url}socket') as wire:
                    for _ in range(1000):
                        await wire.send_str(mutated(chance))
                    await wire.send_bytes(b'\0' * 100)
                    await wire.send_str(json.dumps({'do': 'the end'}))
                    async for got in wire:
                        if got.type == aiohttp.WSMsgType.TEXT and 'the end' in got.data:
                            break
                    else:
                        raise AssertionError('the server has hung up')

    asyncio.run(flood())
    assert {p: p.read_bytes() for p in folder.rglob('*') if p.is_file()} == before
    assert answer_of(url)[0] == 200


def test_a_message_that_is_too_large_ends_its_connection_alone(served):
    with pytest.raises((aiohttp.ClientError, AssertionError, TypeError)):
        assert talk(served[0], ['x' * 70_000]) is not None
    assert only(talk(served[0], []), 'hello')


def test_a_browser_that_takes_nothing_keeps_nobody_waiting(served):
    async def watch():
        async with (
            aiohttp.ClientSession() as session,
            session.ws_connect(f'{served[0]}socket') as lazy,
            session.ws_connect(f'{served[0]}socket') as quick,
        ):
            await lazy.send_str('{"do": "play"}')
            seen = 0
            async for got in quick:
                if got.type == aiohttp.WSMsgType.BINARY:
                    seen += 1
                    await quick.send_str('{"do": "shown"}')
                if seen == 20:
                    return

    asyncio.run(asyncio.wait_for(watch(), PATIENCE))


@pytest.mark.slow
def test_a_page_that_is_opened_a_hundred_times_leaves_nothing_behind(served):
    async def reload():
        async with aiohttp.ClientSession() as session:
            opened = 0
            while opened < 100:
                with contextlib.suppress(aiohttp.WSServerHandshakeError):
                    # refused while the ends of too many others are still being noticed
                    wire = await session.ws_connect(f'{served[0]}socket')
                    opened += 1
                    if opened % 2:
                        await wire.receive()
                    wire._response.close()  # as a browser that is killed

    def is_served():
        with contextlib.suppress(aiohttp.WSServerHandshakeError):
            return bool(only(talk(served[0], []), 'hello'))
        return False

    asyncio.run(asyncio.wait_for(reload(), PATIENCE))
    wait_until(is_served)
