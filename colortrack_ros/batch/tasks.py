"""Tasks, one for each recording, and their outcomes."""

from collections.abc import Callable
from collections.abc import Iterator
from collections.abc import Sequence
import hashlib
import json
from pathlib import Path
import threading
from typing import Any
from typing import NamedTuple

TRIES = 3
"""How many workers may die with a task before it fails: a bad machine fails once, a task too large
for its machine fails every time."""


STOP_PERIOD = 0.2
"""Interval of the check whether the batch is to stop [s]. Assumed: too short for a person to
notice."""


class BatchError(Exception):
    """The batch cannot start or continue: in one line, what was given and what would work."""


class TaskError(Exception):
    """A task has failed and would fail again: why, in one line."""


class Task(NamedTuple):
    """One recording.

    :param name: for tables.
    :param key: hash of everything that the result depends on; unique within a batch.
    :param given: input of the work; can be pickled.
    """

    name: str
    key: str
    given: Any


class Outcome(NamedTuple):
    """The outcome of a task.

    :param result: None if there is none; can be written as JSON.
    :param error: why it failed, or what is wrong with the result; empty if all is well.
    """

    task: Task
    result: dict[str, Any] | None
    error: str = ''


Work = Callable[[Any, threading.Event], tuple[dict[str, Any] | None, str]]
"""Takes the input of a task, and an event; once that is set, it stops soon and leaves nothing
behind. Returns result and error, or raises TaskError. It is a function at module level, so that
other processes can import it."""

Workers = Callable[[Work, Sequence[Task], threading.Event], Iterator[Outcome]]
"""Runs the work for all tasks and yields each outcome once, in any order; fewer if it is
stopped."""


def attempt(work: Work, task: Task, stop: threading.Event) -> Outcome:
    """Run a task; any exception is a failure of the task, not of the batch."""
    try:
        return Outcome(task, *work(task.given, stop))
    except TaskError as error:
        return Outcome(task, None, str(error))
    except Exception as error:
        return Outcome(task, None, f'{type(error).__name__}: {" ".join(str(error).split())}')


def key_of(given: Any, paths: Sequence[Path]) -> str:
    """The key of the given input and of the present state of files and folders.

    :param given: can be written as text.
    """
    files = [f for path in paths for f in (sorted(path.rglob('*')) if path.is_dir() else [path])]
    states = [(str(f), f.stat().st_size, f.stat().st_mtime_ns) for f in files if f.is_file()]
    return hashlib.sha256(json.dumps([given, states], default=str).encode()).hexdigest()[:16]
