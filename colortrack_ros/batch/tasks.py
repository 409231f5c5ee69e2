"""What is done once for each recording, and what came of it."""

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
"""Workers that a task may take with it: a machine that fails does so once, a task that is too large
for its machine always does."""


STOP_PERIOD = 0.2
"""How often is looked whether the batch is to stop [s]."""


class BatchError(Exception):
    """The batch cannot begin, or cannot go on: one line, what was given and what would work."""


class TaskError(Exception):
    """A task has failed, as it would again: one line that says why."""


class Task(NamedTuple):
    """One recording.

    :param name: for tables.
    :param key: of all that the result depends on; no two tasks of a batch have the same.
    :param given: what the work takes; can be pickled.
    """

    name: str
    key: str
    given: Any


class Outcome(NamedTuple):
    """What came of a task.

    :param result: None if there is none; can be written as JSON.
    :param error: why it failed, or what is wrong with the result; empty if all is well.
    """

    task: Task
    result: dict[str, Any] | None
    error: str = ''


Work = Callable[[Any, threading.Event], tuple[dict[str, Any] | None, str]]
"""Takes what a task gives, and an event after which it ends soon, without a trace. Returns result
and error, or raises TaskError. A function of a module, so that other processes can import it."""

Workers = Callable[[Work, Sequence[Task], threading.Event], Iterator[Outcome]]
"""Does the work for all tasks and yields each outcome once, in any order; all but some if it is
stopped."""


def attempt(work: Work, task: Task, stop: threading.Event) -> Outcome:
    """Do a task; whatever it raises is its own failure, not that of the batch."""
    try:
        return Outcome(task, *work(task.given, stop))
    except TaskError as error:
        return Outcome(task, None, str(error))
    except Exception as error:
        return Outcome(task, None, f'{type(error).__name__}: {" ".join(str(error).split())}')


def key_of(given: Any, paths: Sequence[Path]) -> str:
    """The key of what is given and of files and folders as they are now.

    :param given: can be written as text.
    """
    files = [f for path in paths for f in (sorted(path.rglob('*')) if path.is_dir() else [path])]
    states = [(str(f), f.stat().st_size, f.stat().st_mtime_ns) for f in files if f.is_file()]
    return hashlib.sha256(json.dumps([given, states], default=str).encode()).hexdigest()[:16]
