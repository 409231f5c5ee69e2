"""``evaluate``: measures the quality of recorded tracks.

It compares them with the truth or with another run, or, with neither, judges them by themselves.
"""

import argparse
from collections.abc import Mapping
from collections.abc import Sequence
import json
from pathlib import Path
import sys
import threading
from typing import Any

import numpy as np
from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from colortrack_ros.batch import add_batch_options
from colortrack_ros.batch import BatchError
from colortrack_ros.batch import FilesParser
from colortrack_ros.batch import run_batch
from colortrack_ros.batch import run_here
from colortrack_ros.batch import workers_of
from colortrack_ros.evaluation.comparison import Event
from colortrack_ros.evaluation.report import page_of
from colortrack_ros.files import read_params_file
from colortrack_ros.files import write_file
from colortrack_ros.parameters.params_file import flow
from colortrack_ros.parameters.params_file import given_in
from colortrack_ros.tools.evaluation_task import add_match_options
from colortrack_ros.tools.evaluation_task import evaluation_task
from colortrack_ros.tools.evaluation_task import evaluation_tasks
from colortrack_ros.tools.evaluation_task import name_of
from colortrack_ros.tools.evaluation_task import recorded_in
from colortrack_ros.tools.health_of_bag import COUNTERS

OPTIONS = ('truth', 'pictures', 'radius', 'iou', 'visible', 'topic')
"""The options of the command line that a task needs."""

NODES_WITH_TRACKS = ('camera', 'detector', 'tracker', 'window_tracker', 'contour_tracker')
"""Nodes whose parameters affect the tracks."""

COUNTS = ('switches', 'fragments', 'misses', 'false', 'false_tracks', 'frames', 'tracks', 'gaps')

COUNTED_BY_NODES = tuple(name.replace(' ', '_') for name in COUNTERS)

COLUMNS_AT_MOST = 4
"""Up to this many runs have a column each; more runs have one line each, with only the measures in
SHORT. Assumed: more columns hardly fit a terminal."""

SHORT = (
    'hota', 'idf1', 'mota', 'recall', 'precision', 'switches', 'false_tracks', 'rmse', 'coverage',
    'frames', 'tracks', 'length', 'gaps', 'jumps', 'coasting', 'sigma', 'delay', 'lost',
)  # fmt: skip

Result = Mapping[str, Any]
"""The options of a task of ``evaluate``."""


def main(args: Sequence[str] | None = None) -> int:
    """Evaluate.

    :return: the exit status: 0; 1 if a file cannot be read or written; 2 if the arguments are
        wrong; 3 if a threshold is missed.
    """
    arguments = _parse(args)
    options = {name: getattr(arguments, name) for name in OPTIONS}
    inputs = recorded_in(arguments.tracks)
    tasks = evaluation_tasks(inputs, {**options, 'page': bool(arguments.html)})
    try:
        parameters = differing_parameters(inputs, arguments.params_file)
        workers = workers_of(arguments) or run_here
        outcomes = run_batch(
            evaluation_task, tasks, workers, threading.Event(), report=arguments.report
        )
        results = [outcome.result for outcome in outcomes if outcome.result]
        if arguments.json is not None:
            shown = [{k: v for k, v in r.items() if k != 'section'} for r in results]
            write_file(arguments.json, f'{json.dumps(shown, indent=1)}\n'.encode())
        if arguments.html is not None:
            write_file(arguments.html, _page(results, parameters).encode())
    except (BatchError, OSError, ValueError) as error:
        print(f'evaluate: {error}', file=sys.stderr)
        return 1
    _show(results, parameters)
    failures = [f'evaluate: {outcome.error}' for outcome in outcomes if outcome.error]
    missed = list(_missed(results, arguments.min, arguments.max))
    print(*failures, *missed, sep='\n', end='\n' if failures or missed else '', file=sys.stderr)
    return 1 if failures else 3 if missed else 0


def _show(results: Sequence[Result], parameters: Sequence[Sequence[str]]) -> None:
    console = Console()
    if results:
        console.print(table_of({result['run']: result['measures'] for result in results}))
    for result in results:
        if result.get('switches') and len(results) <= COLUMNS_AT_MOST:
            console.print(_switches_of(result))
        for note in result.get('notes', []):
            console.print(f'- {Path(result["run"]).name}: {note}', markup=False)
        for text, seconds in result.get('said', {}).items():
            console.print(f'- {Path(result["run"]).name}: {text} ({seconds} s)', markup=False)
    if parameters:
        table = Table(*parameters[0], title='parameters that differ')
        for line in parameters[1:]:
            table.add_row(*line)
        console.print(table)


def _page(results: Sequence[Result], parameters: Sequence[Sequence[str]]) -> str:
    table = {result['run']: result['measures'] for result in results}
    return page_of(table, [result['section'] for result in results], parameters)


def table_of(results: Mapping[str, Mapping[str, float]]) -> Table:
    """A table with one column for each run and one line for each measure, or, for many runs, one
    line for each run.
    """
    names = list(dict.fromkeys(name for measures in results.values() for name in measures))
    if len(results) <= COLUMNS_AT_MOST:
        table = Table()
        table.add_column()
        short = [Path(spec).name for spec in results]
        for spec, name in zip(results, short, strict=True):
            table.add_column(name if name and short.count(name) == 1 else spec, justify='right')
        for name in names:
            table.add_row(name, *(_text(name, some.get(name)) for some in results.values()))
        return table
    table = Table(box=SIMPLE, pad_edge=False, collapse_padding=True)
    names = [name for name in names if name in SHORT]
    for name in ('', *names):
        table.add_column(name, justify='right' if name else 'left')
    for spec, measures in {**results, 'all': _of_all(results)}.items():
        table.add_row(Path(spec).name, *(_text(name, measures.get(name)) for name in names))
    return table


def _of_all(results: Mapping[str, Mapping[str, float]]) -> dict[str, float]:
    """Sums of counts, and means of all other measures."""
    names = dict.fromkeys(name for measures in results.values() for name in measures)
    values = {
        name: [m[name] for m in results.values() if m.get(name) is not None] for name in names
    }
    return {n: float(np.sum(v) if n in COUNTS else np.nanmean(v)) for n, v in values.items()}


def _switches_of(result: Result) -> Table:
    """A table of the ID switches."""
    table = Table(title=f'switches of {Path(result["run"]).name}')
    for name in Event._fields:
        table.add_column(name, justify='right')
    for event in result['switches']:
        table.add_row(*(f'{value:.0f}' for value in event.values()))
    return table


def _text(name: str, value: float | None) -> str:
    if value is None:
        return ''
    is_count = name in COUNTS or name.partition('.')[2] in COUNTED_BY_NODES
    return f'{value:.0f}' if is_count else f'{value:.3f}'


def _parse(args: Sequence[str] | None) -> argparse.Namespace:
    parser = FilesParser('evaluate', description=__doc__)
    parser.add_argument(
        'tracks', nargs='+',
        help='a bag, a CSV of replay, or MOTChallenge (.txt); several, a folder of them, or @FILE '
        'with one a line',
    )  # fmt: skip
    parser.add_argument(
        '--truth', '--against', metavar='TRUTH',
        help='CSV with frame, id, u, v, [w, h, visible], MOTChallenge, scene:NAME, or another run; '
        '{} stands for the name of each recording',
    )  # fmt: skip
    add_match_options(parser)
    parser.add_argument('--topic', default='', help='of the tracks in a bag')
    parser.add_argument('--json', type=Path, help='a file for all figures')
    parser.add_argument('--html', type=Path, help='a page with timelines, that stands alone')
    parser.add_argument(
        '--pictures',
        metavar='SOURCE',
        help='bag, video, pictures or scene, {} as above: shows switches on the page',
    )
    parser.add_argument(
        '--params-file', type=Path, action='append', default=[], metavar='YAML',
        help='of each run, in their order: shows the parameters that differ',
    )  # fmt: skip
    for name, text in (('min', 'at least'), ('max', 'at most')):
        parser.add_argument(
            f'--{name}', action='append', default=[], type=_threshold, metavar='NAME=VALUE',
            help=f'exit status 3 unless this measure is {text} this, such as idf1=0.95',
        )  # fmt: skip
    add_batch_options(parser)
    return parser.parse_args(args)


def _threshold(text: str) -> tuple[str, float]:
    name, _, value = text.partition('=')
    try:
        return name, float(value)
    except ValueError:
        raise argparse.ArgumentTypeError(f'expected NAME=NUMBER, got {text!r}') from None


def differing_parameters(runs: Sequence[str], files: Sequence[Path]) -> list[list[str]]:
    """Names of the parameters that differ between the runs' files, with their values.

    :return: the names of the runs, then a line for each parameter; empty if none differs.
    :raises ValueError: the numbers of runs and files differ, or one is not a params file.
    """
    if len(files) not in (0, len(runs)):
        raise ValueError(f'--params-file: expected {len(runs)}, one for each run; got {len(files)}')
    given = [
        {
            f'{node} {name}': flow(value)
            for node in NODES_WITH_TRACKS
            for name, value in given_in(read_params_file(path), node).items()
        }
        for path in files
    ]
    names = sorted({name for values in given for name in values})
    lines = [[name, *(values.get(name, '') for values in given)] for name in names]
    lines = [line for line in lines if len(set(line[1:])) > 1]
    return [['', *map(name_of, runs)], *lines] if lines else []


def _missed(
    results: Sequence[Result],
    least: Sequence[tuple[str, float]],
    most: Sequence[tuple[str, float]],
) -> Sequence[str]:
    """One line for each threshold that a run misses; a missing measure counts as a miss."""
    bounds = [(name, bound, 1, 'least') for name, bound in least]
    bounds += [(name, bound, -1, 'most') for name, bound in most]
    return [
        f'{spec}: {name} is {_said(measures, name)}, expected at {which} {bound:g}'
        for spec, measures in ((result['run'], result['measures']) for result in results)
        for name, bound, sign, which in bounds
        if not sign * measures.get(name, float('nan')) >= sign * bound
    ]


def _said(measures: Mapping[str, float], name: str) -> str:
    return f'{measures[name]:.4g}' if name in measures else f'not known ({", ".join(measures)})'
