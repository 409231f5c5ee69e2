"""Detector and tracker over a recording: what ``replay`` does."""

import argparse
from collections.abc import Callable
from collections.abc import Iterator
from collections.abc import Sequence
import contextlib
from dataclasses import dataclass
from dataclasses import field
from pathlib import Path
import re
import sys
import threading
import time

from rich.console import Console
from rich.progress import BarColumn
from rich.progress import MofNCompleteColumn
from rich.progress import Progress
from rich.progress import TextColumn
from rich.progress import TimeRemainingColumn

from colortrack_ros.bags import BagError
from colortrack_ros.bags import BagWriteError
from colortrack_ros.bags import is_bag
from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import Tracks
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
from colortrack_ros.replay.setup import parse
from colortrack_ros.replay.setup import read_setup
from colortrack_ros.replay.setup import Setup
from colortrack_ros.replay.targets import PREFIX
from colortrack_ros.replay.targets import Targets


@dataclass
class Answers:
    """Counts of what has been done so far."""

    frames: int = 0
    detections: int = 0
    restarts: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    tracks: set[int] = field(default_factory=set)
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
        """Count a picture for which the detector has advice; empty if it has none."""
        if trouble:
            self.warnings.append(trouble)


def replay(args: Sequence[str], stop: threading.Event) -> int:
    """Do what the command line asks for.

    :param stop: once set, replay ends early, with complete files.
    :return: the exit status.
    """
    arguments = parse(args)
    try:
        return _replay(arguments, stop)
    except (StartError, BagError) as error:
        print(f'replay: {error}', file=sys.stderr)
    except BagWriteError as error:
        print(f'replay: the bag {error}', file=sys.stderr)
    except OSError as error:
        name = re.sub(rf'{re.escape(PREFIX)}[^/]*/', '', str(error.filename or 'output'))
        print(f'replay: {name}: {error.strerror}', file=sys.stderr)
    return 1


def _replay(arguments: argparse.Namespace, stop: threading.Event) -> int:
    from_bag = is_bag(Path(arguments.input))
    setup = read_setup(arguments, from_bag=from_bag)
    path = arguments.output or default_output(arguments.input)
    tally = Answers()
    broken = None
    with contextlib.ExitStack() as stack:
        recording = _open(arguments, setup, from_bag=from_bag)
        stack.callback(recording.close)
        threading.Thread(target=_interrupt, args=(recording, stop), daemon=True).start()
        targets = _targets(arguments, path, recording)
        stack.callback(targets.discard)
        began = time.monotonic()
        with contextlib.ExitStack() as writing:
            outputs = []
            for output in _outputs(arguments, targets, path, recording, setup):
                writing.callback(output.close)
                outputs.append(output)
            try:
                _run(recording, setup, outputs, tally, stop)
            except BagError as error:
                broken = error
        targets.commit()
        seconds = time.monotonic() - began
    print(summary(recording, path, tally, seconds, interrupted=stop.is_set()))
    if broken:
        raise broken
    if recording.lost:
        print(f'replay: {recording.label}: {recording.lost} pictures are lost', file=sys.stderr)
        return 1
    differences = next((o.report() for o in outputs if isinstance(o, ExpectedOutput)), '')
    if differences:
        print(f'the tracks are not those of {arguments.expect}:\n{differences}')
    return 0 if stop.is_set() or (tally.frames and not differences) else 1


def _interrupt(recording: Recording, stop: threading.Event) -> None:
    stop.wait()
    recording.interrupt()


def _run(
    recording: Recording,
    setup: Setup,
    outputs: Sequence[Output],
    tally: Answers,
    stop: threading.Event,
) -> None:
    """Run each frame through the chain, and write the results to the outputs."""

    def detected(detections: Detections, item: Item) -> None:
        tally.detections += len(detections.rows)
        for output in outputs:
            output.write_detections(item, detections)

    def tracked(tracks: Tracks, item: Item) -> None:
        tally.add(item, tracks)
        number = tally.frames + recording.refused
        for output in outputs:
            output.write(number, item, tracks)

    chain = make_chain(setup, detected, tracked, recording.drop, tally.warn)
    with _progress(recording) as advance, contextlib.ExitStack() as at_end:
        at_end.callback(chain.flush)
        for number, item in enumerate(recording.items(), 1):
            if stop.is_set():
                return
            chain.put(item.content, item)
            advance(number)


@contextlib.contextmanager
def _progress(recording: Recording) -> Iterator[Callable[[int], None]]:
    """A progress bar if this is a terminal; yields the function that sets it."""
    columns = TextColumn('{task.description}'), BarColumn(), MofNCompleteColumn()
    bar = Progress(
        *columns,
        TimeRemainingColumn(),
        console=Console(stderr=True),
        disable=not sys.stderr.isatty(),
        transient=True,
    )
    task = bar.add_task('replay', total=recording.total or None)
    with bar:
        yield lambda number: bar.update(task, completed=number)


def default_output(name: str) -> Path:
    """Beside the input: its name with ``_tracks`` in place of the suffix.

    A scene, ``scene:five?rate=25``, gives ``five_tracks`` in the current folder.
    """
    if name.startswith('scene:'):
        return Path(f'{name[6:].partition("?")[0]}_tracks')
    path = Path(name)
    if any(character in path.name for character in '*?['):
        path = path.parent
    path = path.resolve() if path.name in ('', '..') else path
    return path.with_name(f'{path.name if path.is_dir() else path.stem}_tracks')


def _open(arguments: argparse.Namespace, setup: Setup, *, from_bag: bool) -> Recording:
    if from_bag:
        return BagRecording(Path(arguments.input), arguments.topic, setup)
    if arguments.topic:
        raise StartError(f'--topic {arguments.topic}: {arguments.input} is not a bag')
    return SourceRecording(arguments.input, setup.camera)


def _targets(arguments: argparse.Namespace, path: Path, recording: Recording) -> Targets:
    if arguments.video and not recording.has_pictures:
        raise StartError(f'--video: there are no pictures in {recording.label}')
    files = [file for file in (arguments.video, arguments.csv, arguments.mot) if file]
    inputs = [arguments.input, *arguments.params_file]
    inputs += [arguments.expect] if arguments.expect else []
    return Targets(path, files, inputs, force=arguments.force)


def _outputs(
    arguments: argparse.Namespace,
    targets: Targets,
    path: Path,
    recording: Recording,
    setup: Setup,
) -> Iterator[Output]:
    if arguments.expect:
        yield ExpectedOutput(arguments.expect)
    yield BagOutput(targets.staged(path), arguments.storage, setup)
    if arguments.csv:
        yield CsvOutput(targets.staged(arguments.csv))
    if arguments.mot:
        yield MotOutput(targets.staged(arguments.mot))
    if arguments.video:
        yield VideoOutput(targets.staged(arguments.video), recording.rate)


def summary(
    recording: Recording, path: Path, tally: Answers, seconds: float, *, interrupted: bool
) -> str:
    """The result in a few lines."""
    speed = tally.frames / max(seconds, 1e-9)
    real_time = (tally.last - tally.first) / NANOSECONDS / max(seconds, 1e-9)
    lines = [
        f'{recording.label} -> {path}',
        f'  frames      {tally.frames}' + (', interrupted' if interrupted else ''),
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
