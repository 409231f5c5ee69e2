"""What each part of the window tracker is worth: ``python benchmark/windows_ablation.py FOLDER``.

FOLDER is as of real_windows.py. Each row leaves one part out, or takes another in its place; the
figures are those of real_windows.py.
"""

from contextlib import ExitStack
from unittest.mock import patch

import cv2
import numpy as np
from real_windows import folders_of
from real_windows import judged
from real_windows import options_of
from real_windows import ours
from real_windows import sequence

from colortrack_ros.windows.correlation import CorrelationFilter

ROOM = 'colortrack_ros.windows.'
NOWHERE_ELSE = np.zeros((1, 2))
WHOLE = CorrelationFilter._cut_off


def uncut(filter_):
    """In the place of CorrelationFilter._cut_off: the filter as wide as what is looked at."""
    filter_._inside = np.ones_like(filter_._inside)
    return WHOLE(filter_)


def by_peak(appearance, seen):
    """In the place of Appearance.likeness: the peak as the only witness."""
    return float(np.clip(seen.peak / appearance._usual[0], 0, 1))


PARTS = {
    'as it is': ({}, {}),
    'no appearance, the template alone': ({'appearance': False}, {}),
    'no Kalman filter (WM)': ({'method': 'WM'}, {}),
    'with the swarm (WM+K+PSO)': ({'method': 'WM+K+PSO'}, {}),
    'no template, appearance alone': ({'min_similarity': 1.0}, {}),
    'filter not cut off at the box': ({}, {'correlation.CorrelationFilter._cut_off': uncut}),
    'no colors in the answer': ({}, {'appearance.COLOR_SHARE': 0.0}),
    'the peak as the only witness': ({}, {'appearance.Appearance.likeness': by_peak}),
    'no change of size': ({}, {'appearance.Appearance.resize': lambda *_: None}),
    'the filter learns nothing new': ({}, {'correlation.FILTER_RATE': 0.0}),
    'the colors learn nothing new': ({}, {'colors.COLOR_RATE': 0.0}),
    'lost targets looked for at their last place alone': (
        {},
        {'sighting.SPIRAL': NOWHERE_ELSE},
    ),
}


def main() -> None:
    given = options_of(__doc__).parse_args()
    cv2.setNumThreads(1)
    folders = folders_of(given.folder)
    print('| | success | on nothing |\n|---|---|---|')
    for name, (settings, changes) in PARTS.items():
        with ExitStack() as changed:
            for place, value in changes.items():
                changed.enter_context(patch(ROOM + place, value))
            results = [
                judged(ours(**settings), *sequence(folder, given.frames)) for folder in folders
            ]
        print('| {} | {:.0f} % | {:.0f} % |'.format(name, *np.mean(results, axis=0)), flush=True)


if __name__ == '__main__':
    main()
