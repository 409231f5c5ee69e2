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
"""Every third recording is held out; of fewer than three, every third of so many stretches of the
labeled frames of each: long enough for identities, each beside another that is searched."""


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
    """How good a candidate is: for each recording, where it was searched and where held out.

    NaN where none of it was.
    """

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


def split(truths: Sequence[Record]) -> list[tuple[Record, Record]]:
    """The truth that is searched, and that which is held out, of each recording."""
    if len(truths) < HELD_OUT:
        return [halves(truth) for truth in truths]
    parts = [(truth, Record(truth.rows, truth.frames[:0], truth.delays)) for truth in truths]
    return [p[::-1] if k % HELD_OUT == HELD_OUT - 1 else p for k, p in enumerate(parts)]


def halves(truth: Record) -> tuple[Record, Record]:
    """The truth of the stretches that are searched, and of those that are held out."""
    number = np.arange(len(truth.frames)) * STRETCHES // max(len(truth.frames), 1)
    out = number % HELD_OUT == HELD_OUT - 1
    searched, held_out = (Record(truth.rows, truth.frames[k], truth.delays) for k in (~out, out))
    return searched, held_out


def try_out(
    arguments: argparse.Namespace, labeled: Sequence[Labeled], job: tuple[Values, bool]
) -> Trial:
    """Track and judge them all.

    :param arguments: of the command line.
    :param job: the candidate, and whether it is judged as well where it is held out.
    :raises StartError, BagError: a recording cannot be read, or a value is refused.
    """
    values, everywhere = job
    given = [f'{node}:{name}:={flow(value)}' for (node, name), value in values.items()]
    options = {name: getattr(arguments, name) for name in ('radius', 'iou', 'visible')}
    scores = []
    for recording in labeled:
        parts = recording.parts if everywhere else recording.parts[:1]
        score = [float('nan')] * 2
        if any(len(part.frames) for part in parts):
            tracks = tracked(arguments, recording.source, given)
            for k, part in enumerate(parts):
                if len(part.frames):
                    score[k] = compare(part, tracks, **options).measures[arguments.goal]
        scores.append(score)
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
