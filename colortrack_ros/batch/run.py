"""Runs a batch of tasks."""

from collections.abc import Callable
from collections.abc import Iterator
from collections.abc import Sequence
import contextlib
from pathlib import Path
import sys
import threading

from rich.console import Console
from rich.progress import BarColumn
from rich.progress import MofNCompleteColumn
from rich.progress import Progress
from rich.progress import TextColumn
from rich.progress import TimeRemainingColumn

from colortrack_ros.batch.journal import Journal
from colortrack_ros.batch.tasks import Outcome
from colortrack_ros.batch.tasks import Task
from colortrack_ros.batch.tasks import Work
from colortrack_ros.batch.tasks import Workers


def run_batch(
    work: Work,
    tasks: Sequence[Task],
    workers: Workers,
    stop: threading.Event,
    *,
    report: Path | None = None,
    fresh: bool = False,
    refuse: Callable[[Task], str] = lambda _: '',
) -> list[Outcome]:
    """Run all tasks that an earlier run has not completed.

    :param report: file of the outcomes, of earlier runs too; see Journal.
    :param fresh: whether tasks that an earlier run completed are run again.
    :param refuse: returns why a task that no earlier run has begun must not start; empty if it may.
    :return: in the order of the tasks, without those that were stopped.
    :raises BatchError: the report cannot be written, or there are no workers.
    """
    with contextlib.closing(Journal(report, fresh=fresh)) as journal:
        found = {task.key: done for task in tasks if (done := journal.outcome(task))}
        left = [task for task in tasks if task.key not in found]
        with _progress(len(tasks)) as advance:
            for outcome in _outcomes(work, left, workers, stop, journal, refuse):
                journal.add(outcome)
                found[outcome.task.key] = outcome
                advance(len(found), sum(o.result is None for o in found.values()))
        ended = [found[task.key] for task in tasks if task.key in found]
        if len(ended) == len(tasks):
            journal.tidy(ended)
    return ended


def _outcomes(
    work: Work,
    tasks: Sequence[Task],
    workers: Workers,
    stop: threading.Event,
    journal: Journal,
    refuse: Callable[[Task], str],
) -> Iterator[Outcome]:
    begun = []
    for task in tasks:
        reason = '' if journal.has_begun(task) else refuse(task)
        if reason:
            yield Outcome(task, None, reason)
        else:
            journal.begin(task)
            begun.append(task)
    if begun:
        yield from workers(work, begun, stop)


@contextlib.contextmanager
def _progress(total: int) -> Iterator[Callable[[int, int], None]]:
    """A progress bar if this is a terminal; yields a function that takes the numbers of completed
    and failed tasks.
    """
    columns = TextColumn('{task.description}'), BarColumn(), MofNCompleteColumn()
    console = Console(stderr=True)
    bar = Progress(
        *columns, TimeRemainingColumn(), console=console, disable=not sys.stderr.isatty()
    )
    task = bar.add_task('recordings', total=total)
    with bar:
        yield lambda done, failed: bar.update(
            task, completed=done, description=f'recordings, {failed} failed'
        )
