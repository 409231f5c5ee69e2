from concurrent.futures import ThreadPoolExecutor
from http.server import BaseHTTPRequestHandler
from http.server import ThreadingHTTPServer
import itertools
import socket
import threading

import cv2
import numpy as np
import pytest
from support.waiting import PATIENCE

from colortrack_ros.sources import open_source
from colortrack_ros.sources import SourceError
from colortrack_ros.sources import stream
from colortrack_ros.sources.capture import LiveCapture


class Mjpeg(BaseHTTPRequestHandler):
    """Sends 40 JPEG pictures, ever brighter, as network cameras do; `/stall` then waits."""

    stalled = threading.Event()

    def do_GET(self):
        self.send_response(200)
        self.send_header('Content-Type', 'multipart/x-mixed-replace; boundary=frame')
        self.end_headers()
        for k in range(40):
            jpeg = cv2.imencode('.jpg', np.full((48, 64, 3), 5 * k, np.uint8))[1].tobytes()
            head = f'--frame\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n\r\n'
            self.wfile.write(head.encode() + jpeg + b'\r\n')
        if self.path == '/stall':
            self.stalled.wait(2 * PATIENCE)

    def log_message(self, *_):
        """Say nothing."""


@pytest.fixture
def server():
    server = ThreadingHTTPServer(('127.0.0.1', 0), Mjpeg)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f'127.0.0.1:{server.server_port}'
    server.shutdown()
    server.server_close()


class FakeCapture:
    """A capture that tells the order of the calls."""

    def __init__(self, calls, frames):
        self.calls, self.frames = calls, frames

    def grab(self):
        self.calls.append('grab')
        return self.frames > 0

    def retrieve(self):
        self.calls.append('retrieve')
        self.frames -= 1
        return True, np.zeros((2, 2, 3), np.uint8)


class FakeCamera(LiveCapture):
    @staticmethod
    def accepts(spec):
        return False


def test_a_live_frame_has_the_time_between_grab_and_decoding():
    calls = []
    source = FakeCamera(FakeCapture(calls, 1), 'camera', lambda: calls.append('clock') or 1234)
    assert source.read().stamp == 1234
    assert calls == ['grab', 'clock', 'retrieve']
    assert (source.live, source.period) == (True, 0)
    with pytest.raises(SourceError, match='camera has stopped'):
        source.read()


def test_a_stream_is_read_until_it_breaks_off(server, capfd):
    ticks = itertools.count(100)
    source = open_source(f'http://joe:secret@{server}/stream.mjpg', clock=lambda: next(ticks))
    frames = [source.read() for _ in range(30)]
    assert [frame.stamp for frame in frames] == list(range(100, 130))
    levels = [int(np.median(frame.image)) for frame in frames]
    assert levels == sorted(set(levels))
    assert frames[0].image.shape == (48, 64, 3)
    with pytest.raises(SourceError, match=r'joe:\*\*\*@') as caught:
        list(iter(source.read, None))
    assert 'secret' not in str(caught.value)
    source.close()
    assert capfd.readouterr() == ('', '')


@pytest.mark.slow
def test_a_stream_that_stalls_fails_in_time(server, monkeypatch):
    monkeypatch.setattr(stream, 'TIMEOUT_MS', 2000)
    source = open_source(f'http://{server}/stall')
    with ThreadPoolExecutor() as pool:
        error = pool.submit(list, iter(source.read, None)).exception(timeout=PATIENCE)
        Mjpeg.stalled.set()
    assert isinstance(error, SourceError)


@pytest.mark.parametrize('scheme', ['http', 'rtsp'])
def test_an_address_that_never_answers_fails_in_time_and_keeps_the_password(
    scheme, monkeypatch, capfd
):
    monkeypatch.setattr(stream, 'TIMEOUT_MS', 300)
    with socket.create_server(('127.0.0.1', 0)) as silent:
        address = f'127.0.0.1:{silent.getsockname()[1]}'
        spec = f'{scheme}://joe:se@cret@{address}/live?key=hidden'
        with ThreadPoolExecutor() as pool:
            error = pool.submit(open_source, spec).exception(timeout=PATIENCE)
    message = str(error)
    assert isinstance(error, SourceError)
    assert f'{scheme}://joe:***@{address}/live?***' in message
    assert '0.3 s' in message
    assert '\n' not in message
    assert capfd.readouterr() == ('', '')


@pytest.mark.parametrize(
    ('address', 'shown'),
    [
        ('rtsp://h/1', 'rtsp://h/1'),
        ('rtsp://joe@h/1', 'rtsp://joe@h/1'),
        ('rtsp://joe:pw@h:554/1', 'rtsp://joe:***@h:554/1'),
        ('http://:pw@h/', 'http://:***@h/'),
        ('rtsp://joe:p@s/w@h/1', 'rtsp://joe:***@h/1'),
        ('http://h:80/a?user=joe&pwd=x', 'http://h:80/a?***'),
        ('http://h:80/a@b', 'http://h:***@b'),
        ('scene:five?rate=60', 'scene:five?rate=60'),
    ],
)
def test_secrets_are_masked(address, shown):
    assert stream.without_secrets(address) == shown
