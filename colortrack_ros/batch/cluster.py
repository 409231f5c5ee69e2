"""Tasks on a cluster, by Dask."""

import asyncio
from collections.abc import Iterator
from collections.abc import Sequence
import threading

from colortrack_ros.batch.tasks import attempt
from colortrack_ros.batch.tasks import BatchError
from colortrack_ros.batch.tasks import Outcome
from colortrack_ros.batch.tasks import STOP_PERIOD
from colortrack_ros.batch.tasks import Task
from colortrack_ros.batch.tasks import Work


def run_on_cluster(
    work: Work, tasks: Sequence[Task], stop: threading.Event, *, scheduler: str
) -> Iterator[Outcome]:
    """Run them on the workers of a Dask scheduler, which see the same files under the same names
    and have this package.

    If a worker dies, another takes over its task, at most as often as Dask's ``allowed-failures``
    says (3 by default).

    :param scheduler: its address, such as ``tcp://host:8786``.
    :raises BatchError: Dask is not installed, or the scheduler does not answer.
    """
    try:
        from distributed import Client
        from distributed import wait
    except ImportError as error:
        raise BatchError(f'--scheduler: {error}; needs Dask: pip install distributed') from error
    try:
        client = Client(scheduler)
    except (OSError, ValueError) as error:
        raise BatchError(f'--scheduler {scheduler}: does not answer: {error}') from error
    with client:
        # With keys, Dask would run the same task of two batches only once, and its files would be
        # missing.
        pending = {client.submit(_do, work, task, pure=False): task for task in tasks}
        try:
            while pending and not stop.is_set():
                try:
                    done = wait(
                        list(pending), timeout=STOP_PERIOD, return_when='FIRST_COMPLETED'
                    ).done
                except (TimeoutError, asyncio.TimeoutError):  # one since Python 3.11
                    continue
                for future in done:
                    task = pending.pop(future)
                    ended = future.exception()
                    yield Outcome(task, None, str(ended)) if ended else future.result()
        finally:
            client.cancel(list(pending))


def _do(work: Work, task: Task) -> Outcome:
    """Run one task on a worker."""
    return attempt(work, task, threading.Event())
