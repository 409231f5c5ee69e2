"""What ``tune`` does with one candidate: all recordings tracked with it, and judged."""

import argparse
from collections.abc import Sequence
import contextlib
from pathlib import Path
import threading
from typing import Any
from typing import NamedTuple

import numpy as np

from colortrack_ros.bags import is_bag
from colortrack_ros.data import Tracks
from colortrack_ros.evaluation import compare
from colortrack_ros.evaluation import Record
from colortrack_ros.evaluation.record import empty_rows
from colortrack_ros.evaluation.record import rows_of_tracks
from colortrack_ros.parameters.params_file import flow
from colortrack_ros.replay.outputs import Output
from colortrack_ros.replay.recordings import Item
from colortrack_ros.replay.run import Answers
from colortrack_ros.replay.run import open_recording
from colortrack_ros.replay.run import run_through
from colortrack_ros.replay.setup import read_setup
from colortrack_ros.tools.tune_search import Values

STRETCHES, HELD_OUT = 6, 3
"""The labeled frames of a recording are cut into so many stretches, of which every third is held
out: long enough for identities, and every one beside another that is searched."""


class Labeled(NamedTuple):
    """A recording with its truth.

    :param name: of it.
    :param source: as ``replay`` takes it.
    :param parts: the truth of the frames that are searched, and of those that are held out.
    """

    name: str
    source: str
    parts: tuple[Record, Record]


class Trial(NamedTuple):
    """How good a candidate is: for each recording, where it was searched and where held out."""

    searched: tuple[float, ...]
    held_out: tuple[float, ...]


class RecordOutput(Output):
    """Keeps the tracks.

    :ivar parts: the rows of each frame.
    """

    def __init__(self) -> None:
        self.parts = [empty_rows(0)]

    def write(self, number: int, item: Item, tracks: Tracks) -> None:
        """Keep those of a frame."""
        self.parts.append(rows_of_tracks(tracks, number - 1))

    def close(self) -> None:
        """Nothing is open."""


def halves(truth: Record) -> tuple[Record, Record]:
    """The truth of the stretches that are searched, and of those that are held out."""
    number = np.arange(len(truth.frames)) * STRETCHES // max(len(truth.frames), 1)
    out = number % HELD_OUT == HELD_OUT - 1
    searched, held_out = (Record(truth.rows, truth.frames[k], truth.delays) for k in (~out, out))
    return searched, held_out


def try_out(arguments: argparse.Namespace, labeled: Sequence[Labeled], values: Values) -> Trial:
    """Track and judge them all.

    :param arguments: of the command line.
    :raises StartError, BagError: a recording cannot be read, or a value is refused.
    """
    given = [f'{node}:{name}:={flow(value)}' for (node, name), value in values.items()]
    options = {name: getattr(arguments, name) for name in ('radius', 'iou', 'visible')}
    scores = []
    for recording in labeled:
        tracks = tracked(arguments, recording.source, given)
        results = [compare(part, tracks, **options) for part in recording.parts]
        scores.append([result.measures[arguments.goal] for result in results])
    searched, held_out = zip(*scores, strict=True)
    return Trial(searched, held_out)


def tracked(arguments: argparse.Namespace, source: str, given: Sequence[str]) -> Record:
    """The tracks of a recording, with parameters as ``-p`` takes them besides the others."""
    from_bag = is_bag(Path(source))
    own: dict[str, Any] = {**vars(arguments), 'input': source}
    own['param'] = [*arguments.param, *given]
    namespace = argparse.Namespace(**own)
    setup = read_setup(namespace, from_bag=from_bag)
    output = RecordOutput()
    with contextlib.closing(open_recording(namespace, setup, from_bag=from_bag)) as recording:
        run_through(recording, setup, [output], Answers(), threading.Event())
    return Record.of(np.concatenate(output.parts))
