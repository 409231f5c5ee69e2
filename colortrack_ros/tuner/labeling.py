"""Labels made by hand: marks by ID, the survey, and the labels derived from both."""

from collections.abc import Callable
import itertools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.evaluation import read_record
from colortrack_ros.evaluation import RecordError
from colortrack_ros.tuner.folder import Folder
from colortrack_ros.tuner.footage import Footage
from colortrack_ros.tuner.footage import RecordedFootage
from colortrack_ros.tuner.labels import csv_of
from colortrack_ros.tuner.labels import GUESSED
from colortrack_ros.tuner.labels import Labels
from colortrack_ros.tuner.labels import Mark
from colortrack_ros.tuner.labels import mot_of
from colortrack_ros.tuner.labels import NONE
from colortrack_ros.tuner.labels import propose
from colortrack_ros.tuner.labels import sightings_of
from colortrack_ros.tuner.settings import Settings
from colortrack_ros.tuner.survey import Survey

FORMATS: dict[str, Callable[[dict[int, Labels]], str]] = {'.csv': csv_of, '.txt': mot_of}
"""Writers by suffix of the file: a table with a header, or MOTChallenge."""

MOST_IDS = 1000
"""Maximum number of labeled objects. Assumed: more than anybody clicks on by hand."""


class Labeling:
    """Marks, and the labels derived from them.

    :param footage: a recording can be labeled, a camera cannot.
    """

    def __init__(self, footage: Footage) -> None:
        self._footage = footage
        self._marks: dict[int, dict[int, Mark]] = {}
        self._labels: dict[int, Labels] = {}
        self._survey: Survey | None = None
        self._loaded: list[NDArray[np.void]] = []

    def survey(self, settings: Settings) -> None:
        """Start a survey of the whole recording with these settings.

        :raises ValueError: it is a camera.
        """
        if not isinstance(self._footage, RecordedFootage):
            raise ValueError('labels: expected a recording, such as a video or a bag; got a camera')
        self._stop()
        self._survey = Survey(self._footage.open_again(), settings)

    def _stop(self) -> None:
        if self._survey is not None:
            self._survey.close()
        self._survey, self._loaded = None, []

    def work(self) -> bool:
        """Continue the survey for a moment; returns whether there is more to do."""
        if self._survey is None or self._survey.done:
            return False
        if self._survey.work():
            return True
        self._propose(*self._marks)
        return False

    def mark(self, name: int, frame: int, mark: Mark | None) -> None:
        """Mark the position of an object in a frame; None removes the mark.

        :raises ValueError: the frame or the ID is invalid.
        """
        if not (0 <= name <= MOST_IDS and 0 <= frame <= self._footage.last):
            expected = f'an ID from 0 to {MOST_IDS}, and a frame up to {self._footage.last}'
            raise ValueError(f'labels: expected {expected}; got {name} and {frame}')
        marks = self._marks.setdefault(name, {})
        if mark is not None:
            marks[frame] = mark
        elif marks.pop(frame, None) is None:
            raise ValueError(f'labels: {name} has no mark in frame {frame}')
        if not marks:
            del self._marks[name]
            self._labels.pop(name, None)
        else:
            self._propose(name)

    def state(self) -> dict[str, Any]:
        """Progress of the survey, and for each ID its marks and the states of its frames."""
        seen = len(self._survey.frames if self._survey else self._loaded)
        done = self._survey.done if self._survey else bool(self._loaded)
        labels = [
            {
                'id': name,
                'marks': sorted(self._marks[name]),
                'labeled': int(np.count_nonzero(found.state)),
                'guessed': int(np.count_nonzero(found.state == GUESSED)),
                'stretches': _stretches(found),
            }
            for name, found in sorted(self._labels.items())
        ]
        return {'seen': seen, 'done': done, 'labels': labels}

    def at(self, frame: int) -> list[dict[str, Any]]:
        """The labels of a frame."""
        return [
            {
                'id': name,
                'box': found.box[frame].tolist(),
                'guessed': bool(found.state[frame] == GUESSED),
                'marked': frame in self._marks[name],
            }
            for name, found in sorted(self._labels.items())
            if 0 <= frame < len(found.state) and found.state[frame] != NONE
        ]

    def load(self, folder: Folder, path: str) -> None:
        """Load an existing truth to correct it: from then on marks choose among its labels.

        :raises ValueError: the file must not be read, or has no labels.
        """
        try:
            truth = read_record(folder.path(path, tuple(FORMATS)))
        except RecordError as error:
            raise ValueError(str(error)) from error
        names, first = np.unique(truth.rows['id'], return_index=True)
        if not len(names) or names[0] < 0 or names[-1] > MOST_IDS:
            raise ValueError(f'{path}: expected IDs from 0 to {MOST_IDS}, got {names.tolist()}')
        self._stop()
        self._loaded = sightings_of(truth)
        rows = truth.rows[first]
        self._marks = {
            int(row['id']): {int(row['frame']): Mark((row['u'], row['v'], 0, 0), int(row['id']))}
            for row in rows
        }
        self._labels = {}
        self._propose(*self._marks)

    def save(self, folder: Folder, path: str, *, overwrite: bool) -> None:
        """Write all labels.

        :raises ValueError: there are none, or the file must not be written, or exists.
        """
        if not self._labels:
            raise ValueError('labels: there are none yet')
        if folder.exists(path, tuple(FORMATS)) and not overwrite:
            raise ValueError(f'{path}: is there already; save again to overwrite it')
        (form,) = (form for suffix, form in FORMATS.items() if path.endswith(suffix))
        folder.write(path, form(self._labels), tuple(FORMATS))

    def _propose(self, *names: int) -> None:
        frames = self._survey.frames if self._survey else self._loaded
        for name in names:
            self._labels[name] = propose(self._marks[name], frames)


def _stretches(labels: Labels) -> list[tuple[int, int, int]]:
    """First frame, last frame plus one, and state of each stretch with labels."""
    (changes,) = np.diff(labels.state).nonzero()
    ends = [0, *(changes + 1).tolist(), len(labels.state)]
    parts = itertools.pairwise(ends)
    return [(a, b, int(labels.state[a])) for a, b in parts if b > a and labels.state[a] != NONE]
