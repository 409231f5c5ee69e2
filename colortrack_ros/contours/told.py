"""Targets started by boxes, from a person or a detector."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.contours.areas import FITS
from colortrack_ros.contours.boxes import boxes
from colortrack_ros.contours.config import ContourConfig
from colortrack_ros.contours.filters import Contours
from colortrack_ros.contours.lines import find_edges
from colortrack_ros.contours.records import begin
from colortrack_ros.contours.spline import Spline
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import Floats
from colortrack_ros.data import Frame
from colortrack_ros.data import Indices
from colortrack_ros.data import TENTATIVE
from colortrack_ros.estimation.boxes import overlaps
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.estimation.waiting_boxes import WaitingBoxes

LEAST_BOX_SIDE = 4.0
"""Narrower boxes are refused [px]: their area is below the least one, 16 px."""

MAX_LINE = 200
"""Longest measurement line [px]: the maximum of line_length."""


def begin_told(
    tracks: TrackTable[Contours],
    waiting: WaitingBoxes,
    frame: Frame,
    spline: Spline,
    config: ContourConfig,
    stamp: int,
) -> None:
    """Start targets in waiting boxes, at the edges next to ellipses in them.

    :param stamp: now [ns].
    """
    if not len(waiting):
        return
    free, own = config.max_targets - len(tracks), boxes(spline.outline(tracks.filters.nodes))
    new, same = begin_in(waiting, own, frame.image.shape, free)
    begin(tracks, contours_in(new, frame.image, spline, config), spline, stamp)['told'] = True
    records = tracks.records
    records['told'][same] = True
    records['moved'] |= records['told']
    records['state'][records['told'] & (records['state'] == TENTATIVE)] = CONFIRMED


def begin_in(
    waiting: WaitingBoxes, own: Floats, shape: tuple[int, ...], free: int
) -> tuple[Floats, Indices]:
    """Return boxes that start a target in this frame, and targets that already match a box.

    Offered boxes whose center lies in a target, or in a box that is not offered, are dropped.

    :param own: (N, 4) boxes of the targets [px].
    :param shape: of the frame: height, width, ...
    :param free: number of targets that may start.
    :return: (K, 4) left, top, right, bottom [px], and (M,).
    """
    named, offered = waiting.take()
    box = np.concatenate([named[:, :2], named[:, :2] + named[:, 2:] - 1], axis=1)
    center = (box[:, :2] + box[:, 2:]) / 2
    good = (box[:, 2:] - box[:, :2] >= LEAST_BOX_SIDE - 1).all(axis=1)
    good &= ((center >= 0) & (center <= np.array([shape[1], shape[0]]) - 1)).all(axis=1)
    waiting.refused += int(np.count_nonzero(~good))
    box, offered, center = box[good], offered[good], center[good]
    alike = overlaps(own, box)
    known = alike.max(axis=0, initial=0.0) > FITS
    followed = np.concatenate([own, box[~offered]])[:, None]
    inside = (center >= followed[..., :2]) & (center <= followed[..., 2:])
    new = box[~known & ~(offered & inside.all(axis=2).any(axis=0))]
    waiting.refused += max(len(new) - free, 0)
    same = alike[:, known].argmax(axis=0) if known.any() else np.zeros(0, np.intp)
    return new[: max(free, 0)], same


def contours_in(
    box: Floats, image: NDArray[np.uint8], spline: Spline, config: ContourConfig
) -> Contours:
    """Return contours of things in boxes, (K, 4): ellipses in them, moved to the nearest edges.

    Edges are searched for up to a quarter of the largest side inward and outward, each on its
    own.
    """
    angle = 2 * np.pi * np.arange(config.points) / config.points
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    middle, half = (box[:, :2] + box[:, 2:]) / 2, (box[:, 2:] - box[:, :2]) / 2
    nodes = middle[:, None] + half[:, None] * circle
    contours = Contours.new(nodes, np.zeros_like(middle), config)
    contours.doubt_velocity(config.sigma)
    length = int(np.clip(half.max(initial=0.0), config.line_length, MAX_LINE))
    normals, sigma = spline.normals(nodes), np.full(nodes.shape[:2], length / 4)
    far = replace(config, line_length=length)
    edges = find_edges(image, nodes, normals, sigma, contours.sides, far)
    contours.correct(edges.offset, edges.found, normals, 0.0, config)
    contours.sides[edges.found] = edges.sides[edges.found]
    return contours
