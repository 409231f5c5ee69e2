"""Merge and split: blobs that broke into pieces, and blobs shared by several objects."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Indices
from colortrack_ros.data import TENTATIVE
from colortrack_ros.estimation.track_table import marked
from colortrack_ros.tracking.duplicates import leave_out_duplicates
from colortrack_ros.tracking.hypotheses import Association
from colortrack_ros.tracking.hypotheses import hypothesize
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.merged import EDGE_VARIANCE
from colortrack_ros.tracking.overlaps import Overlaps
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.rectangles import points_inside
from colortrack_ros.tracking.sizes import total
from colortrack_ros.tracking.splinters import mark_pieces


def merge_split(
    prediction: Prediction, blobs: Measurements, associated: Association, overlaps: Overlaps
) -> tuple[Measurements, Association]:
    """Join the pieces of broken blobs, and let merged tracks share a blob.

    :param overlaps: whether detections merge at all; updated here.
    :return: the blobs, with each joined one in place of the blob that its track took; and the
        association, with pairs for the tracks that share, and without the pieces among the free
        blobs.
    """
    if not prediction.sized:
        return blobs, associated
    records, left, single = prediction.records, np.count_nonzero(associated.free), blobs
    paired = len(associated.pairs) == len(records) == len(blobs) and not left
    if not (paired and np.count_nonzero(records['state']) == len(blobs)):  # else all are confirmed
        associated, single = leave_out_duplicates(prediction, blobs, associated, overlaps)
    overlaps.look(single.box, single.rows['color'])
    if paired or overlaps.are_resolved:
        return blobs, associated
    pairs, probability = associated.pairs, associated.probability
    taken = np.where(prediction.unmeasured > 0, -1, -2)
    sure = probability > 0.5
    taken[pairs.track[sure]] = pairs.blob[sure]
    piece, whole = find_pieces(prediction, blobs, taken, np.flatnonzero(associated.free))
    guest, host = find_guests(prediction, blobs, taken)
    overlaps.count_merged(len(guest))
    if not len(piece) and not len(guest):
        return blobs, associated
    free = associated.free.copy()
    free[piece] = False
    blobs = _join(blobs, piece, whole)
    blobs.mixed[host] = True
    track, blob = np.append(pairs.track, guest), np.append(pairs.blob, host)
    probability = np.append(probability, np.ones(len(guest)))
    order = np.argsort(track, kind='stable')
    track, blob, probability = track[order], blob[order], probability[order]
    pairs = hypothesize(prediction, blobs, track, blob, marked(host, len(blobs))[blob])
    return blobs, Association(pairs, probability, free, associated.hard)


def find_pieces(
    prediction: Prediction, blobs: Measurements, taken: Indices, free: Indices
) -> tuple[Indices, Indices]:
    """Find free blobs that, joined with the blob of a known object, fit into its size.

    :param prediction: of N tracks.
    :param blobs: of the frame.
    :param taken: (N,) the blob of each track; -1 for none, -2 for none because it was measured at
        this stamp before.
    :param free: indices of the unassociated blobs.
    :return: (K,) pieces, each once, and (K,) the blobs that they belong to.
    """
    if not len(free):
        return free, free
    records = prediction.records
    known = np.flatnonzero(
        (taken >= 0) & (records['state'] != TENTATIVE) & records['extent'].all(axis=(1, 2))
    )
    size, box = total(records['extent'].take(known, axis=0)), blobs.box.take(taken[known], axis=0)
    room = 1.05 * (size + prediction.sizes.slack(size))
    half, of_free = room - (box[:, 1] - box[:, 0]) / 2, blobs.box.take(free, axis=0)
    track, piece = points_inside(total(box) / 2, half, total(of_free) / 2)
    whole, piece = taken[known[track]], free[piece]
    low = np.minimum(blobs.box[whole, 0], blobs.box[piece, 0])
    high = np.maximum(blobs.box[whole, 1], blobs.box[piece, 1])
    fits = (high - low <= room[track]).all(axis=1)
    color = blobs.rows['color']
    whole, piece = _once(whole[fits], piece[fits], color[whole[fits]], color)
    return piece, whole


def find_guests(
    prediction: Prediction, blobs: Measurements, taken: Indices
) -> tuple[Indices, Indices]:
    """Find known objects without a blob inside a blob that is too wide for its track.

    Splinters of that track's object are none: it has grown, or was seen only in part before. If the
    detector finds whole objects, there are none either: nobody's box is that of two.

    :param prediction: of N tracks.
    :param blobs: of the frame.
    :param taken: (N,) the blob of each track; -1 for none, -2 for none because it was measured at
        this stamp before.
    :return: (K,) tracks, each once, and (K,) the blobs that they share.
    """
    records = prediction.records
    lost = np.flatnonzero((taken == -1) & (records['state'] != TENTATIVE))
    if not len(lost):
        return lost, lost
    host = np.flatnonzero(taken >= 0)
    size = blobs.size[taken[host]]
    excess = prediction.sizes.difference(prediction.size[host], size)
    wide = taken[host[(excess > 0).any(axis=1)]]
    center = prediction.center[lost]
    blob, track = points_inside(blobs.box[wide].mean(axis=1), blobs.size[wide] / 2, center)
    blob, track = _once(wide[blob], lost[track], blobs.rows['color'][wide[blob]], records['color'])
    owner = np.zeros(len(blobs), records['track_id'].dtype)
    owner[taken[host]] = records['track_id'][host]
    guest = ~mark_pieces(prediction, lost, track, owner[blob])
    guest &= not prediction.finds_whole
    return track[guest], blob[guest]


def _join(blobs: Measurements, piece: Indices, whole: Indices) -> Measurements:
    """Add the pieces of broken blobs to the blobs that their tracks have taken.

    The gap between pieces biases the centroid, so the center of the joint box replaces it.

    :param blobs: (M,).
    :param piece: (K,) indices of the pieces.
    :param whole: (K,) index of the blob that each belongs to.
    :return: (M,) with each joint box in place of the blob that its track took.
    """
    rows, z, R, box = (each.copy() for each in (blobs.rows, blobs.z, blobs.R, blobs.box))
    np.minimum.at(box[:, 0], whole, box[piece, 0])
    np.maximum.at(box[:, 1], whole, box[piece, 1])
    z[whole] = box[whole].mean(axis=1)
    R[whole] = EDGE_VARIANCE * np.eye(2)
    size, mixed = box[:, 1] - box[:, 0], blobs.mixed.copy()
    mixed[whole] = True
    rows['box_u'][whole], rows['box_v'][whole] = box[whole, 0].T + 0.5
    rows['box_w'][whole], rows['box_h'][whole] = size[whole].T
    np.add.at(rows['area'], whole, rows['area'][piece])
    return replace(blobs, rows=rows, z=z, R=R, box=box, size=size, mixed=mixed)


def _once(
    one: Indices, other: Indices, color: NDArray[np.uint32], colors: NDArray[np.uint32]
) -> tuple[Indices, Indices]:
    """Drop pairs of different colors, and keep only the first pair of each `other`."""
    same = color == colors[other]
    other, first = np.unique(other[same], return_index=True)
    return one[same][first], other
