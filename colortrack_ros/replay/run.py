"""Runs detector and tracker over a recording, for ``replay``."""

import argparse
from collections.abc import Sequence
import contextlib
from dataclasses import dataclass
from dataclasses import field
from pathlib import Path
import threading
import time

from colortrack_ros.bags import BagError
from colortrack_ros.bags import is_bag
from colortrack_ros.batch.progress import progress_bar
from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import Tracks
from colortrack_ros.flow.stamps import OF_ONE_MOMENT
from colortrack_ros.flow.stamps import StampWatch
from colortrack_ros.node_kit.runtime import StartError
from colortrack_ros.replay.chains import make_chain
from colortrack_ros.replay.expected import ExpectedOutput
from colortrack_ros.replay.outputs import BagOutput
from colortrack_ros.replay.outputs import CsvOutput
from colortrack_ros.replay.outputs import MotOutput
from colortrack_ros.replay.outputs import Output
from colortrack_ros.replay.outputs import VideoOutput
from colortrack_ros.replay.recordings import BagRecording
from colortrack_ros.replay.recordings import Item
from colortrack_ros.replay.recordings import Recording
from colortrack_ros.replay.recordings import SourceRecording
from colortrack_ros.replay.setup import read_setup
from colortrack_ros.replay.setup import Setup
from colortrack_ros.replay.targets import Targets


@dataclass
class Answers:
    """Counts of what has been processed so far."""

    frames: int = 0
    detections: int = 0
    restarts: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    tracks: set[int] = field(default_factory=set)
    still: list[str] = field(default_factory=list)
    first: int = 0
    last: int = 0

    def add(self, item: Item, tracks: Tracks) -> None:
        """Count a frame."""
        self.first = item.log_time if self.frames == 0 else self.first
        self.last = item.log_time
        self.frames += 1
        self.tracks.update(tracks.rows['track_id'][tracks.rows['state'] != TENTATIVE].tolist())
        if tracks.restarted:
            self.restarts.append(tracks.restarted)

    def warn(self, trouble: str) -> None:
        """Count a picture if detector or tracker have advice about it; empty: they have none."""
        if trouble:
            self.warnings.append(trouble)

    def stamp(self, still: str) -> None:
        """Count a frame whose stamp stands still; empty: it does not."""
        self.warn(still)
        self.still += [still] if still else []

    @property
    def timeless(self) -> str:
        """What is wrong if stamps stood still from the first frame to the last; empty if not."""
        stood = bool(self.still) and len(self.still) + OF_ONE_MOMENT >= self.frames
        return self.still[-1] if stood else ''


@dataclass(frozen=True)
class Replayed:
    """The result of one recording.

    :param recording: closed, with its counts.
    :param output: the folder of the new bag.
    :param answers: counts.
    :param seconds: duration of the run.
    :param interrupted: whether it was stopped early.
    :param error: why the results are incomplete; empty if they are complete.
    :param differences: from the expected tracks, one line each; empty if there are none.
    """

    recording: Recording
    output: Path
    answers: Answers
    seconds: float
    interrupted: bool
    error: str
    differences: str


class Stopped(Exception):
    """The batch has been stopped: nothing of this recording is kept."""


def replay_recording(
    arguments: argparse.Namespace, stop: threading.Event, task: str = ''
) -> Replayed:
    """Run one recording through the chain and write the outputs that the command line asks for.

    :param stop: once set, it ends early, with complete files.
    :param task: key of the task, if this is part of a batch; partial outputs of an earlier attempt
        are removed.
    :raises StartError, BagError, BagWriteError, OSError: a parameter is refused, or something
        cannot be opened or written.
    :raises Stopped: the batch has been stopped.
    """
    from_bag = is_bag(Path(arguments.input))
    setup = read_setup(arguments, from_bag=from_bag)
    path = arguments.output or default_output(arguments.input)
    tally, error = Answers(), ''
    with contextlib.ExitStack() as stack:
        recording = open_recording(arguments, setup, from_bag=from_bag)
        stack.callback(recording.close)
        threading.Thread(target=_interrupt, args=(recording, stop), daemon=True).start()
        targets = _targets(arguments, path, recording, task)
        stack.callback(targets.discard)
        began = time.monotonic()
        with contextlib.ExitStack() as writing:
            outputs = _outputs(arguments, targets, path, recording, setup, writing)
            try:
                run_through(recording, setup, outputs, tally, stop)
            except BagError as broken:
                error = str(broken)
        if task and stop.is_set():
            raise Stopped
        targets.commit()
        seconds = time.monotonic() - began
    if recording.lost and not error:
        error = f'{recording.label}: {recording.lost} pictures are lost'
    if tally.timeless and not error:
        error = f'{recording.label}: {tally.timeless}'
    differences = next((o.report() for o in outputs if isinstance(o, ExpectedOutput)), '')
    return Replayed(recording, path, tally, seconds, stop.is_set(), error, differences)


def _interrupt(recording: Recording, stop: threading.Event) -> None:
    stop.wait()
    recording.interrupt()


def run_through(
    recording: Recording,
    setup: Setup,
    outputs: Sequence[Output],
    tally: Answers,
    stop: threading.Event,
) -> None:
    """Run each frame through the chain, and write the results to the outputs."""
    stamps = StampWatch()

    def detected(detections: Detections, item: Item) -> None:
        tally.detections += len(detections.rows)
        for output in outputs:
            output.write_detections(item, detections)

    def tracked(tracks: Tracks, item: Item) -> None:
        tally.add(item, tracks)
        tally.stamp(stamps.see(tracks.stamp))
        number = tally.frames + recording.refused
        for output in outputs:
            output.write(number, item, tracks)

    recording.warn, viewpoints = tally.warn, recording.viewpoints
    chain = make_chain(setup, detected, tracked, recording.drop, tally.warn, viewpoints)
    bar = progress_bar('replay', recording.total, stays=False)
    with bar as show, contextlib.ExitStack() as at_end:
        at_end.callback(chain.flush)
        for number, item in enumerate(recording.items(), 1):
            if stop.is_set():
                return
            chain.put(item.content, item)
            show(number, 'replay')


def default_output(name: str) -> Path:
    """The default output, beside the input: its name with ``_tracks`` in place of the suffix.

    A scene, ``scene:five?rate=25``, gives ``five_tracks`` in the current folder.
    """
    if name.startswith('scene:'):
        return Path(f'{name[6:].partition("?")[0]}_tracks')
    path = Path(name)
    if not path.exists() and any(character in path.name for character in '*?['):
        path = path.parent
    path = path.resolve() if path.name in ('', '..') else path
    return path.with_name(f'{path.name if path.is_dir() else path.stem}_tracks')


def open_recording(arguments: argparse.Namespace, setup: Setup, *, from_bag: bool) -> Recording:
    """The recording that the command line names.

    :raises StartError: it cannot be opened, or a topic is given for an input without topics.
    """
    if from_bag:
        return BagRecording(Path(arguments.input), arguments.topic, setup)
    if arguments.topic:
        raise StartError(f'--topic {arguments.topic}: {arguments.input} is not a bag')
    if setup.topics['odometry']:
        raise StartError(f'ego_motion: odometry: {arguments.input} is not a bag that has some')
    return SourceRecording(arguments.input, setup.camera)


def _targets(arguments: argparse.Namespace, path: Path, recording: Recording, task: str) -> Targets:
    if arguments.video and not recording.has_pictures:
        raise StartError(f'--video: there are no pictures in {recording.label}')
    files = [file for file in (arguments.video, arguments.csv, arguments.mot) if file]
    inputs = [arguments.input, *arguments.params_file]
    inputs += [arguments.expect] if arguments.expect else []
    return Targets(path, files, inputs, force=arguments.force, task=task)


def _outputs(
    arguments: argparse.Namespace,
    targets: Targets,
    path: Path,
    recording: Recording,
    setup: Setup,
    writing: contextlib.ExitStack,
) -> list[Output]:
    """All outputs; the stack closes them."""
    outputs: list[Output] = []

    def add(output: Output) -> None:
        writing.callback(output.close)
        outputs.append(output)

    if arguments.expect:
        add(ExpectedOutput(arguments.expect))
    add(BagOutput(targets.staged(path), arguments.storage, setup))
    if arguments.csv:
        add(CsvOutput(targets.staged(arguments.csv)))
    if arguments.mot:
        add(MotOutput(targets.staged(arguments.mot)))
    if arguments.video:
        add(VideoOutput(targets.staged(arguments.video), recording.rate))
    return outputs


def summary(result: Replayed) -> str:
    """Print the result in a few lines."""
    recording, tally = result.recording, result.answers
    speed = tally.frames / max(result.seconds, 1e-9)
    real_time = (tally.last - tally.first) / NANOSECONDS / max(result.seconds, 1e-9)
    lines = [
        f'{recording.label} -> {result.output}',
        f'  frames      {tally.frames}' + (', interrupted' if result.interrupted else ''),
        f'  detections  {tally.detections}',
        f'  tracks      {len(tally.tracks)} confirmed',
        f'  speed       {speed:.0f} frames/s, {real_time:.1f} times real time',
        f'  refused     {recording.refused}'
        + (f', the last: {recording.reason}' if recording.reason else ''),
        f'  dropped     {recording.late} late',
        f'  restarts    {len(tally.restarts)}'
        + (f', the last: {tally.restarts[-1]}' if tally.restarts else ''),
        f'  warnings    {len(tally.warnings)} pictures'
        + (f', the last: {tally.warnings[-1]}' if tally.warnings else ''),
    ]
    return '\n'.join(lines)
