"""Runs tasks in separate processes, so that a crash of one leaves the others alone."""

from collections import Counter
from collections import deque
from collections.abc import Iterator
from collections.abc import Sequence
import contextlib
import multiprocessing
from multiprocessing.connection import Connection
from multiprocessing.connection import wait
from multiprocessing.context import ForkServerContext
from multiprocessing.process import BaseProcess
import os
import queue
import signal
import threading

from colortrack_ros.batch.tasks import attempt
from colortrack_ros.batch.tasks import Outcome
from colortrack_ros.batch.tasks import STOP_PERIOD
from colortrack_ros.batch.tasks import Task
from colortrack_ros.batch.tasks import TRIES
from colortrack_ros.batch.tasks import Work

GRACE = 8.0
"""How long a task may take to stop when told to [s]: half of it is for a drive that does not
answer."""


def run_here(work: Work, tasks: Sequence[Task], stop: threading.Event) -> Iterator[Outcome]:
    """Run one after the other in this process, for a few short tasks."""
    for task in tasks:
        if not stop.is_set():
            yield attempt(work, task, stop)


def run_local(
    work: Work, tasks: Sequence[Task], stop: threading.Event, *, jobs: int
) -> Iterator[Outcome]:
    """Run several tasks at a time, in processes forked from one that has imported everything.

    If a process dies, another one repeats its task. All processes end with this one, however it
    ends.
    """
    context = multiprocessing.get_context('forkserver')
    context.set_forkserver_preload([work.__module__])
    waiting, deaths = deque(tasks), Counter[str]()
    workers: dict[Connection, BaseProcess] = {}
    running: dict[Connection, Task] = {}
    try:
        while (waiting or running) and not stop.is_set():
            while waiting and len(running) < jobs:
                connection, process = _started(context, work)
                workers[connection] = process
                _hand_out(waiting, connection, running)
            for ready in wait(list(running), STOP_PERIOD):
                assert isinstance(ready, Connection)
                task = running.pop(ready)
                outcome = _received(ready, task)
                if outcome:
                    _hand_out(waiting, ready, running)
                    yield outcome
                    continue
                workers[ready].join()
                deaths[task.key] += 1
                if deaths[task.key] < TRIES:
                    waiting.append(task)
                else:
                    status = workers[ready].exitcode
                    ended = f'ended {TRIES} processes, the last with status {status}'
                    yield Outcome(task, None, ended)
    finally:
        _end(workers)


def _started(context: ForkServerContext, work: Work) -> tuple[Connection, BaseProcess]:
    """A worker process."""
    connection, other = context.Pipe()
    process = context.Process(target=_do_all, args=(work, other))
    process.start()
    other.close()
    return connection, process


def _hand_out(
    waiting: deque[Task], connection: Connection, running: dict[Connection, Task]
) -> None:
    """Give a process its next task; let it go if there is none or it has just died."""
    if waiting:
        with contextlib.suppress(OSError):
            connection.send(waiting[0])
            running[connection] = waiting.popleft()
            return
    connection.close()


def _received(connection: Connection, task: Task) -> Outcome | None:
    """The outcome that a process reports; None if it has died."""
    try:
        answer: Outcome = connection.recv()
    except (EOFError, OSError):
        connection.close()
        return None
    return answer._replace(task=task)


def _end(workers: dict[Connection, BaseProcess]) -> None:
    for connection in workers:
        connection.close()  # tells them to end
    for process in workers.values():
        process.join(GRACE)
        process.kill()


def _do_all(work: Work, connection: Connection) -> None:
    """The main loop of a process: one task after the other until the other end is closed."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)  # the parent decides
    stop, tasks = threading.Event(), queue.SimpleQueue[Task | None]()
    threading.Thread(target=_listen, args=(connection, tasks, stop), daemon=True).start()
    while task := tasks.get():
        outcome = attempt(work, task, stop)
        if not stop.is_set():
            connection.send(outcome)


def _listen(
    connection: Connection, tasks: queue.SimpleQueue[Task | None], stop: threading.Event
) -> None:
    """Pass on tasks; at the end stop the one that is running, and end the process."""
    with contextlib.suppress(EOFError, OSError):
        while True:
            tasks.put(connection.recv())
    stop.set()
    tasks.put(None)
    threading.Event().wait(GRACE / 2)
    os._exit(1)
