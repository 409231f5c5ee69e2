"""``tune``: finds the parameters that track recordings with known truth best."""

import argparse
from collections.abc import Callable
from collections.abc import Iterator
from collections.abc import Sequence
from concurrent.futures import BrokenExecutor
from concurrent.futures import ProcessPoolExecutor
import contextlib
from functools import partial
import multiprocessing
import os
from pathlib import Path
import select
import sys
import threading

import numpy as np
from rich.box import SIMPLE
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from colortrack_ros.bags import BagError
from colortrack_ros.bags import is_bag
from colortrack_ros.batch import FilesParser
from colortrack_ros.evaluation import RecordError
from colortrack_ros.files import read_params_file
from colortrack_ros.files import write_file
from colortrack_ros.node_kit.runtime import StartError
from colortrack_ros.nodes.tracker import TrackerSetup
from colortrack_ros.parameters.params_file import with_values
from colortrack_ros.replay.inputs import recordings_in
from colortrack_ros.replay.setup import add_ros_options
from colortrack_ros.replay.setup import read_setup
from colortrack_ros.tools.evaluation_task import add_match_options
from colortrack_ros.tools.evaluation_task import name_of
from colortrack_ros.tools.evaluation_task import read_truth
from colortrack_ros.tools.tune_search import changed
from colortrack_ros.tools.tune_search import pruned
from colortrack_ros.tools.tune_search import search
from colortrack_ros.tools.tune_search import Slider
from colortrack_ros.tools.tune_search import sliders_of
from colortrack_ros.tools.tune_search import Values
from colortrack_ros.tools.tune_trial import HELD_OUT
from colortrack_ros.tools.tune_trial import Labeled
from colortrack_ros.tools.tune_trial import split
from colortrack_ros.tools.tune_trial import Trial
from colortrack_ros.tools.tune_trial import try_out

FEW = 30
"""With fewer labeled frames held out, the error of a score is a tenth by chance (the standard error
of a share of one half)."""

Judged = Callable[[Sequence[Values], bool], list[Trial]]
"""Scores candidates, optionally also on the parts that are held out."""


def main(args: Sequence[str] | None = None) -> int:
    """Tune.

    :return: the exit status: 0; 1 if something cannot be read or written; 2 if the arguments are
        wrong; 3 if nothing better was found for the parts held out, so nothing is written.
    """
    arguments = _parse(args)
    try:
        return _tune(arguments)
    except (StartError, BagError, RecordError, BrokenExecutor, OSError, ValueError) as error:
        print(f'tune: {error}', file=sys.stderr)
        return 1


def _parse(args: Sequence[str] | None) -> argparse.Namespace:
    parser = FilesParser('tune', description=__doc__)
    add = parser.add_argument
    add(
        'inputs',
        nargs='+',
        metavar='recording',
        help='as replay takes it; several, a folder, @FILE',
    )
    add(
        '--truth', metavar='TRUTH',
        help='of each, as evaluate takes it; {} stands for its name; scenes have their own',
    )  # fmt: skip
    add_match_options(parser)
    add('--goal', choices=('hota', 'idf1', 'mota'), default='hota', help='default: hota')
    add('--write', type=Path, metavar='YAML', help='where; default: printed')
    add('--trials', type=int, default=84, help='candidates, about; default: 84')
    add('--seed', type=int, default=0, help='of the search')
    add('--jobs', type=int, default=1, metavar='N', help='candidates at a time')
    add_ros_options(parser)
    parser.set_defaults(tracker='tracker')
    return parser.parse_args(args)


def _tune(arguments: argparse.Namespace) -> int:
    labeled = list(_labeled(arguments))
    setup = read_setup(arguments, from_bag=is_bag(Path(labeled[0].source)))
    assert setup.detector
    assert isinstance(setup.tracker, TrackerSetup)
    sliders = list(sliders_of(setup.detector.config, setup.tracker.config))
    console = Console()
    with _trials(arguments, labeled) as judged:

        def judge(candidates: Sequence[Values]) -> list[float]:
            return [float(np.nanmean(trial.searched)) for trial in judged(candidates, False)]

        found = search(sliders, judge, arguments.trials, arguments.seed)
        values, worth = pruned(changed(found, sliders), judge)
        before, after = judged([{}, values], True)
    console.print(_scores(labeled, before, after, arguments.goal))
    console.print(_changes(sliders, values, worth))
    for doubt in doubts(
        labeled, before, after, [s for s in sliders if s.is_at_bound(values.get((s.node, s.name)))]
    ):
        console.print(f'- {doubt}', markup=False)
    if not values or np.nanmean(after.held_out) <= np.nanmean(before.held_out):
        print('nothing better was found for what was held out: nothing is written', file=sys.stderr)
        return 3
    _write(arguments, values, console)
    return 0


def _labeled(arguments: argparse.Namespace) -> Iterator[Labeled]:
    """The recordings with their truth.

    :raises RecordError: one has none.
    """
    found = []
    for source in recordings_in(arguments.inputs):
        name = name_of(source.partition('?')[0])
        is_scene = source.startswith('scene:')
        if not is_scene and not arguments.truth:
            raise RecordError(f'{source}: its truth is not known; expected --truth')
        truth = source if is_scene else arguments.truth.replace('{}', name)
        found.append((name, source, read_truth(truth, '')))
    for (name, source, _), parts in zip(found, split([one[2] for one in found]), strict=True):
        yield Labeled(name, source, parts)


@contextlib.contextmanager
def _trials(arguments: argparse.Namespace, labeled: Sequence[Labeled]) -> Iterator[Judged]:
    """Create the function that tries candidates, each once, several at a time."""
    known: dict[str, Trial] = {}
    context = multiprocessing.get_context('forkserver')
    work = partial(try_out, arguments, labeled)
    with (
        ProcessPoolExecutor(arguments.jobs, context, _end_with, (os.getpid(),)) as pool,
        Progress(console=Console(stderr=True), disable=not sys.stderr.isatty()) as bar,
    ):
        task = bar.add_task('candidates', total=arguments.trials)

        def judged(candidates: Sequence[Values], everywhere: bool) -> list[Trial]:
            jobs = [(one, everywhere) for one in candidates]
            new = {repr(job): job for job in jobs if repr(job) not in known}
            for key, trial in zip(new, pool.map(work, new.values()), strict=True):
                known[key] = trial
                bar.advance(task)
            return [known[repr(job)] for job in jobs]

        yield judged


def _end_with(pid: int) -> None:
    """End this process when another one ends, however it does."""
    other = os.pidfd_open(pid)

    def wait() -> None:
        select.select([other], [], [])
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()


def _scores(labeled: Sequence[Labeled], before: Trial, after: Trial, goal: str) -> Table:
    table = Table(title=goal, box=SIMPLE)
    for name in ('', 'searched', '', 'held out', ''):
        table.add_column(name, justify='right' if name != '' else 'left')
    for k, recording in enumerate(labeled):
        table.add_row(
            recording.name,
            *_row(
                *(t[k] for t in (before.searched, after.searched, before.held_out, after.held_out))
            ),
        )
    means = (
        np.nanmean(t) for t in (before.searched, after.searched, before.held_out, after.held_out)
    )
    table.add_row('mean', *_row(*map(float, means)))
    return table


def _row(*scores: float) -> tuple[str, ...]:
    a, b, c, d = ('' if np.isnan(score) else f'{score:.3f}' for score in scores)
    return a, f'-> {b}' * bool(b), c, f'-> {d}' * bool(d)


def _changes(
    sliders: Sequence[Slider], values: Values, worth: dict[tuple[str, str], float]
) -> Table:
    table = Table(title='parameters', box=SIMPLE)
    for name in ('', 'before', 'after', 'worth'):
        table.add_column(name, justify='right' if name else 'left')
    for slider in sliders:
        key = slider.node, slider.name
        if key in values:
            names = f'{slider.node} {slider.name}', str(slider.start), str(values[key])
            table.add_row(*names, f'{worth[key]:+.3f}')
        else:
            table.add_row(f'{slider.node} {slider.name}', str(slider.start), 'as it was', '')
    return table


def doubts(
    labeled: Sequence[Labeled], before: Trial, after: Trial, at_bound: Sequence[Slider]
) -> Iterator[str]:
    """Reasons why the result may not hold for other recordings, one sentence each."""
    if len(labeled) == 1:
        yield 'one recording: nothing is known of another light, place or camera'
    elif len(labeled) < HELD_OUT:
        yield 'two recordings, both searched in part: nothing is known of a third'
    frames = sum(len(recording.parts[1].frames) for recording in labeled)
    if frames < FEW:
        yield f'{frames} labeled frames are held out: below {FEW}, chance decides'
    for recording, one, two in zip(labeled, before.held_out, after.held_out, strict=True):
        if two < one:
            yield f'{recording.name} is worse where it was held out: {one:.3f} -> {two:.3f}'
    gain = np.nanmean(after.searched) - np.nanmean(before.searched)
    held = np.nanmean(after.held_out) - np.nanmean(before.held_out)
    if held < gain / 2:
        yield f'{gain:+.3f} where it was searched, {held:+.3f} where not: fitted to the frames'
    for slider in at_bound:
        yield f'{slider.name} is at the end of its range'


def _write(arguments: argparse.Namespace, values: Values, console: Console) -> None:
    """Change the params file, or the one to be written if there is none, or print it.

    :raises ValueError: the file cannot be changed.
    """
    text = read_params_file(arguments.params_file[-1]) if arguments.params_file else ''
    for node in dict.fromkeys(node for node, _ in values):
        own = {name: value for (whose, name), value in values.items() if whose == node}
        text = with_values(text, node, own)
    if arguments.write:
        write_file(arguments.write, text.encode())
        console.print(f'written to {arguments.write}')
    else:
        console.print(text, markup=False, highlight=False)
