"""``replay`` over many recordings: each is a task, and all results are in one table."""

import argparse
from collections import Counter
from collections.abc import Mapping
from collections.abc import Sequence
from functools import partial
from importlib.metadata import version
import os
from pathlib import Path
import re
import threading
from typing import Any

from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from colortrack_ros.bags import BagError
from colortrack_ros.bags import BagWriteError
from colortrack_ros.bags import is_bag
from colortrack_ros.batch import key_of
from colortrack_ros.batch import Outcome
from colortrack_ros.batch import run_batch
from colortrack_ros.batch import run_local
from colortrack_ros.batch import Task
from colortrack_ros.batch import TaskError
from colortrack_ros.batch import workers_of
from colortrack_ros.node_kit.runtime import StartError
from colortrack_ros.replay.expected import versions
from colortrack_ros.replay.run import default_output
from colortrack_ros.replay.run import replay_recording
from colortrack_ros.replay.run import Stopped
from colortrack_ros.replay.setup import read_setup
from colortrack_ros.replay.targets import PREFIX

FAILURES = (StartError, BagError, BagWriteError, OSError)
"""Errors that end the replay of a recording, reported in one line."""

OUTPUTS = ('output', 'csv', 'mot', 'video')
NAMED = (*OUTPUTS, 'expect')
"""Options whose value differs between recordings."""

COLUMNS_OF_TABLE = {
    'frames': 'frames',
    'detections': 'found',
    'tracks': 'tracks',
    'speed': 'Hz',
    'refused': 'refused',
    'dropped': 'late',
    'restarts': 'restarts',
    'warnings': 'warned',
}
"""The columns of the table and their titles: nine fit a terminal of 80 characters."""


def reason_of(error: Exception) -> str:
    """The error in one line."""
    if isinstance(error, BagWriteError):
        return f'the bag {error}'
    if isinstance(error, OSError):
        name = re.sub(rf'{re.escape(PREFIX)}[^/]*/', '', str(error.filename or 'output'))
        return f'{name}: {error.strerror}'
    return str(error)


def replay_many(arguments: argparse.Namespace, inputs: Sequence[str], stop: threading.Event) -> int:
    """Replay all recordings, each in a process of its own.

    :return: the exit status: 1 if one failed or the batch was stopped.
    :raises StartError: two of them would be written to the same place.
    :raises BatchError: the report cannot be written, or there are no workers.
    """
    read_setup(arguments, from_bag=is_bag(Path(inputs[0])))  # refuses early
    tasks = _tasks(arguments, inputs)
    outcomes = run_batch(
        replay_task,
        tasks,
        workers_of(arguments) or partial(run_local, jobs=1),
        stop,
        report=arguments.report,
        fresh=arguments.force,
        refuse=lambda task: '' if arguments.force else _refused(task),
    )
    console = Console()
    console.print(_table(outcomes))
    for outcome in outcomes:
        if outcome.error:
            console.print(f'{outcome.task.name}: {outcome.error}', markup=False, soft_wrap=True)
    if len(outcomes) < len(tasks):
        goes_on = f'; the same command goes on from {arguments.report}' if arguments.report else ''
        console.print(f'stopped: {len(outcomes)} of {len(tasks)} are done{goes_on}')
        return 1
    return int(any(outcome.error for outcome in outcomes))


def replay_task(given: dict[str, Any], stop: threading.Event) -> tuple[dict[str, Any] | None, str]:
    """Replay one recording; see Work."""
    try:
        result = replay_recording(argparse.Namespace(**given), stop, given['task'])
    except Stopped:
        return None, 'stopped'
    except FAILURES as error:
        raise TaskError(reason_of(error)) from error
    recording, tally = result.recording, result.answers
    counts = {
        'input': given['input'],
        'output': str(result.output),
        'frames': tally.frames,
        'detections': tally.detections,
        'tracks': len(tally.tracks),
        'seconds': round(result.seconds, 3),
        'refused': recording.refused,
        'refusal': recording.reason,
        'dropped': recording.late,
        'restarts': len(tally.restarts),
        'warnings': len(tally.warnings),
        'warning': tally.warnings[-1] if tally.warnings else '',
    }
    wrong = result.error or result.differences
    return counts, wrong or ('' if tally.frames else 'no frame could be read')


def _tasks(arguments: argparse.Namespace, inputs: Sequence[str]) -> list[Task]:
    given = vars(arguments)
    common = {k: v for k, v in given.items() if k not in ('inputs', 'jobs', 'scheduler', 'report')}
    common['force'] = True  # files that must not be overwritten are refused before the task begins
    tasks = []
    for one in inputs:
        name, own = own_options(given, one)
        files = [Path(one), *arguments.params_file, *([own['expect']] if own['expect'] else [])]
        key = key_of([common, own, versions(), version('colortrack_ros')], files)
        tasks.append(Task(name, key, {**common, **own, 'task': key}))
    places = [place for task in tasks for place in _places(task)]
    count = Counter(map(os.path.realpath, places))  # one may be named in two ways
    if twice := [place for place in places if count[os.path.realpath(place)] > 1]:
        raise StartError(
            f'{twice[0]}: {count[os.path.realpath(twice[0])]} recordings would be written to it; '
            'put {} in the name, for that of the recording, and give each recording another name, '
            'but the same one only once'
        )
    return tasks


def own_options(given: Mapping[str, Any], one: str) -> tuple[str, dict[str, Any]]:
    """The name of a recording, and its options, in which that stands in place of {}."""
    path = default_output(one)
    name = path.name.removesuffix('_tracks')
    own = {option: _named(given[option], name) for option in NAMED} | {'input': one}
    return name, own | {'output': own['output'] or path}


def _named(path: Path | None, name: str) -> Path | None:
    return None if path is None else Path(str(path).replace('{}', name))


def _places(task: Task) -> list[Path]:
    return [task.given[option] for option in OUTPUTS if task.given[option]]


def _refused(task: Task) -> str:
    there = [path for path in _places(task) if path.exists()]
    return f'{there[0]}: is there already; --force overwrites it' if there else ''


def _table(outcomes: Sequence[Outcome]) -> Table:
    table = Table(box=SIMPLE, pad_edge=False, collapse_padding=True)
    table.add_column('recording', overflow='fold')
    for head in COLUMNS_OF_TABLE.values():
        table.add_column(head, justify='right', no_wrap=True)
    table.add_column('')
    for task, result, error in outcomes:
        values = [''] * len(COLUMNS_OF_TABLE)
        if result:
            speed = result['frames'] / max(result['seconds'], 1e-9)
            shown = {**result, 'speed': round(speed)}
            values = [str(shown[column]) for column in COLUMNS_OF_TABLE]
        table.add_row(task.name, *values, ('failed', 'faulty')[result is not None] if error else '')
    failed = sum(outcome.result is None for outcome in outcomes)
    table.caption = f'{len(outcomes)} recordings, {failed} failed'
    return table
