"""What ``replay`` of many recordings costs beyond the work, and whether its bytes are the same.

``python benchmark/many_recordings.py [COUNT]``, 100 by default: short videos of scenes, one after
the other in one process, as a command each (the first three), and in batches.
"""

import argparse
import contextlib
import json
import os
from pathlib import Path
import subprocess
import sys
import tempfile
import threading
import time

import cv2

from colortrack_ros.replay.command import replay
from colortrack_ros.scenes import open_scene

SIZE, RATE, SECONDS, COMMANDS = (320, 240), 15, 4, 3
COMMAND = 'from colortrack_ros.replay.main import main; raise SystemExit(main())'


def write_video(path: Path, seed: int) -> None:
    options = f'width={SIZE[0]}&height={SIZE[1]}&rate={RATE}&duration={SECONDS}&seed={seed}'
    scene = open_scene(f'five?{options}')
    video = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*'mp4v'), RATE, SIZE)
    for k in range(len(scene)):
        video.write(scene.render(k))
    video.release()


def files(folder: Path) -> dict[str, bytes]:
    paths = (path for path in folder.rglob('*') if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


def measured(count: int, root: Path) -> dict[str, float]:
    """Seconds a recording."""
    for folder in ('in', 'one', 'command', 'jobs1', 'jobs2'):
        (root / folder).mkdir()
    names = [f'run{k:03d}' for k in range(count)]
    for k, name in enumerate(names):
        write_video(root / 'in' / f'{name}.mp4', k)
    stop, times = threading.Event(), {}
    begin = time.perf_counter()
    for name in names:
        assert replay([f'{root}/in/{name}.mp4', '--output', f'{root}/one/{name}'], stop) == 0
    times['one after the other in one process'] = (time.perf_counter() - begin) / count
    begin = time.perf_counter()
    for name in names[:COMMANDS]:
        options = [f'{root}/in/{name}.mp4', '--output', f'{root}/command/{name}']
        subprocess.run([sys.executable, '-c', COMMAND, *options], check=True, capture_output=True)
    times['a command each'] = (time.perf_counter() - begin) / len(names[:COMMANDS])
    for jobs in ('1', '2'):
        report = root / f'report{jobs}'
        options = ['--output', f'{root}/jobs{jobs}/{{}}', '--jobs', jobs, '--report', str(report)]
        begin = time.perf_counter()
        assert replay([f'{root}/in', *options], stop) == 0
        times[f'--jobs {jobs}'] = (time.perf_counter() - begin) / count
        assert files(root / f'jobs{jobs}') == files(root / 'one'), 'other bytes'
        lines = map(json.loads, report.read_text().splitlines())
        work = sum(line['result']['seconds'] for line in lines) / count
        times[f'... of which each worker tracks and writes, --jobs {jobs}'] = work / int(jobs)
    return times


def main(count: int) -> None:
    with tempfile.TemporaryDirectory() as name, contextlib.redirect_stdout(open(os.devnull, 'w')):
        times = measured(count, Path(name))
    print(f'| {count} recordings of {RATE * SECONDS} pictures, the same bytes | s a recording |')
    print('|---|---|')
    for what, seconds in times.items():
        print(f'| {what} | {seconds:.2f} |')


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('count', nargs='?', type=int, default=100)
    main(**vars(parser.parse_args()))
