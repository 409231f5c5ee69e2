"""Every number that is claimed of the tracker on detections that others made, in one table.

python benchmark/worlds [NAME...] [--seeds N] [--json FILE] [--peers]

NAME is the number of a point or a part of a world's name. --peers asks for what
benchmark/requirements.txt installs. One core, as in benchmark/tracking.py.
"""

import os

os.environ['OMP_NUM_THREADS'] = '1'
os.environ['OPENBLAS_NUM_THREADS'] = '1'

import argparse
import json
import math
from pathlib import Path
import sys
import time

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[2] / 'test'))

from rich.console import Console
from rich.progress import track
from rich.table import Table

from worlds.report import choose
from worlds.report import measure
from worlds.report import text
from worlds.report import WORLDS
from worlds.rivals import rivals


def main():
    parser = argparse.ArgumentParser('worlds', description=__doc__)
    parser.add_argument('names', nargs='*', metavar='NAME')
    parser.add_argument('--seeds', type=int, default=3)
    parser.add_argument('--json', type=Path)
    parser.add_argument('--peers', action='store_true')
    arguments = parser.parse_args()
    try:
        chosen = choose(arguments.names)
    except ValueError as error:
        parser.error(str(error))
    others, results = rivals(arguments.peers), {}
    table = Table('world', 'figure', title=f'Worlds, mean of {arguments.seeds} seeds')
    for column in ('before', 'now', 'textbook, best peer', 'to reach', ''):
        table.add_column(column, justify='right')
    for name in track(chosen, description='worlds', console=Console(stderr=True)):
        start = time.perf_counter()
        lines = measure(WORLDS[name], range(arguments.seeds), others)
        results[name] = [vars(line) for line in lines]
        for i, line in enumerate(lines):
            table.add_row(
                '' if i else name, line.what, *text(line), end_section=i == len(lines) - 1
            )
        print(f'{name}: {time.perf_counter() - start:.0f} s', file=sys.stderr)
    Console(width=150).print(table)
    if arguments.json:
        finite = {name: [plain(line) for line in lines] for name, lines in results.items()}
        arguments.json.write_text(json.dumps(finite, indent=1) + '\n')


def plain(line):
    """What JSON has no number for is left out."""
    return {k: v for k, v in line.items() if isinstance(v, str) or math.isfinite(v)}


if __name__ == '__main__':
    main()
