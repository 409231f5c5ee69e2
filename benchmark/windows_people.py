"""All people of a clip followed at once by windows: ``python benchmark/windows_people.py FOLDER``.

FOLDER holds folders of MOTChallenge, see real_contours.py. Followed is everybody who is labeled
without a gap for LEAST frames (LEAST_OF_SHORT in clips of less than SHORT) from the first one on in
which 90 % of the box is seen and in the picture, and it is as high as TALL, for MOST frames at
most. Success and on nothing are those of real_windows.py; right and said: share of the frames with
a box said to be the target now that overlaps the truth by more than half of their union. Means of
the people. ``--alone`` gives each a tracker of its own, ``--backwards`` shows the clip from its
end.
"""

import argparse
from pathlib import Path

import cv2
import numpy as np
from real_contours import Clip
from real_contours import clips_of
from real_contours import overlaps
from real_windows import NOTHING
from real_windows import SUCCESS

from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import Frame
from colortrack_ros.windows import WindowConfig
from colortrack_ros.windows import WindowTracker
from colortrack_ros.windows.starting import are_followable

LEAST, LEAST_OF_SHORT, SHORT, TALL, MOST, SEEN = 60, 40, 200, 60, 200, 0.9
"""Frames, frames, frames, px, frames, share of a box: enough to cross somebody. Assumed."""

Labels = dict[int, dict[int, np.ndarray]]
"""Of each person, by frame: u, v, w, h, visible."""


def labels_of(clip: Clip, count: int, backwards: bool) -> Labels:
    """The people of a clip of so many pictures."""
    people: Labels = {}
    for k, rows in clip.truth().items():
        for row in rows:
            people.setdefault(int(row[0]), {})[count - 1 - k if backwards else k] = row[1:]
    return {i: own for i, own in people.items() if any(row[4] > 0 for row in own.values())}


def span_of(own: dict[int, np.ndarray], count: int, picture: np.ndarray) -> range:
    """The frames in which somebody is followed; none if that is too few.

    :param picture: the first one, of count.
    """
    frames = np.array(sorted(own))
    run = max(np.split(frames, np.flatnonzero(np.diff(frames) != 1) + 1), key=len)
    size = np.array(picture.shape[1::-1])
    for k in run.tolist():
        place, side, seen = own[k][:2], own[k][2:4], own[k][4]
        low, high = np.maximum(place - side / 2, 0), np.minimum(place + side / 2, size)
        shown = np.clip(high - low, 0, None).prod() / side.prod()
        box = [[*(place - side / 2), *side]]
        if min(seen, shown) >= SEEN and side[1] >= TALL:
            end = min(int(run[-1]) + 1, k + MOST)
            least = LEAST_OF_SHORT if count < SHORT else LEAST
            good = are_followable(Frame(picture, 'bgr8', 0), np.array(box), WindowConfig()).all()
            return range(k, end) if good and end - k >= least else range(0)
    return range(0)


def followed(clip: Clip, alone: bool, backwards: bool) -> list[np.ndarray]:
    """Of everybody who is followed, intersection over union and whether said to be seen, (K, 2)."""
    pictures = sorted((clip.path / 'img1').iterdir(), reverse=backwards)
    first = cv2.imread(str(pictures[0]))
    people = labels_of(clip, len(pictures), backwards)
    spans = {i: span_of(own, len(pictures), first) for i, own in people.items()}
    spans = {i: span for i, span in sorted(spans.items()) if span}
    config = WindowConfig(max_targets=max(len(spans), 1))
    together = WindowTracker(config)
    trackers = {i: WindowTracker(config) if alone else together for i in spans}
    said: dict[int, list[tuple[float, bool]]] = {i: [] for i in spans}
    track_of: dict[int, int] = {}
    for k, path in enumerate(pictures[: max(s.stop for s in spans.values())]):
        frame = Frame(cv2.imread(str(path)), 'bgr8', round(k / clip.rate() * 1e9))
        for i, span in spans.items():
            if k == span.start:
                u, v, w, h = people[i][k][:4]
                trackers[i].start([[u - w / 2, v - h / 2, w, h]])
                track_of[i] = 1 if alone else len(track_of) + 1
        rows = {t: t.update(frame).rows for t in dict.fromkeys(trackers.values())}
        for i, span in spans.items():
            if span.start < k < span.stop:
                own = rows[trackers[i]]
                own = own[own['track_id'] == track_of[i]]
                box = np.array([[float(r[n]) for n in ('u', 'v', 'box_w', 'box_h')] for r in own])
                found = overlaps(people[i][k][None, :4], box.reshape(-1, 4)).max(initial=0.0)
                said[i].append((float(found), bool((own['state'] == CONFIRMED).any())))
    return [np.array(rows) for rows in said.values()]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('folder', type=Path)
    parser.add_argument('--alone', action='store_true', help='each by a tracker of its own')
    parser.add_argument('--backwards', action='store_true', help='from the last picture on')
    given = parser.parse_args()
    cv2.setNumThreads(1)
    print('| | people | success | on nothing | right and said |\n|---|---|---|---|---|')
    every: list[tuple[float, ...]] = []
    for clip in [c for c in clips_of(given.folder) if c.is_folder]:
        own = followed(clip, given.alone, given.backwards)
        figures = [
            (
                np.mean(f > SUCCESS),
                np.mean((s > 0) & (f < NOTHING)),
                np.mean((s > 0) & (f > SUCCESS)),
            )
            for f, s in (rows.T for rows in own)
        ]
        every += figures
        cells = ' | '.join(f'{100 * x:.1f} %' for x in np.mean(figures, axis=0))
        print(f'| {clip.name} | {len(own)} | {cells} |', flush=True)
    cells = ' | '.join(f'{100 * x:.1f} %' for x in np.mean(every, axis=0))
    print(f'| all | {len(every)} | {cells} |')


if __name__ == '__main__':
    main()
