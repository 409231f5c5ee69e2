"""Process noise that is learned beside fixed values, on juggled balls.

python benchmark/process_noise.py prints the table and writes out/process_noise.json.
"""

import argparse
import json
from pathlib import Path
import statistics
import sys

from points import JUGGLING
from points import labels
from rich.console import Console
from rich.progress import track
from rich.table import Table

sys.path.insert(0, str(Path(__file__).parents[1] / 'test'))

from colortrack_ros.evaluation import Tally
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

OUT = Path(__file__).parents[1] / 'out' / 'process_noise.json'
FIXED = (100.0, 300.0, 1000.0, 3000.0, 10_000.0, 30_000.0)
DROPPED = {0.0: (0,), 0.1: (0, 1, 2)}
"""Shares of the detections that are left out, and the seeds of that."""


def idf1(sequence, process_noise):
    config = TrackerConfig(process_noise=process_noise, image_size=sequence.size)
    tracker, tally = Tracker(config), Tally(sequence.max_distance)
    for truth, detections in zip(sequence.truth, sequence.detections, strict=True):
        rows = tracker.update(detections).rows
        rows = rows[rows['state'] > 0]
        tally.add(truth, [(row['track_id'], row['u'], row['v']) for row in rows])
    return 100 * tally.score().idf1


def main():
    if not JUGGLING.is_dir():
        print(f'no {JUGGLING}: process noise is not measured; set COLORTRACK_DATA')
        return
    files = sorted(JUGGLING.glob('*.csv'))
    table = Table('process noise [px/s^2]', title='IDF1 % on juggled balls, mean of 8 sequences')
    for drop in DROPPED:
        table.add_column(f'{100 * drop:.0f} % dropped', justify='right')
    results = {}
    for noise in track((0.0, *FIXED), description='process noise'):
        means = [
            statistics.mean(
                idf1(labels(file, drop, seed), noise) for file in files for seed in seeds
            )
            for drop, seeds in DROPPED.items()
        ]
        name = f'{noise:g}' if noise else 'learned'
        results[name] = means
        table.add_row(name, *(f'{mean:.1f}' for mean in means))
    Console(width=100).print(table)
    OUT.parent.mkdir(exist_ok=True)
    OUT.write_text(json.dumps(results, indent=1))


if __name__ == '__main__':
    argparse.ArgumentParser(description=__doc__).parse_args()
    main()
