"""Reads the tracks in a bag."""

import contextlib
import dataclasses
from pathlib import Path

import numpy as np

from colortrack_ros.bags import BagError
from colortrack_ros.bags import BagReader
from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import Tracks
from colortrack_ros.evaluation import Record
from colortrack_ros.evaluation import RecordError
from colortrack_ros.evaluation.noise import innovations_of
from colortrack_ros.evaluation.noise import noise_of
from colortrack_ros.evaluation.record import rows_of_tracks
from colortrack_ros.messages import detections_of_serialized_cloud
from colortrack_ros.messages import MessageError
from colortrack_ros.messages import tracks_of_serialized_cloud
from colortrack_ros.node_kit.detections_intake import CLOUD
from colortrack_ros.tools.health_of_bag import health_of


def tracks_of_bag(path: Path, topic: str) -> Record:
    """The recorded tracks, with message n as frame n - 1, and further facts about the recording.

    :param topic: of the tracks; empty: the only one with tracks.
    :raises RecordError: there is no such topic, or several; or the bag cannot be read to its end.
    """
    try:
        with contextlib.closing(BagReader(path)) as reader:
            read = _read(reader, topic)
            detections = _detections_of(reader)
            health, said = health_of(reader)
    except BagError as error:
        raise RecordError(str(error)) from error
    except MessageError as error:
        raise RecordError(f'{path}: {topic}: {error}') from error
    if len(read) != 1:
        names = ', '.join(read) or 'none'
        raise RecordError(f'{path}: expected one topic of tracks, --topic chooses; got {names}')
    (messages,) = read.values()
    parts = [rows_of_tracks(tracks, k) for k, (_, tracks) in enumerate(messages)]
    try:
        record = Record.of(np.concatenate(parts), range(len(parts)))
    except ValueError as error:
        raise RecordError(f'{path}: {error}') from error
    stamps = np.array([tracks.stamp for _, tracks in messages])
    delays = np.array([when - tracks.stamp for when, tracks in messages]) / NANOSECONDS
    # Bags written by replay have the time of the picture: the delay says nothing about the tracker.
    delays = delays if (delays > 0).any() else record.delays
    pairs = [(t, detections[t.stamp]) for _, t in messages if t.stamp in detections]
    conditions = noise_of(pairs) | innovations_of(pairs) | health
    return dataclasses.replace(
        record, delays=delays, stamps=stamps, conditions=conditions, said=said
    )


def _read(reader: BagReader, topic: str) -> dict[str, list[tuple[int, Tracks]]]:
    """For each topic of tracks, log time [ns] and tracks of each message.

    :raises MessageError: the requested topic has something else.
    """
    read = {}
    for cloud in reader.topics:
        if cloud.kind != CLOUD or topic not in ('', cloud.name):
            continue
        try:
            read[cloud.name] = [
                (when, tracks_of_serialized_cloud(cdr)) for when, cdr in reader.messages(cloud)
            ]
        except MessageError:
            if topic:
                raise
    return read


def _detections_of(reader: BagReader) -> dict[int, Detections]:
    """The detections of the first topic that has any, by their stamps."""
    for cloud in reader.topics:
        if cloud.kind == CLOUD:
            with contextlib.suppress(MessageError):
                read = (detections_of_serialized_cloud(cdr) for _, cdr in reader.messages(cloud))
                return {detections.stamp: detections for detections in read}
    return {}
