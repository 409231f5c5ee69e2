"""A self-contained HTML report: measures, timelines of objects and tracks, and ID switches."""

import base64
from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence
from html import escape
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.evaluation.comparison import Comparison
from colortrack_ros.evaluation.comparison import Event
from colortrack_ros.evaluation.comparison import FalseTrack
from colortrack_ros.evaluation.per_second import per_second
from colortrack_ros.evaluation.per_second import plot_of
from colortrack_ros.evaluation.record import Record

TRACK_COLORS = (
    '#0072b2',
    '#e69f00',
    '#009e73',
    '#cc79a7',
    '#56b4e9',
    '#d55e00',
    '#8a7a00',
    '#666666',
)
"""Colors that color-blind people can distinguish (Okabe and Ito 2008; yellow darkened for
white)."""

WIDTH, LINE = 900, 22
"""Width of a timeline, and height of one of its lines [px]. Assumed, for the look of it."""

AROUND = 120
"""Half the side of the picture of a switch or a false track [px]: the page shows it unscaled, up to
240 px wide."""

STYLE = """
:root { color-scheme: light dark; --line: #8886; }
body { font: 15px/1.5 system-ui, sans-serif; margin: 2em auto; max-width: 62em; padding: 0 1em; }
table { border-collapse: collapse; margin: 1em 0; }
th, td { border-bottom: 1px solid var(--line); padding: .15em .8em; text-align: right; }
th:first-child, td:first-child { text-align: left; }
svg { width: 100%; height: auto; }
svg text { font: 11px system-ui, sans-serif; fill: currentColor; }
figure { display: inline-block; margin: .5em; } img { max-width: 240px; }
.scroll { overflow-x: auto; }
"""


class Run(NamedTuple):
    """One run in the report.

    :param name: of the run.
    :param measures: of the run.
    :param tracks: its tracks.
    :param comparison: with the truth, if there is one.
    :param pictures: of some of its switches and false tracks, BGR.
    """

    name: str
    measures: Mapping[str, float]
    tracks: Record
    comparison: Comparison | None
    pictures: Mapping[Event | FalseTrack, NDArray[np.uint8]]


def page_of(
    measures: Mapping[str, Mapping[str, float]],
    sections: Sequence[str],
    parameters: Sequence[Sequence[str]],
) -> str:
    """The page.

    :param measures: by run.
    :param sections: of the runs.
    :param parameters: those that differ between the runs: a row with the names of the runs, then
        the name and values of each parameter.
    """
    parts = [
        '<!doctype html><html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width"><title>Tracks evaluated</title>',
        f'<style>{STYLE}</style></head><body><h1>Tracks evaluated</h1>',
        _table(measures),
    ]
    if parameters:
        parts += ['<h3>Parameters that differ</h3>', _grid(parameters[0], parameters[1:])]
    return '\n'.join([*parts, *sections, '</body></html>\n'])


def section_of(run: Run) -> str:
    """The section of one run."""
    return '\n'.join([f'<h2>{escape(run.name)}</h2>', *_run(run)])


def _table(measures: Mapping[str, Mapping[str, float]]) -> str:
    """A table with one column for each run, or one line if there are more runs than measures."""
    names = list(dict.fromkeys(name for some in measures.values() for name in some))
    cells = {
        run: [f'{some.get(n, float("nan")):.4g}' for n in names] for run, some in measures.items()
    }
    head, lines = (
        ['measure', *cells],
        [[n, *c] for n, *c in zip(names, *cells.values(), strict=True)],
    )
    if len(cells) > len(names):
        head, lines = ['', *names], [[run, *c] for run, c in cells.items()]
    return _grid(head, lines)


def _grid(head: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    rows = [''.join(f'<td>{escape(cell)}</td>' for cell in line) for line in lines]
    top = ''.join(f'<th>{escape(name)}</th>' for name in head)
    body = ''.join(f'<tr>{row}</tr>' for row in rows)
    return f'<div class="scroll"><table><tr>{top}</tr>{body}</table></div>'


def _run(run: Run) -> Iterator[str]:
    if run.tracks.said:
        yield '<h3>What the nodes warned of</h3>'
        lines = [[text, str(seconds)] for text, seconds in run.tracks.said.items()]
        yield _grid(['', 'seconds'], lines)
    if run.comparison is None:
        yield '<p>When each track existed; pale: coasting.</p>'
        yield _timeline([(f'track {k}', bars) for k, bars in _tracks(run.tracks)], run.tracks)
        return
    yield '<p>The track that each object was found as; empty: not found.</p>'
    found = [(f'object {k}', bars) for k, bars in _objects(run.comparison)]
    yield _timeline(found, run.tracks)
    if seconds := per_second(run.tracks, run.comparison):
        yield '<p>Share of objects found in each second, false rows, and switches.</p>'
        yield plot_of(seconds)
    for title, events in (
        ('Switches', run.comparison.switches),
        ('False tracks', run.comparison.false_tracks),
    ):
        yield from _events(title, events, run.pictures)


def _events(
    title: str,
    events: Sequence[Event] | Sequence[FalseTrack],
    pictures: Mapping[Event | FalseTrack, NDArray[np.uint8]],
) -> Iterator[str]:
    if not events:
        return
    yield f'<h3>{title}</h3>'
    for event in events:
        if event in pictures:
            coded = base64.b64encode(cv2.imencode('.jpg', pictures[event])[1].tobytes()).decode()
            yield f'<figure><img alt="{_said(event)}" src="data:image/jpeg;base64,{coded}">'
            yield f'<figcaption>{_said(event)}</figcaption></figure>'
    yield _grid(events[0]._fields, [[f'{value:.0f}' for value in event] for event in events])


def _said(event: Event | FalseTrack) -> str:
    if isinstance(event, Event):
        return f'frame {event.frame}: object {event.object}, {event.before} → {event.after}'
    return f'frame {event.frame}: track {event.track}, {event.frames} frames'


Bar = tuple[int, int, int, bool]
"""First frame, last frame, track, and whether it coasted."""


def _objects(comparison: Comparison) -> Iterator[tuple[int, list[Bar]]]:
    for one in comparison.objects:
        rows = comparison.matches[comparison.matches[:, 1] == one]
        yield one, _bars(rows[:, 0], rows[:, 2], np.zeros(len(rows), bool))


def _tracks(record: Record) -> Iterator[tuple[int, list[Bar]]]:
    for one in np.unique(record.rows['id']).tolist():
        rows = record.rows[record.rows['id'] == one]
        yield one, _bars(rows['frame'], rows['id'], rows['coasting'])


def _bars(frames: NDArray[np.int64], names: NDArray, coasting: NDArray[np.bool_]) -> list[Bar]:
    """Runs of consecutive frames with the same track and the same coasting state."""
    if not len(frames):
        return []
    new = (np.diff(names) != 0) | (np.diff(coasting.astype(int)) != 0)
    # Truth may be labeled in every fifth frame, say: a gap is longer than the usual step.
    steps = np.diff(frames)
    new |= steps > (np.median(steps) if len(steps) else 1) * 1.5
    first = np.flatnonzero(np.append(True, new))
    last = np.append(first[1:] - 1, len(frames) - 1)
    columns = frames[first], frames[last], names[first], coasting[first]
    return list(zip(*(column.tolist() for column in columns), strict=True))


def _timeline(lines: Sequence[tuple[str, Sequence[Bar]]], tracks: Record) -> str:
    end = int(tracks.frames[-1]) + 1 if len(tracks.frames) else 1
    left, scale = 80, (WIDTH - 80) / end
    height = LINE * (len(lines) + 1)
    parts = [f'<svg viewBox="0 0 {WIDTH} {height}" role="img" aria-label="timeline of tracks">']
    for row, (name, bars) in enumerate(lines):
        top = row * LINE
        parts.append(f'<text x="0" y="{top + 15}">{escape(name)}</text>')
        for first, last, track, coasting in bars:
            x, width = left + first * scale, max((last + 1 - first) * scale, 1.0)
            color = TRACK_COLORS[track % len(TRACK_COLORS)]
            parts.append(
                f'<rect x="{x:.1f}" y="{top + 3}" width="{width:.1f}" height="{LINE - 6}" '
                f'fill="{color}" opacity="{0.35 if coasting else 1}">'
                f'<title>track {track}, frames {first} to {last}</title></rect>'
            )
            if width > 24:
                parts.append(
                    f'<text x="{x + 3:.1f}" y="{top + 15}" style="fill:#fff">{track}</text>'
                )
    parts += [
        f'<text x="{left + frame * scale:.1f}" y="{height - 6}" text-anchor="end">{frame}</text>'
        for frame in np.linspace(0, end - 1, 6).astype(int).tolist()
    ]
    return '\n'.join([*parts, '</svg>'])


def picture_of(event: Event | FalseTrack, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The surroundings of a switch or a false track, which a cross marks."""
    u, v = round(event.u), round(event.v)
    rows = slice(max(v - AROUND, 0), max(v + AROUND, 1))
    columns = slice(max(u - AROUND, 0), max(u + AROUND, 1))
    part = image[rows, columns].copy()
    cv2.drawMarker(
        part, (u - columns.start, v - rows.start), (255, 255, 255), cv2.MARKER_CROSS, 18, 3
    )
    cv2.drawMarker(part, (u - columns.start, v - rows.start), (0, 0, 0), cv2.MARKER_CROSS, 18, 1)
    return part
