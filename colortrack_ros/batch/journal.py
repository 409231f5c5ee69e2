"""The report of a batch, from which an interrupted run can be resumed."""

from collections.abc import Sequence
import contextlib
import fcntl
import json
from pathlib import Path
from typing import Any

from colortrack_ros.batch.tasks import BatchError
from colortrack_ros.batch.tasks import Outcome
from colortrack_ros.batch.tasks import Task
from colortrack_ros.files import require_file
from colortrack_ros.files import write_file


class Journal:
    """A file with one line of JSON for each outcome: name, key, error, and result.

    While a batch runs, it also has lines without a result for tasks that have begun.

    :param path: of the file; None: no file.
    :param fresh: whether results of earlier runs are discarded.
    :raises BatchError: it cannot be written, is not such a file, or another batch is writing it.
    """

    def __init__(self, path: Path | None, *, fresh: bool = False) -> None:
        self._path = path
        self._lines: dict[str, dict[str, Any]] = {}
        if path is None:
            return
        with contextlib.ExitStack() as opened:
            try:
                if path.exists():
                    require_file(path)
                self._file = opened.enter_context(path.open('a+'))
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                if fresh:
                    self._file.truncate(0)
                self._read(path)
            except BlockingIOError:
                raise BatchError(f'{path}: another run writes it now') from None
            except OSError as error:
                raise BatchError(f'{path}: {error.strerror}') from error
            opened.pop_all()  # it stays open from here on

    def _read(self, path: Path) -> None:
        self._file.seek(0)
        text = self._file.read()
        for line in text.splitlines():
            with contextlib.suppress(ValueError):  # cut short by a kill
                entry = json.loads(line)
                if isinstance(entry, dict) and isinstance(entry.get('key'), str):
                    self._lines[entry['key']] = entry
        if text and not self._lines:
            raise BatchError(f'{path}: expected the report of an earlier run, or no such file')
        if text and not text.endswith('\n'):
            self._file.write('\n')

    def has_begun(self, task: Task) -> bool:
        """Whether an earlier run that was killed may have left part of its results."""
        return 'result' not in self._lines.get(task.key, {'result': None})

    def outcome(self, task: Task) -> Outcome | None:
        """The outcome of an earlier run; None if there is none that is still valid."""
        line = self._lines.get(task.key, {})
        return Outcome(task, line['result'], line['error']) if line.get('result') else None

    def begin(self, task: Task) -> None:
        """Note that a task is about to begin."""
        self._write({'name': task.name, 'key': task.key})

    def add(self, outcome: Outcome) -> None:
        """Note the outcome of a task."""
        self._write(_line(outcome))

    def _write(self, line: dict[str, Any]) -> None:
        if self._path is None:
            return
        try:
            self._file.write(json.dumps(line) + '\n')
            self._file.flush()
        except OSError as error:
            raise BatchError(f'{self._path}: {error.strerror}') from error

    def tidy(self, outcomes: Sequence[Outcome]) -> None:
        """Rewrite the file with one line for each of these, in this order."""
        if self._path is None:
            return
        text = ''.join(json.dumps(_line(o)) + '\n' for o in outcomes)
        try:
            write_file(self._path, text.encode())
        except OSError as error:
            raise BatchError(f'{self._path}: {error.strerror}') from error

    def close(self) -> None:
        """Close the file."""
        if self._path is not None:
            self._file.close()


def _line(outcome: Outcome) -> dict[str, Any]:
    task, result, error = outcome
    return {'name': task.name, 'key': task.key, 'error': error, 'result': result}
