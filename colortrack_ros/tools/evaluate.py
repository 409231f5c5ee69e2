"""``evaluate``: how good recorded tracks are.

Against the truth, against another run, or, with neither, by what they tell of themselves.
"""

import argparse
from collections.abc import Mapping
from collections.abc import Sequence
import json
from pathlib import Path
import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from colortrack_ros.bags.reader import is_bag
from colortrack_ros.encodings import writable_bgr
from colortrack_ros.evaluation import compare
from colortrack_ros.evaluation import Comparison
from colortrack_ros.evaluation import read_record
from colortrack_ros.evaluation import Record
from colortrack_ros.evaluation import record_of_scene
from colortrack_ros.evaluation import RecordError
from colortrack_ros.evaluation import statistics
from colortrack_ros.evaluation.comparison import Event
from colortrack_ros.evaluation.report import html_of
from colortrack_ros.evaluation.report import picture_of
from colortrack_ros.evaluation.report import Run
from colortrack_ros.scenes import open_scene
from colortrack_ros.sources import open_source
from colortrack_ros.sources import SourceError
from colortrack_ros.sources.scene import SCENE_PREFIX
from colortrack_ros.tools.tracks_of_bag import tracks_of_bag

COUNTS = ('switches', 'fragments', 'misses', 'false', 'false_tracks', 'frames', 'tracks', 'gaps')


def main(args: Sequence[str] | None = None) -> int:
    """Evaluate.

    :return: the exit status: 0; 1 if a file cannot be read or written; 2 if the arguments are
        wrong; 3 if a threshold is missed.
    """
    arguments = _parse(args)
    try:
        runs = _runs(arguments)
        if arguments.json is not None:
            arguments.json.write_text(json.dumps([_content(r) for r in runs], indent=1) + '\n')
        if arguments.html is not None:
            arguments.html.write_text(html_of(runs), encoding='utf-8')
    except (RecordError, SourceError, OSError) as error:
        print(f'evaluate: {error}', file=sys.stderr)
        return 1
    results = {run.name: run.measures for run in runs}
    console = Console()
    console.print(table_of(results))
    for run in runs:
        if run.comparison is not None and run.comparison.switches:
            console.print(switches_of(run.name, run.comparison))
    missed = list(_missed(results, arguments.min, arguments.max))
    print(*missed, sep='\n', end='\n' if missed else '', file=sys.stderr)
    return 3 if missed else 0


def table_of(results: Mapping[str, Mapping[str, float]]) -> Table:
    """One column a run, one line a measure."""
    table = Table()
    table.add_column()
    for spec in results:
        table.add_column(Path(spec).name or spec, justify='right')
    for name in dict.fromkeys(name for measures in results.values() for name in measures):
        table.add_row(name, *(_text(name, measures.get(name)) for measures in results.values()))
    return table


def switches_of(spec: str, detail: Comparison) -> Table:
    """Where objects were taken over by other tracks."""
    table = Table(title=f'switches of {Path(spec).name}')
    for name in ('frame', 'object', 'before', 'after', 'u', 'v'):
        table.add_column(name, justify='right')
    for event in detail.switches:
        table.add_row(*(f'{value:.0f}' for value in event))
    return table


def _text(name: str, value: float | None) -> str:
    if value is None:
        return ''
    return f'{value:.0f}' if name in COUNTS else f'{value:.3f}'


def _parse(args: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog='evaluate', description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument(
        'tracks', nargs='+', help='a bag, a CSV of replay, or MOTChallenge (.txt); several: runs'
    )
    parser.add_argument(
        '--truth', '--against', metavar='TRUTH',
        help='CSV with frame, id, u, v, [w, h, visible], MOTChallenge, scene:NAME, or another run',
    )  # fmt: skip
    parser.add_argument(
        '--radius', type=_positive, default=0.0, help='a match is no farther away [px]'
    )
    parser.add_argument(
        '--iou', type=_positive, default=0.5, help='or, without --radius, its boxes overlap by it'
    )
    parser.add_argument(
        '--visible', type=float, default=0.3, help='share in sight from which on objects count'
    )
    parser.add_argument('--topic', default='', help='of the tracks in a bag')
    parser.add_argument('--json', type=Path, help='a file for all figures')
    parser.add_argument('--html', type=Path, help='a page with timelines, that stands alone')
    parser.add_argument(
        '--pictures', metavar='SOURCE', help='video, pictures or scene: shows switches on the page'
    )
    for name, text in (('min', 'at least'), ('max', 'at most')):
        parser.add_argument(
            f'--{name}', action='append', default=[], type=_threshold, metavar='NAME=VALUE',
            help=f'exit status 3 unless this measure is {text} this, such as idf1=0.95',
        )  # fmt: skip
    return parser.parse_args(args)


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < float('inf'):
        raise argparse.ArgumentTypeError(f'expected a positive number, got {text!r}')
    return value


def _threshold(text: str) -> tuple[str, float]:
    name, _, value = text.partition('=')
    try:
        return name, float(value)
    except ValueError:
        raise argparse.ArgumentTypeError(f'expected NAME=NUMBER, got {text!r}') from None


def _read(spec: str, topic: str) -> Record:
    """Tracks or truth of a bag, a table or a scene.

    :raises RecordError: it is none, or cannot be read.
    """
    if spec.startswith(SCENE_PREFIX):
        try:
            return record_of_scene(open_scene(spec.removeprefix(SCENE_PREFIX)))
        except ValueError as error:
            raise RecordError(f'{spec}: {error}') from error
    path = Path(spec)
    return tracks_of_bag(path, topic) if is_bag(path) else read_record(path)


def _runs(arguments: argparse.Namespace) -> list[Run]:
    """Each of the runs, compared."""
    truth = _read(arguments.truth, arguments.topic) if arguments.truth else None
    runs = []
    for spec in arguments.tracks:
        tracks = _read(spec, arguments.topic)
        if truth is None:
            runs.append(Run(spec, statistics(tracks), tracks, None, {}))
            continue
        options = {name: getattr(arguments, name) for name in ('radius', 'iou', 'visible')}
        result = compare(truth, tracks, **options)
        pictures = {}
        if arguments.html is not None and arguments.pictures:
            pictures = _pictures(arguments.pictures, result.switches)
        runs.append(Run(spec, result.measures, tracks, result, pictures))
    return runs


def _pictures(source: str, switches: Sequence[Event]) -> dict[Event, NDArray[np.uint8]]:
    """The surroundings of each switch in a video, pictures or a scene.

    :raises SourceError: it cannot be opened.
    """
    wanted: dict[int, list[Event]] = {}
    for event in switches:
        wanted.setdefault(event.frame, []).append(event)
    found: dict[Event, NDArray[np.uint8]] = {}
    frames = open_source(source)
    try:
        for number in range(max(wanted, default=-1) + 1):
            frame = frames.read()
            if frame is None:
                break
            for event in wanted.get(number, []):
                found[event] = picture_of(event, writable_bgr(frame))
    finally:
        frames.close()
    return found


def _content(run: Run) -> dict[str, Any]:
    """What the JSON holds of a run."""
    detail = run.comparison
    switches = [] if detail is None else [event._asdict() for event in detail.switches]
    objects = {} if detail is None else detail.objects
    return {'run': run.name, 'measures': run.measures, 'objects': objects, 'switches': switches}


def _missed(
    results: Mapping[str, Mapping[str, float]],
    least: Sequence[tuple[str, float]],
    most: Sequence[tuple[str, float]],
) -> Sequence[str]:
    """One line for each threshold that a run misses; a measure that there is not misses it too."""
    bounds = [(name, bound, 1, 'least') for name, bound in least]
    bounds += [(name, bound, -1, 'most') for name, bound in most]
    return [
        f'{spec}: {name} is {_said(measures, name)}, expected at {which} {bound:g}'
        for spec, measures in results.items()
        for name, bound, sign, which in bounds
        if not sign * measures.get(name, float('nan')) >= sign * bound
    ]


def _said(measures: Mapping[str, float], name: str) -> str:
    return f'{measures[name]:.4g}' if name in measures else f'not known ({", ".join(measures)})'
