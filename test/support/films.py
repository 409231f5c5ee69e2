"""Films in the formats that strangers bring, written by ffmpeg or byte by byte."""

import shutil
import subprocess

import pytest
from support.damaged import numbered

from colortrack_ros.sources import open_source
from colortrack_ros.sources import SourceError

COUNT, RATE = 100, 25

needs_ffmpeg = pytest.mark.skipif(not shutil.which('ffmpeg'), reason='needs the program ffmpeg')

H264 = '-c:v libx264 -preset ultrafast -g 25 -pix_fmt yuv420p'


def encode(path, options=H264, sound=0.0, count=COUNT, late=0):
    """A film of pictures that carry their number, with some seconds of sound.

    :param late: how much later than the sound they begin [s].
    """
    noise = f'-f lavfi -t {sound} -i anoisesrc=a=0.1'.split() if sound else []
    pictures = f'-f rawvideo -pix_fmt bgr24 -s 160x96 -r {RATE} -i -'.split()
    if late:
        options += f' -vf setpts=PTS+{late}/TB -vsync vfr'
    subprocess.run(
        ['ffmpeg', '-v', 'error', '-y', *pictures, *noise, *options.split(), str(path)],
        input=b''.join(numbered(k).tobytes() for k in range(count)),
        check=True,
        timeout=60,
    )
    return path


def copied(path, source, before='', after=''):
    """A film with the same pictures in another container, or from another time on."""
    command = f'ffmpeg -v error -y {before} -i {source} -c copy {after} {path}'
    subprocess.run(command.split(), check=True, timeout=60)
    return path


def overwritten(path, first, last, rng):
    """The film with random bytes between two shares of its length."""
    content = bytearray(path.read_bytes())
    a, b = int(first * len(content)), int(last * len(content))
    content[a:b] = rng.bytes(b - a)
    path.write_bytes(content)
    return path


def watch(path):
    """All frames of a film, what was told, and the source, which has ended."""
    source = open_source(str(path))
    frames, told = [], []
    while True:
        try:
            frame = source.read()
        except SourceError as error:
            told.append(str(error))
            continue
        if frame is None:
            return frames, told, source
        frames.append(frame)
