"""An MJPEG stream of 25 frames a second, as network cameras have."""

import http.server
from pathlib import Path
import socket
import subprocess
import sys
import time

import cv2
from support.waiting import wait_until

from colortrack_ros.scenes import open_scene

SCENE = open_scene('five?width=320&height=240')


class Stream(http.server.BaseHTTPRequestHandler):
    """Sends the scene for as long as somebody reads it."""

    def do_GET(self):
        self.send_response(200)
        self.send_header('Content-Type', 'multipart/x-mixed-replace; boundary=next')
        self.end_headers()
        try:
            for k in range(100_000):
                jpeg = cv2.imencode('.jpg', SCENE.render(k % len(SCENE)))[1].tobytes()
                head = f'--next\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n\r\n'
                self.wfile.write(head.encode() + jpeg + b'\r\n')
                time.sleep(0.04)
        except OSError:
            pass

    def log_message(self, *_):
        pass


def serve(port: int) -> subprocess.Popen:
    """The stream from a process of its own, so that killing it cuts the connections; it is up."""
    server = subprocess.Popen(
        [sys.executable, '-m', 'support.mjpeg', str(port)], cwd=Path(__file__).parents[1]
    )
    wait_until(lambda: is_up(port), what=lambda: 'the stream')
    return server


def is_up(port: int) -> bool:
    """Whether somebody takes connections there: a camera that is refused one ends."""
    with socket.socket() as knocking:
        return knocking.connect_ex(('127.0.0.1', port)) == 0


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(('127.0.0.1', 0))
        return listener.getsockname()[1]


if __name__ == '__main__':
    http.server.ThreadingHTTPServer(('127.0.0.1', int(sys.argv[1])), Stream).serve_forever()
