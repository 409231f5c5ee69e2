"""What ``evaluate`` does with one recording, here or in another process."""

import argparse
from collections.abc import Mapping
from collections.abc import Sequence
from pathlib import Path
import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.bags.reader import is_bag
from colortrack_ros.batch import key_of
from colortrack_ros.batch import Task
from colortrack_ros.batch import TaskError
from colortrack_ros.encodings import writable_bgr
from colortrack_ros.evaluation import compare
from colortrack_ros.evaluation import conditions
from colortrack_ros.evaluation import read_record
from colortrack_ros.evaluation import Record
from colortrack_ros.evaluation import record_of_scene
from colortrack_ros.evaluation import RecordError
from colortrack_ros.evaluation import statistics
from colortrack_ros.evaluation.comparison import Event
from colortrack_ros.evaluation.comparison import FalseTrack
from colortrack_ros.evaluation.per_second import per_second
from colortrack_ros.evaluation.report import picture_of
from colortrack_ros.evaluation.report import Run
from colortrack_ros.evaluation.report import section_of
from colortrack_ros.replay.pictures_of_bag import BagSource
from colortrack_ros.scenes import open_scene
from colortrack_ros.sources import open_source
from colortrack_ros.sources import SourceError
from colortrack_ros.sources.scene import SCENE_PREFIX
from colortrack_ros.tools.tracks_of_bag import tracks_of_bag

TABLE_SUFFIXES = ('.csv', '.txt')

MATCH_OPTIONS = ('radius', 'iou', 'visible')
"""The options of :func:`compare`."""

UNNUMBERED = (
    'frames are missing between the others (lost); message n is taken for frame n - 1 of the truth '
    'all the same. Give as truth a bag with the stamps of all frames'
)
"""What is told if the truth has no stamps, and the tracks have gaps."""

NAMED_OPTIONS = ('truth', 'pictures')
"""Options in which {} stands for the name of the recording."""


def recorded_in(inputs: Sequence[str]) -> list[str]:
    """The inputs, with each folder of tracks replaced by the bags and tables in it."""
    return [one for name in inputs for one in (_within(Path(name)) or [name])]


def _within(folder: Path) -> list[str]:
    if not folder.is_dir() or (folder / 'metadata.yaml').is_file():
        return []
    paths = sorted(folder.iterdir())
    return [str(path) for path in paths if path.suffix.lower() in TABLE_SUFFIXES or is_bag(path)]


def add_match_options(parser: argparse.ArgumentParser) -> None:
    """Add the options for the matching of tracks to the truth."""
    add = parser.add_argument
    add('--radius', type=_positive, default=0.0, help='a match is no farther away [px]')
    add('--iou', type=_overlap, default=0.5, help='or, without --radius, its boxes overlap by it')
    add('--visible', type=_share, default=0.3, help='share in sight from which on objects count')


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < float('inf'):
        raise argparse.ArgumentTypeError(f'expected a positive number, got {text!r}')
    return value


def _share(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value <= 1:
        raise argparse.ArgumentTypeError(f'expected 0..1, got {text!r}')
    return value


def _overlap(text: str) -> float:
    _positive(text)  # with 0 everything would match
    return _share(text)


def evaluation_tasks(inputs: Sequence[str], options: Mapping[str, Any]) -> list[Task]:
    """One task for each input.

    :param options: truth, pictures, radius, iou, visible, topic, and whether a page is written.
    """
    tasks = []
    for spec in inputs:
        name = name_of(spec)
        given = dict(options, tracks=spec)
        for option in NAMED_OPTIONS:
            given[option] = str(given[option] or '').replace('{}', name)
        read = [Path(spec), *(Path(given[option]) for option in NAMED_OPTIONS if given[option])]
        read += [path.with_suffix('.frames') for path in read if path.suffix.lower() == '.csv']
        tasks.append(Task(spec, key_of(given, read), given))
    return tasks


def name_of(spec: str) -> str:
    """The name of the recording with these tracks: that of the file, without the suffix that replay
    adds.
    """
    path = Path(spec)
    return (path.name if path.is_dir() else path.stem).removesuffix('_tracks')


def evaluation_task(
    given: dict[str, Any], stop: threading.Event
) -> tuple[dict[str, Any] | None, str]:
    """Evaluate one input; see Work. The result has the measures, and a section of the page."""
    try:
        return _evaluated(given), ''
    except (RecordError, SourceError, OSError) as error:
        raise TaskError(str(error)) from error


def _evaluated(given: dict[str, Any]) -> dict[str, Any]:
    spec = given['tracks']
    tracks = read_tracks(spec, given['topic'])
    if not given['truth']:
        run = Run(spec, statistics(tracks), tracks, None, {})
        return _content(run, page=given['page'])
    truth = read_truth(given['truth'], given['topic'])
    facts = conditions(tracks)
    numbered = tracks.numbered_as(truth)
    notes = [UNNUMBERED] if facts.get('lost') and numbered is None else []
    tracks = numbered or tracks
    try:
        result = compare(truth, tracks, **{name: given[name] for name in MATCH_OPTIONS})
    except ValueError as error:
        raise RecordError(f'{spec} and {given["truth"]}: {error}') from error
    wanted = given['page'] and given['pictures']
    events: list[Event | FalseTrack] = [*result.switches, *result.false_tracks]
    pictures, lost = _pictures(given['pictures'], events, tracks.stamps) if wanted else ({}, [])
    run = Run(spec, result.measures | facts, tracks, result, pictures)
    return _content(run, page=given['page']) | {'notes': notes + lost}


def _content(run: Run, *, page: bool) -> dict[str, Any]:
    content = {
        'run': run.name,
        'measures': _known(run.measures),
        'section': section_of(run) if page else '',
        'said': run.tracks.said,
    }
    detail = run.comparison
    if detail is None:
        return content
    return content | {
        'objects': {name: _known(measures) for name, measures in detail.objects.items()},
        'switches': [event._asdict() for event in detail.switches],
        'false_tracks': [event._asdict() for event in detail.false_tracks],
        'seconds': [second._asdict() for second in per_second(run.tracks, detail)],
    }


def _known(measures: Mapping[str, Any]) -> dict[str, Any]:
    """Those that are not NaN, which JSON does not have."""
    return {k: v for k, v in measures.items() if not (isinstance(v, float) and np.isnan(v))}


def read_tracks(spec: str, topic: str) -> Record:
    """Tracks or truth from a bag, a table or a scene.

    :raises RecordError: it is none of these, or cannot be read.
    """
    if spec.startswith(SCENE_PREFIX):
        try:
            return record_of_scene(open_scene(spec.removeprefix(SCENE_PREFIX)))
        except ValueError as error:
            raise RecordError(f'{spec}: {error}') from error
    path = Path(spec)
    return tracks_of_bag(path, topic) if is_bag(path) else read_record(path)


def read_truth(spec: str, topic: str) -> Record:
    """As :func:`read_tracks`; refuses a truth without frames, by which anything would be perfect.

    :raises RecordError: it cannot be read, or covers no frame.
    """
    truth = read_tracks(spec, topic)
    if not len(truth.frames):
        raise RecordError(f'{spec}: expected a truth of at least one frame, got none')
    return truth


def _pictures(
    source: str, events: Sequence[Event | FalseTrack], stamps: NDArray[np.int64]
) -> tuple[dict[Event | FalseTrack, NDArray[np.uint8]], list[str]]:
    """Pictures of the surroundings of each event, from a bag, a video, pictures or a scene.

    :param stamps: (F,) of the frames [ns], to find them in a bag, since a node may have skipped
        some; empty if the n-th picture is the n-th frame.
    :returns: the pictures, and why others cannot be read.
    :raises SourceError: it cannot be opened.
    """
    from_bag = is_bag(Path(source))
    by_stamp = from_bag and len(stamps) > 0
    wanted: dict[int, list[Event | FalseTrack]] = {}
    for event in events:
        key = int(stamps[event.frame]) if by_stamp else event.frame
        wanted.setdefault(key, []).append(event)
    found: dict[Event | FalseTrack, NDArray[np.uint8]] = {}
    frames = BagSource(Path(source), '') if from_bag else open_source(source)
    number, lost = 0, []
    try:
        while wanted:
            try:
                frame = frames.read()
            except SourceError as error:
                lost.append(f'pictures: {error}')
                continue
            if frame is None:
                break
            for event in wanted.pop(frame.stamp if by_stamp else number, []):
                found[event] = picture_of(event, writable_bgr(frame))
            number += 1
    finally:
        frames.close()
    return found, lost
