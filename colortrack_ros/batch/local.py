"""Tasks in processes of this machine, one for each, so that none takes another with it."""

from collections import Counter
from collections import deque
from collections.abc import Iterator
from collections.abc import Sequence
import multiprocessing
from multiprocessing.connection import Connection
from multiprocessing.connection import wait
from multiprocessing.process import BaseProcess
import os
import signal
import threading

from colortrack_ros.batch.tasks import attempt
from colortrack_ros.batch.tasks import Outcome
from colortrack_ros.batch.tasks import STOP_PERIOD
from colortrack_ros.batch.tasks import Task
from colortrack_ros.batch.tasks import TRIES
from colortrack_ros.batch.tasks import Work

GRACE = 8.0
"""How long a task may take to end once it is told to [s]: half of it for a drive that does not
answer."""


def run_here(work: Work, tasks: Sequence[Task], stop: threading.Event) -> Iterator[Outcome]:
    """Do one after the other in this process: for few that are soon done."""
    for task in tasks:
        if not stop.is_set():
            yield attempt(work, task, stop)


def run_local(
    work: Work, tasks: Sequence[Task], stop: threading.Event, *, jobs: int
) -> Iterator[Outcome]:
    """Do so many tasks at a time, each in a process that is forked from one with all imports.

    One whose process dies is done again. Processes end with this one, however it ends.
    """
    context = multiprocessing.get_context('forkserver')
    context.set_forkserver_preload([work.__module__])
    waiting, deaths = deque(tasks), Counter[str]()
    running: dict[Connection, tuple[BaseProcess, Task]] = {}
    try:
        while (waiting or running) and not stop.is_set():
            while waiting and len(running) < jobs:
                task = waiting.popleft()
                mine, theirs = context.Pipe()
                process: BaseProcess = context.Process(target=_do, args=(work, task, theirs))
                process.start()
                theirs.close()
                running[mine] = process, task
            for ready in wait(list(running), STOP_PERIOD):
                assert isinstance(ready, Connection)
                process, task = running.pop(ready)
                outcome = _received(ready, process, task)
                if outcome:
                    yield outcome
                    continue
                deaths[task.key] += 1
                if deaths[task.key] < TRIES:
                    waiting.append(task)
                else:
                    ended = f'ended {TRIES} processes, the last with status {process.exitcode}'
                    yield Outcome(task, None, ended)
    finally:
        _end(running)


def _end(running: dict[Connection, tuple[BaseProcess, Task]]) -> None:
    for connection in running:
        connection.close()  # which tells them to end
    for process, _ in running.values():
        process.join(GRACE)
        process.kill()


def _received(connection: Connection, process: BaseProcess, task: Task) -> Outcome | None:
    """What a process has found out; None if it died before."""
    with connection:
        try:
            answer: Outcome = connection.recv()
        except (EOFError, ConnectionError):
            process.join()
            return None
        # The process may take its time to end: its answer is there.
        return answer._replace(task=task)


def _do(work: Work, task: Task, connection: Connection) -> None:
    """What a process does: one task."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the terminal sends it to all; the first decides
    stop = threading.Event()
    threading.Thread(target=_end_with_parent, args=(connection, stop), daemon=True).start()
    outcome = attempt(work, task, stop)
    if not stop.is_set():
        connection.send(outcome)


def _end_with_parent(connection: Connection, stop: threading.Event) -> None:
    """Tell the task to end when the other end is closed; then end the process."""
    connection.poll(None)
    stop.set()
    threading.Event().wait(GRACE / 2)
    os._exit(1)
