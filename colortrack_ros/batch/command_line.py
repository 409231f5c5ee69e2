"""The options of every command that takes many recordings."""

import argparse
from functools import partial
from pathlib import Path
import sys
from typing import Any

from colortrack_ros.batch.cluster import run_on_cluster
from colortrack_ros.batch.local import run_local
from colortrack_ros.batch.tasks import Workers
from colortrack_ros.files import require_file


class FilesParser(argparse.ArgumentParser):
    """A parser that replaces @FILE by the arguments in it, one a line, and refuses empty names."""

    def __init__(self, prog: str, **options: Any) -> None:
        super().__init__(prog, fromfile_prefix_chars='@', **options)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse them; a file that would block is an error, and so is an empty name, which would be
        the current folder.
        """
        words = sys.argv[1:] if args is None else list(args)
        for word in words:
            try:
                if word.startswith('@'):
                    require_file(word[1:])
            except OSError as error:
                self.error(f'{word}: {error.strerror}')
        found, rest = super().parse_known_args(words, namespace)
        for name, value in vars(found).items():
            names = value if isinstance(value, list) else [value]
            if '' in names and self.get_default(name) is None:
                self.error(f'{name}: got an empty name; is a variable of the shell not set?')
        return found, rest

    def convert_arg_line_to_args(self, arg_line: str) -> list[str]:
        """The argument in a line of @FILE; none in an empty one."""
        return [arg_line] if arg_line.strip() else []


def add_batch_options(parser: argparse.ArgumentParser) -> None:
    """Add ``--jobs``, ``--scheduler`` and ``--report``."""
    group = parser.add_argument_group('many recordings')
    group.add_argument('--jobs', type=_count, default=0, metavar='N', help='so many at a time')
    group.add_argument('--scheduler', default='', metavar='ADDRESS', help='of Dask: on its cluster')
    group.add_argument(
        '--report', type=Path, metavar='FILE',
        help='a line of JSON for each; the same command again goes on from there',
    )  # fmt: skip


def workers_of(arguments: argparse.Namespace) -> Workers | None:
    """The executor that the options ask for; None if they do not."""
    if arguments.scheduler:
        return partial(run_on_cluster, scheduler=arguments.scheduler)
    return partial(run_local, jobs=arguments.jobs) if arguments.jobs else None


def _count(text: str) -> int:
    if not text.isdecimal() or not int(text):
        raise argparse.ArgumentTypeError(f'expected a positive number, got {text!r}')
    return int(text)
