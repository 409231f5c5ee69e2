"""Measures of tracks without ground truth."""

import numpy as np

from colortrack_ros.evaluation.record import Record

STRAIGHT = 1.5
"""Largest difference between the numbers of consecutive frames: more than 1, less than 2."""

JUMP_SIGMAS = 4.0
"""A longer step, in standard deviations of the prediction from the published state, is a jump: by
chance one in 3,000 is, exp(-8) in two dimensions."""


def statistics(tracks: Record) -> dict[str, float]:
    """Measures over all tracks.

    :return: frames; tracks; tracks_a_frame, mean; length, median [frames]; short: share of the
        tracks of less than ten frames; gaps: number of times a track was absent between two of its
        rows; coasting: share of the rows; jumps: share of the steps longer than JUMP_SIGMAS by the
        track's own covariance; sigma: median standard deviation of a position [px]; and those of
        conditions().
    """
    rows = tracks.rows[np.lexsort((tracks.rows['frame'], tracks.rows['id']))]
    names, lengths = np.unique(rows['id'], return_counts=True)
    same = rows['id'][1:] == rows['id'][:-1]
    step = rows['frame'][1:] - rows['frame'][:-1]
    values = {
        'frames': float(len(tracks.frames)),
        'tracks': float(len(names)),
        'tracks_a_frame': len(rows) / max(len(tracks.frames), 1),
        'length': float(np.median(lengths)) if len(names) else 0.0,
        'short': float((lengths < 10).mean()) if len(names) else 0.0,
        'gaps': float(np.count_nonzero(same & (step > STRAIGHT))),
        'coasting': float(rows['coasting'].mean()) if len(rows) else 0.0,
    }
    P = rows['covariance']
    if np.isfinite(P).all() and len(rows):
        values['jumps'] = _jumps(rows[:-1][same], rows[1:][same])
        values['sigma'] = float(np.median(np.sqrt((P[:, 0, 0] + P[:, 1, 1]) / 2)))
    return values | conditions(tracks)


def conditions(tracks: Record) -> dict[str, float]:
    """Measures over all frames, as far as known.

    :return: delay and delay_95: median and 95th percentile from stamp to recording [s]; lost: share
        of frames missing between the others, judging by the stamps; and the conditions of the
        record.
    """
    values = dict(tracks.conditions)
    if len(tracks.delays):
        values['delay'] = float(np.median(tracks.delays))
        values['delay_95'] = float(np.percentile(tracks.delays, 95))
    steps = np.diff(tracks.stamps)
    steps = steps[steps > 0]  # not where a recording restarts
    if len(steps):
        missing = np.round(steps / np.median(steps)) - 1
        lost = missing[steps > STRAIGHT * np.median(steps)].sum()
        values['lost'] = float(lost / (lost + len(tracks.stamps)))
    return values


def _jumps(before: np.ndarray, after: np.ndarray) -> float:
    """Share of the steps that the previous state does not explain."""
    dt = (after['stamp'] - before['stamp']) / 1e9
    far = np.zeros(len(before))
    for i, (x, dx) in enumerate((('u', 'du'), ('v', 'dv'))):
        e = after[x] - before[x] - before[dx] * dt
        P, Q = before['covariance'], after['covariance']
        variance = P[:, i, i] + 2 * dt * P[:, i, i + 2] + dt**2 * P[:, i + 2, i + 2] + Q[:, i, i]
        far += e**2 / np.maximum(variance, np.finfo(float).tiny)
    return float((far > JUMP_SIGMAS**2).mean()) if len(far) else 0.0
