"""One trial of ``tune``: tracks all recordings with a candidate, and scores the result."""

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
"""Every third recording is held out. With fewer than three recordings, the labeled frames of each
are divided into this many stretches, and every third of them is held out: they are long enough for
identities, and each is beside one that is searched."""


class Labeled(NamedTuple):
    """A recording with its truth.

    :param name: of it.
    :param source: as ``replay`` takes it.
    :param parts: the truth of the frames that are searched, and of those held out.
    """

    name: str
    source: str
    parts: tuple[Record, Record]


class Trial(NamedTuple):
    """The scores of a candidate for each recording, on the part searched and on the part held out.

    NaN if there is no such part.
    """

    searched: tuple[float, ...]
    held_out: tuple[float, ...]


class RecordOutput(Output):
    """An output that keeps the tracks.

    :ivar parts: the rows of each frame.
    """

    def __init__(self) -> None:
        self.parts = [empty_rows(0)]

    def write(self, number: int, item: Item, tracks: Tracks) -> None:
        """Keep the tracks of a frame."""
        self.parts.append(rows_of_tracks(tracks, number - 1))

    def close(self) -> None:
        """Nothing to do."""


def split(truths: Sequence[Record]) -> list[tuple[Record, Record]]:
    """For each recording, the truth that is searched and the truth held out."""
    if len(truths) < HELD_OUT:
        return [halves(truth) for truth in truths]
    parts = [(truth, Record(truth.rows, truth.frames[:0], truth.delays)) for truth in truths]
    return [p[::-1] if k % HELD_OUT == HELD_OUT - 1 else p for k, p in enumerate(parts)]


def halves(truth: Record) -> tuple[Record, Record]:
    """The truth of the stretches that are searched, and of those held out."""
    number = np.arange(len(truth.frames)) * STRETCHES // max(len(truth.frames), 1)
    out = number % HELD_OUT == HELD_OUT - 1
    searched, held_out = (Record(truth.rows, truth.frames[k], truth.delays) for k in (~out, out))
    return searched, held_out


def try_out(
    arguments: argparse.Namespace, labeled: Sequence[Labeled], job: tuple[Values, bool]
) -> Trial:
    """Track and score all recordings.

    :param arguments: of the command line.
    :param job: the candidate, and whether the parts held out are scored as well.
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
    """The tracks of a recording, with further parameters in the form of ``-p``."""
    from_bag = is_bag(Path(source))
    own: dict[str, Any] = {**vars(arguments), 'input': source}
    own['param'] = [*arguments.param, *given]
    namespace = argparse.Namespace(**own)
    setup = read_setup(namespace, from_bag=from_bag)
    output = RecordOutput()
    with contextlib.closing(open_recording(namespace, setup, from_bag=from_bag)) as recording:
        run_through(recording, setup, [output], Answers(), threading.Event())
    return Record.of(np.concatenate(output.parts))
