"""What the processors do for processes that a test has started, as Linux counts it."""

import contextlib
import os
from pathlib import Path
from typing import NamedTuple


class Stay(NamedTuple):
    """Of threads, together [s]: how long they have run, and waited for a processor."""

    running: float
    queued: float


def children(word: str) -> list[Path]:
    """Folders of all processes below this one whose command has the word."""
    return [folder for folder in _descendants() if word in (folder / 'cmdline').read_text()]


def stay_of(threads: list[Path]) -> Stay:
    """Of the threads with these folders, since they began."""
    found = [path.read_text().split() for t in threads if (path := t / 'schedstat').exists()]
    running, queued, _ = (1e-9 * sum(map(int, times)) for times in zip(*found, strict=True))
    return Stay(running, queued)


def stat_of(folder: Path) -> list[str]:
    """What Linux tells of a process or a thread, from its state on: its name may be anything."""
    return (folder / 'stat').read_text().rpartition(')')[2].split()


def threads_of(pid: int) -> str:
    """A line for each thread of a process: name, state, and where in the kernel it waits."""
    lines = []
    for folder in sorted(Path(f'/proc/{pid}/task').glob('*')):
        with contextlib.suppress(OSError):  # it has just ended
            name, place = ((folder / file).read_text().strip() for file in ('comm', 'wchan'))
            lines.append(f'{folder.name}: {name}, {stat_of(folder)[0]}, {place}')
    return '\n'.join(lines)


def _descendants() -> list[Path]:
    below: dict[int, list[int]] = {}
    for stat in Path('/proc').glob('[0-9]*/stat'):
        if stat.exists():
            below.setdefault(int(stat_of(stat.parent)[1]), []).append(int(stat.parent.name))
    found = [os.getpid()]
    for one in found:
        found += below.get(one, [])
    return [Path(f'/proc/{pid}') for pid in found[1:]]
