"""Tracking quality in each second of a recording."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.evaluation.comparison import Comparison
from colortrack_ros.evaluation.record import Record

WIDTH_OF_PLOT, HEIGHT_OF_PLOT, LEFT_OF_PLOT = 900, 110, 80
"""As in the timelines above it [px]."""


class Second(NamedTuple):
    """One second.

    :param second: since the first frame, by the stamps.
    :param objects: to be found, over its frames.
    :param found: how many of these were.
    :param false: track rows without an object, over its frames.
    :param switches: number of ID switches.
    """

    second: int
    objects: int
    found: int
    false: int
    switches: int


def per_second(tracks: Record, comparison: Comparison) -> list[Second]:
    """Each second with evaluated frames; empty if the frames have no stamps."""
    stamped = tracks.rows[tracks.rows['stamp'] >= 0]
    frames, first = np.unique(stamped['frame'], return_index=True)
    if len(frames) < 2 or not len(comparison.counts):
        return []
    # Some tables omit frames without tracks; their stamps lie between those of the others.
    stamps = stamped['stamp'][first]
    period = (stamps[-1] - stamps[0]) / (frames[-1] - frames[0]) / NANOSECONDS
    judged = comparison.counts[:, 0]
    times = np.interp(judged, frames, (stamps - stamps[0]) / NANOSECONDS + frames[0] * period)
    before, after = judged < frames[0], judged > frames[-1]
    times[before] = judged[before] * period
    times[after] += (judged[after] - frames[-1]) * period
    seconds = np.floor(times).astype(int)
    switched = {event.frame for event in comparison.switches}
    switches = [
        sum(e.frame == frame for e in comparison.switches) if frame in switched else 0
        for frame in judged.tolist()
    ]
    table = np.column_stack([comparison.counts[:, 1:], switches])
    return [
        Second(second, *table[seconds == second].sum(axis=0).tolist())
        for second in np.unique(seconds).tolist()
    ]


def plot_of(seconds: Sequence[Second]) -> str:
    """An SVG with the share found as bars, false rows below them, and switches as marks."""
    end = seconds[-1].second + 1
    scale = (WIDTH_OF_PLOT - LEFT_OF_PLOT) / end
    most = max(1, *(second.false for second in seconds))
    base, up, down = 62, 50, 26
    parts = [
        f'<svg viewBox="0 0 {WIDTH_OF_PLOT} {HEIGHT_OF_PLOT}" role="img" '
        'aria-label="share of objects found and false tracks in each second">',
        f'<text x="0" y="{base - up + 10}">found</text>',
        f'<text x="0" y="{base + 20}">false</text>',
    ]
    for second, objects, found, false, switches in seconds:
        x, width = LEFT_OF_PLOT + second * scale, max(scale - 1, 0.5)
        said = f'<title>second {second}: {found} of {objects}, {false} false</title></rect>'
        for top, height, color in (
            (base - up * found / max(objects, 1), up * found / max(objects, 1), '#009e73'),
            (base + 2, down * false / most, '#d55e00'),
        ):
            if height:
                parts.append(
                    f'<rect x="{x:.1f}" y="{top:.1f}" width="{width:.1f}" height="{height:.1f}" '
                    f'fill="{color}">{said}'
                )
        if switches:
            parts.append(f'<text x="{x:.1f}" y="{base - up - 2}">{switches}×</text>')
    parts += [
        f'<text x="{LEFT_OF_PLOT + second * scale:.1f}" y="{HEIGHT_OF_PLOT - 6}">{second} s</text>'
        for second in sorted({round(s) for s in np.linspace(0, end - 1, min(end, 6)).tolist()})
    ]
    return '\n'.join([*parts, '</svg>'])
