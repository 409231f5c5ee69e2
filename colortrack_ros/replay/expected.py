"""``replay --expect``: compares the tracks with those of an earlier run."""

from collections import defaultdict
from collections.abc import Iterator
from collections.abc import Mapping
import csv
import io
import math
from pathlib import Path

import cv2
import numpy as np
import scipy

from colortrack_ros.data import CORNER
from colortrack_ros.data import Tracks
from colortrack_ros.files import open_file
from colortrack_ros.node_kit.runtime import StartError
from colortrack_ros.replay.outputs import COLUMNS
from colortrack_ros.replay.outputs import lines_of
from colortrack_ros.replay.outputs import Output
from colortrack_ros.replay.recordings import Item

ABSOLUTE, RELATIVE = 1e-3, 1e-4
"""Differences that are ignored, since versions of the libraries round differently."""
SHOWN = 20
"""How many differences are printed: a screenful."""

Line = Mapping[str, float]


class ExpectedOutput(Output):
    """Compares the tracks with a file of ``--csv``.

    :ivar differences: one line for each value that differs and for each missing or extra track.
    :raises StartError: the file is not such a table.
    """

    def __init__(self, path: Path) -> None:
        self.differences: list[str] = []
        self._expected: dict[int, dict[int, Line]] = defaultdict(dict)
        try:
            with open_file(path) as file:
                table = csv.DictReader(io.TextIOWrapper(file, 'utf-8-sig', newline=''))
                missing = [name for name in COLUMNS if name not in (table.fieldnames or ())]
                if set(missing) - set(CORNER):  # which tables of before have not
                    raise ValueError(f'no column {", ".join(missing)}')
                for texts in table:
                    line = {name: float(texts[name]) for name in COLUMNS if name not in missing}
                    self._expected[int(texts['stamp'])][int(line['track_id'])] = line
        except (ValueError, KeyError, TypeError, csv.Error) as error:
            raise StartError(f'{path}: expected a table that --csv wrote: {error!r}') from error

    def write(self, number: int, item: Item, tracks: Tracks) -> None:
        """Compare the tracks of a frame."""
        expected = self._expected.pop(tracks.stamp, {})
        lines = [dict(zip(COLUMNS, line, strict=True)) for line in lines_of(number, tracks)]
        found = {int(line['track_id']): line for line in lines}
        for track in sorted(expected.keys() | found.keys()):
            where = f'frame {number}, track {track}'
            if track not in found:
                self.differences.append(f'{where}: is missing')
            elif track not in expected:
                self.differences.append(f'{where}: is not expected')
            else:
                self.differences += _differences(where, found[track], expected[track])

    def close(self) -> None:
        """Report the expected frames that never came."""
        for lines in self._expected.values():
            self.differences += [
                f'frame {line["frame"]:.0f}, track {track}: no frame with the stamp of this one'
                for track, line in lines.items()
            ]

    def report(self) -> str:
        """The first differences, and their possible cause; empty if there are none."""
        if not self.differences:
            return ''
        more = len(self.differences) - SHOWN
        shown = self.differences[:SHOWN] + ([f'and {more} more'] if more > 0 else [])
        return '\n'.join(
            [*shown, f'these tracks are of {versions()}; other versions may round differently']
        )


def versions() -> str:
    """The versions of the libraries that the results depend on."""
    return f'OpenCV {cv2.__version__}, NumPy {np.__version__}, SciPy {scipy.__version__}'


def _differences(where: str, found: Line, expected: Line) -> Iterator[str]:
    for name, was in list(expected.items())[2:]:
        is_ = float(found[name])
        if not math.isclose(is_, was, rel_tol=RELATIVE, abs_tol=ABSOLUTE):
            yield f'{where}: {name} is {is_:g}, expected {was:g}, a difference of {is_ - was:+.3g}'
