"""The options that every command for many recordings has."""

import argparse
from functools import partial
from pathlib import Path

from colortrack_ros.batch.cluster import run_on_cluster
from colortrack_ros.batch.local import run_local
from colortrack_ros.batch.tasks import Workers


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
    """Who does the work, as the options say; None if they do not."""
    if arguments.scheduler:
        return partial(run_on_cluster, scheduler=arguments.scheduler)
    return partial(run_local, jobs=arguments.jobs) if arguments.jobs else None


def _count(text: str) -> int:
    if not text.isdecimal() or not int(text):
        raise argparse.ArgumentTypeError(f'expected a positive number, got {text!r}')
    return int(text)
