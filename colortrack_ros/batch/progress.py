"""The progress bar of long runs."""

from collections.abc import Callable
from collections.abc import Iterator
import contextlib
import sys

from rich.console import Console
from rich.progress import BarColumn
from rich.progress import MofNCompleteColumn
from rich.progress import Progress
from rich.progress import TextColumn
from rich.progress import TimeRemainingColumn


@contextlib.contextmanager
def progress_bar(name: str, total: int, *, stays: bool) -> Iterator[Callable[[int, str], None]]:
    """A progress bar if this is a terminal; yields the function that sets what is done and shown.

    :param total: 0 if it is not known.
    :param stays: whether it is left on the screen at the end.
    """
    columns = TextColumn('{task.description}'), BarColumn(), MofNCompleteColumn()
    console, disable = Console(stderr=True), not sys.stderr.isatty()
    rest = TimeRemainingColumn()
    bar = Progress(*columns, rest, console=console, disable=disable, transient=not stays)
    task = bar.add_task(name, total=total or None)
    with bar:
        yield lambda done, text: bar.update(task, completed=done, description=text)
