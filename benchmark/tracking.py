"""The tracker beside others from PyPI, on the same detections.

python benchmark/tracking.py prints the table and writes out/bench.json. One core: set
OMP_NUM_THREADS=1 and OPENBLAS_NUM_THREADS=1, as is done here before NumPy is loaded.
"""

import os

os.environ['OMP_NUM_THREADS'] = '1'
os.environ['OPENBLAS_NUM_THREADS'] = '1'

import argparse
import json
import math
from pathlib import Path
import statistics
import sys
import time
import tracemalloc

import numpy as np
from peers import PEERS
from points import cruise
from points import JUGGLING
from points import labels
from points import of_scene
from rich.console import Console
from rich.progress import track
from rich.table import Table

sys.path.insert(0, str(Path(__file__).parents[1] / 'test'))

from colortrack_ros.evaluation import Tally
from colortrack_ros.scenes import BLACKOUT
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

ROOT = Path(__file__).parents[1]
OUT = ROOT / 'out' / 'bench.json'
SLOW = 1000
"""With more objects than that the tracker runs alone."""


class Ours:
    """The tracker of this package, with centroids alone, or with all that comes with them.

    :param whole: use the boxes and covariances of the detections as well.
    """

    def __init__(self, whole):
        self.whole, self.name = whole, 'colortrack_ros, boxes' if whole else 'colortrack_ros'

    def play(self, sequence):
        """Time and rows of each frame."""
        tracker = Tracker(
            TrackerConfig(
                image_size=sequence.size, use_boxes=self.whole, detection_covariance=self.whole
            )
        )
        for detections in sequence.detections:
            start = time.perf_counter()
            rows = tracker.update(detections).rows
            took = time.perf_counter() - start
            rows = rows[rows['state'] > 0]
            yield took, np.stack([rows['track_id'], rows['u'], rows['v']], axis=1)


class Theirs:
    """A tracker from PyPI, always with centroids alone."""

    def __init__(self, peer):
        self.peer, self.name = peer, peer.name

    def play(self, sequence):
        """Time and rows of each frame."""
        tracker = self.peer(sequence.step)
        for detections in sequence.detections:
            z = np.stack([detections.rows['u'], detections.rows['v']], axis=1)
            start = time.perf_counter()
            rows = tracker.update(z)
            yield time.perf_counter() - start, rows


def sequences():
    """Names and what makes them; juggling only where its data is."""
    found = {f'cruise, {n}': (lambda n=n: [cruise(n)]) for n in (50, 200, 1000, 10_000)}
    found['turns, 50'] = lambda: [cruise(50, turns=0.02)]
    found['blackout, 50'] = lambda: [
        cruise(50, speed=(4.0, 12.0), detected=0.85, clutter=0.2, blackout=0.02)
    ]
    for name in ('collision', 'swarm', 'juggle', 'turns', 'flicker'):
        found[f'scene:{name}'] = lambda name=name: [of_scene(name)]
    found['scene:blackout'] = lambda: [of_scene('blackout', **BLACKOUT)]
    if JUGGLING.is_dir():
        files = sorted(JUGGLING.glob('*.csv'))
        found['juggling, all'] = lambda: [labels(f) for f in files]
        found['juggling, 90 %'] = lambda: [labels(f, drop=0.1) for f in files]
    return found


def measure(player, several):
    """Median time, ID switches, IDF1 and RMSE; over several sequences sums and means."""
    times, scores = [], []
    for sequence in several:
        tally = Tally(sequence.max_distance)
        for truth, hidden, (took, rows) in zip(
            sequence.truth, sequence.hidden, player.play(sequence), strict=True
        ):
            times.append(took)
            tally.add(truth, rows, hidden)
        scores.append(tally.score())
    return {
        'tracker': player.name,
        'ms': 1e3 * statistics.median(times),
        'switches': sum(score.switches for score in scores),
        'idf1': 100 * statistics.mean(score.idf1 for score in scores),
        'rmse': statistics.mean(score.rmse for score in scores),
    }


def show(results):
    table = Table('detections', 'tracker', title='Trackers, one core')
    for column in ('ms a frame', 'ID switches', 'IDF1 %', 'RMSE px'):
        table.add_column(column, justify='right')
    for name, lines in results.items():
        for i, line in enumerate(lines):
            numbers = [f'{line["ms"]:.2f}', str(line['switches'])]
            numbers += [f'{line["idf1"]:.1f}', f'{line["rmse"]:.2f}']
            last = i == len(lines) - 1
            table.add_row('' if i else name, line['tracker'], *numbers, end_section=last)
    Console(width=110).print(table)


def memory(count=10_000):
    """Bytes that a track keeps from frame to frame."""
    sequence = cruise(count, frames=5, clutter=0.0, detected=1.0)
    tracemalloc.start()
    player = Ours(whole=False).play(sequence)
    kept = [(tracemalloc.get_traced_memory()[0], len(rows)) for _, rows in player][-1]
    tracemalloc.stop()
    return kept[0] / kept[1]


def summarize(results):
    """What the numbers of the whole table come to."""
    fast = {n: results[f'cruise, {n}'][0]['ms'] for n in (1000, 10_000)}
    peers = {line['tracker']: line['ms'] for line in results['cruise, 1000'][1:]}
    peer = min((name for name in peers if 'linking' not in name), key=peers.get)
    return {
        'exponent of the time from 1,000 to 10,000 objects': math.log10(fast[10_000] / fast[1000]),
        f'times faster than {peer} at 1,000 objects': peers[peer] / fast[1000],
        'bytes a track': memory(),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('names', nargs='*', metavar='NAME')
    chosen = parser.parse_args().names
    results = {}
    for name, make in track(sequences().items(), description='tracking'):
        if chosen and not any(part in name for part in chosen):
            continue
        several = make()
        players = [Ours(whole=False)]
        if name.startswith('scene'):
            players.append(Ours(whole=True))
        if max(len(rows) for rows in several[0].truth) <= SLOW:
            players += [Theirs(peer) for peer in PEERS]
        results[name] = [measure(player, several) for player in players]
    show(results)
    if not chosen:
        results['summary'] = summarize(results)
        for name, number in results['summary'].items():
            print(f'{name}: {number:.2f}')
    OUT.parent.mkdir(exist_ok=True)
    OUT.write_text(json.dumps(results, indent=1))


if __name__ == '__main__':
    main()
