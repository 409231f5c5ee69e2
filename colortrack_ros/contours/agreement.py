"""Agreement of edges and foreground about targets, and how targets follow the foreground."""

from dataclasses import dataclass

import numpy as np

from colortrack_ros.columns import Columns
from colortrack_ros.contours.boxes import boxes
from colortrack_ros.contours.config import ContourConfig
from colortrack_ros.contours.filters import Contours
from colortrack_ros.contours.regions import in_common
from colortrack_ros.contours.regions import is_piece
from colortrack_ros.contours.regions import is_same
from colortrack_ros.contours.regions import OwnAreas
from colortrack_ros.contours.regions import resized
from colortrack_ros.contours.regions import shifts
from colortrack_ros.contours.regions import SLACK
from colortrack_ros.contours.regions import slack
from colortrack_ros.contours.regions import SLACK_SHARE
from colortrack_ros.contours.spline import Spline
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.estimation.records import Records

REGION_SIGMA = 3.0
"""Standard deviation of a foreground's sides [px], the same as `sigma` of edges. It matters: IDF1
is 0.63 and 0.79, not 0.88, with half and twice the value on PETS S3.MF1, 0.46 and 0.41, not 0.40,
on TUD Campus (``benchmark/real_contours.py FOLDER --constants agreement.REGION_SIGMA``)."""

SIZE_SECONDS, COVERED_SECONDS = 0.2, 1.0
"""Time constants with which sizes follow their foreground. The longer one holds where it shrinks
and had the target's size until recently, since something may cover it. With 0.1 and 0.4 s in place
of the shorter one IDF1 of the real clip `pets` is 0.56 and 0.71 instead of 0.65, of `onebyone` 0.98
and 0.93 instead of 0.93, which is within their random variation (``benchmark/real_contours.py
FOLDER --constants agreement.SIZE_SECONDS``). Half and twice COVERED_SECONDS: 0.84 and 0.82, not
0.84, on PETS S3.MF1."""


STEADY_SECONDS = 0.4
"""Time constant of a foreground's previous size. The size of something that goes behind a cover, or
comes out, changes by more than the slack in that time if it changes by more than 8 px and a quarter
of itself per second, SLACK / 0.4 and SLACK_SHARE / 0.4. IDF1 of PETS S3.MF1 is 0.84
(benchmark/notes/contours.md), with half and twice the value 0.85 and 0.76."""


ALONE_SECONDS = 1.0
"""After this time as a separate area, something is a separate thing [s]: people fall apart into
pieces for less. IDF1 and precision of TUD Campus are 0.32 and 0.42 (benchmark/notes/contours.md),
with half and twice the value 0.31, 0.38 and 0.32, 0.41."""


HEIGHT_SECONDS = 3.0
"""The usual height of a target is its mean over this time as a separate area [s]: MOTION_SECONDS.
With 2 and 5 s mean MOTA of twelve clips is 0.366 and 0.367, not 0.369."""


@dataclass(frozen=True)
class History(Columns):
    """History of N targets.

    :ivar recent: (N,) whether contour and foreground have agreed lately.
    :ivar rigid: (N,) whether the contour's shape comes from edges.
    :ivar changing: (N, 2) whether the foreground's width, and height, is changing.
    """

    recent: Bools
    rigid: Bools
    changing: Bools


def history(
    records: Records, own: Floats, regions: OwnAreas, stamp: int, longest: float, seconds: float
) -> History:
    """Return the targets' history, and update the foreground's and usual sizes in the records.

    :param records: (N,) with CONTOUR_FIELDS.
    :param own: (N, 4) boxes of the predicted targets [px].
    :param stamp: now [ns].
    :param longest: time for which contours need not agree with their foreground [s].
    :param seconds: since the last frame.
    """
    size = np.nan_to_num(regions.box[:, 2:] - regions.box[:, :2])
    usual = np.stack([records['seen_w'], records['seen_h']], axis=1)
    usual[regions.first < 0] = 0.0
    share = np.where(regions.shared, 0.0, -np.expm1(-seconds / STEADY_SECONDS))
    usual += share[:, None] * (size - usual)
    records['seen_w'], records['seen_h'] = usual.T
    records['piece'] = is_piece(own, regions)
    alone = (regions.first >= 0) & ~regions.shared & ~regions.piece
    records['alone'] += seconds * alone
    share = seconds / np.clip(records['alone'], max(seconds, 1e-9), HEIGHT_SECONDS) * alone
    records['high'] += share * (own[:, 3] - own[:, 1] - records['high'])
    records['single'] |= records['alone'] >= ALONE_SECONDS
    changing = np.abs(size - usual) > SLACK + SLACK_SHARE * np.maximum(size, usual)
    recent = stamp - records['agreed'] <= round(longest * NANOSECONDS)
    return History(recent, ~records['by_area'], changing)


def expected_boxes(contours: Contours, spline: Spline, unseen: Floats) -> Floats:
    """Return boxes of predicted contours, (N, 4), enlarged by one sigma for unseen ones.

    :param unseen: (N,) time without a measurement until the last frame [s].
    """
    n = 2 * contours.nodes.shape[1]
    sigma = np.sqrt(contours.cov[:, :n, :n].trace(axis1=1, axis2=2) / n) * (unseen > 0)
    return boxes(spline.outline(contours.nodes)) + sigma[:, None] * [-1, -1, 1, 1]


def believed(
    before: Floats, after: Floats, regions: OwnAreas, past: History, clear: Bools
) -> Bools:
    """Return where edges are believed, (N,): where the foreground confirms them.

    If they agreed until recently, a contour larger than its foreground may be partly covered while
    the foreground's size changes, and a smaller one may have joined something else. Contours that
    share a foreground have to be inside it, and to keep their sizes. At the border of the picture
    there are no edges: a target that had its shape before it got there counts as covered.

    :param before: (N, 4) boxes of the prediction [px].
    :param after: (N, 4) boxes after the correction by edges [px].
    :param past: history of these targets.
    :param clear: (N,) whether nearly all lines have edges.
    """
    off, most = regions.box - after, slack(after)
    inward = np.hstack([off[:, :2], -off[:, 2:]])
    part = (inward >= -most).all(axis=1) & past.recent & past.changing.any(axis=1)
    grown = (after[:, 2:] - after[:, :2]) - (before[:, 2:] - before[:, :2])
    inside = (inward <= most).all(axis=1)
    part |= inside & past.recent & past.rigid & clear
    within = inside & (np.abs(grown) <= most[:, :2]).all(axis=1)
    good = np.where(regions.shared, within, is_same(after, regions) | part)
    return np.asarray(good & (past.recent & past.rigid | ~regions.cut.any(axis=1)))


def follow(
    contours: Contours,
    regions: OwnAreas,
    past: History,
    frames: float,
    spline: Spline,
    config: ContourConfig,
) -> None:
    """Move contours to their foreground.

    If the two agreed lately, and the foreground's size is changing, contours shrink slowly, and
    rigid ones not at all, since they may be covered. At the border they grow at once, since they
    are entering the picture.

    :param regions: of these contours; each has an area.
    :param past: history of these targets.
    :param frames: time since the last frame [frames].
    """
    own = boxes(spline.outline(contours.nodes))
    together = in_common(own, regions.box, regions.first)
    shift = shifts(own, regions.box, regions.cut)
    shift[regions.shared] = together[regions.shared]
    normals = spline.normals(contours.nodes)
    offset, all_of_them = (normals * shift[:, None]).sum(axis=2), np.ones(normals.shape[:2], bool)
    contours.correct(offset, all_of_them, normals, frames, config, REGION_SIGMA**2)
    alone = ~regions.shared
    own = boxes(spline.outline(contours.nodes))
    off = regions.box - own
    shrinks = off * [-1, -1, 1, 1] < 0
    held = shrinks & past.recent[:, None] & np.tile(past.changing, 2)
    off[held & past.rigid[:, None]] = 0.0
    seconds = np.where(held, COVERED_SECONDS, SIZE_SECONDS)
    part = -np.expm1(-frames / config.rate / seconds)
    comes_in = np.asarray(regions.cut.any(axis=1))
    part[~shrinks & comes_in[:, None]] = 1.0
    wanted = own + off * part
    contours.nodes[alone] = resized(contours.nodes[alone], own[alone], wanted[alone])
