"""What labeling a real video costs a person: clicks and keys, and the minutes that they take.

``python benchmark/labels.py``: two of three equal cups of a shell game, two of three bottle caps.
In place of the person, the truth says where the labels are wrong; its every answer is a click.
"""

import argparse
from pathlib import Path
import tempfile
import time

import numpy as np

from colortrack_ros.evaluation import compare
from colortrack_ros.evaluation import read_record
from colortrack_ros.evaluation import Record
from colortrack_ros.sources import open_source
from colortrack_ros.tuner.folder import Folder
from colortrack_ros.tuner.footage import RecordedFootage
from colortrack_ros.tuner.running import RunningNodes
from colortrack_ros.tuner.session import Session

REAL = Path(__file__).parents[2] / 'shared' / 'data' / 'real'

THINK, POINT, PRESS, KEY = 1.35, 1.1, 0.2, 0.28
"""Seconds of deciding what to do, of pointing at it, of a click there, and of a key: the
keystroke-level model (Card, Moran and Newell 1980)."""

CLICK = THINK + POINT + PRESS
WATCH = 2 * 300 / 30
"""Seconds of watching the recording once for each object."""

CLIPS = {'cups': (2, 3), 'caps': (1, 2)}
"""Clips of 300 and 225 frames, and two objects of each."""

RADIUS, MOST_ROUNDS = 20.0, 60


class Person:
    """Counts what is done to the page."""

    def __init__(self, session: Session) -> None:
        self.session, self.clicks, self.keys, self.boxes = session, 0, 0, 0

    def click(self, command: str, **fields: object) -> None:
        """Point at something, and click."""
        self.session.do(command, fields)
        self.clicks += 1

    def seek(self, frame: int) -> None:
        """By a click on the timeline, and the arrow keys for what that misses, three on average."""
        self.click('seek', frame=frame)
        self.keys += 3

    def mark(self, row: np.void, *, box: bool = False) -> None:
        """Click on an object, or draw its box, which is to point twice."""
        self.keys += 1  # of the ID
        width, height = (round(row['w']), round(row['h'])) if box else (1, 1)
        place = {'u': round(row['u'] - width / 2), 'v': round(row['v'] - height / 2)}
        size = {'width': width, 'height': height}
        self.click('label', id=int(row['id']), frame=int(row['frame']), **place, **size)
        self.boxes += box

    @property
    def seconds(self) -> float:
        """That all this takes."""
        return self.clicks * CLICK + self.boxes * POINT + self.keys * KEY + WATCH


def wrong(labels: Record, truth: Record, name: int) -> np.void | None:
    """The row of the truth at the first frame in which an object's label is not on it."""
    for row in truth.rows[(truth.rows['id'] == name) & (truth.rows['visible'] >= 0.3)]:
        if row['frame'] in truth.frames:
            mine = labels.rows_of(int(row['frame']))
            mine = mine[mine['id'] == name]
            away = np.hypot(mine['u'] - row['u'], mine['v'] - row['v'])
            if not len(mine) or away[0] > RADIUS:
                return row
    return None


def mend(
    session: Session, person: Person, truth: Record, names: tuple[int, ...], path: Path
) -> None:
    """Click the first object that is labeled wrongly, until none is or it has taken long."""
    clicked = set()
    for _ in range(MOST_ROUNDS):
        session.do('save_labels', {'path': path.name, 'overwrite': True})
        found = [wrong(read_record(path), truth, name) for name in names]
        row = min((r for r in found if r is not None), key=lambda r: r['frame'], default=None)
        if row is None:
            return
        person.seek(int(row['frame']))
        key = int(row['id']), int(row['frame'])
        person.mark(row, box=key in clicked)
        clicked.add(key)


def labeled(clip: str, names: tuple[int, ...], folder: Path) -> dict[str, float]:
    """Label some objects of a clip as a person would, and judge what comes of it."""
    truth = read_record(REAL / f'{clip}.csv')
    truth = Record(truth.rows[np.isin(truth.rows['id'], names)], truth.frames)
    spec = str(REAL / f'{clip}.mp4')
    session = Session(
        RecordedFootage(spec, lambda: open_source(spec)), Folder(folder), RunningNodes()
    )
    person = Person(session)
    first = truth.rows_of(0)
    u, v = float(first[0]['u']), float(first[0]['v'])
    picked = {'u': round(u), 'v': round(v), 'width': 1, 'height': 1}
    person.click('sample', color='cup', is_it=True, **picked)
    person.click('survey')
    began = time.monotonic()
    while session.work():
        pass
    waited = time.monotonic() - began
    for row in first:
        person.mark(row)
    path = folder / 'truth.csv'
    mend(session, person, truth, names, path)
    person.clicks += 1  # to save
    result = compare(truth, read_record(path), radius=RADIUS)
    return {
        'clicks': person.clicks,
        'of which boxes': person.boxes,
        'keys': person.keys,
        'seconds of the tracker': waited,
        'minutes': (person.seconds + waited) / 60,
        'IDF1': result.measures['idf1'],
        'RMSE [px]': result.measures['rmse'],
    }


def main() -> None:
    if not REAL.exists():
        print(f'{REAL} is not there')
        return
    with tempfile.TemporaryDirectory() as folder:
        for clip, names in CLIPS.items():
            print(clip, {k: round(v, 2) for k, v in labeled(clip, names, Path(folder)).items()})


if __name__ == '__main__':
    argparse.ArgumentParser(description=__doc__).parse_args()
    main()
