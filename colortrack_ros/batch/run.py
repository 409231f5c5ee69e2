"""Runs a batch of tasks."""

from collections.abc import Callable
from collections.abc import Iterator
from collections.abc import Sequence
import contextlib
from pathlib import Path
import threading

from colortrack_ros.batch.journal import Journal
from colortrack_ros.batch.progress import progress_bar
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
        with progress_bar('recordings', len(tasks), stays=True) as show:
            for outcome in _outcomes(work, left, workers, stop, journal, refuse):
                journal.add(outcome)
                found[outcome.task.key] = outcome
                failed = sum(o.result is None for o in found.values())
                show(len(found), f'recordings, {failed} failed')
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
