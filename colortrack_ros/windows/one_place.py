"""Windows that have come to one place, which is one target's alone."""

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.estimation.boxes import overlaps
from colortrack_ros.estimation.records import Records
from colortrack_ros.windows.appearance import Sighting
from colortrack_ros.windows.lasting import sizes
from colortrack_ros.windows.matching import Matches

SAME_PLACE = 0.5
"""Least intersection over union of two windows that show one thing: half, from which on a box is
taken to be right (Everingham et al. 2010, "The PASCAL visual object classes challenge", 4.2)."""


def crowded_out(
    records: Records, matches: Matches, valid: Bools, sightings: dict[int, Sighting]
) -> list[int]:
    """Return which targets are seen where another one is, which is more like itself there.

    One walker looks nearly like another to a correlation filter, so that the window of somebody who
    is covered would go over to who covers them. Who is followed there already is more like what the
    window shows. Targets whose templates are found are told by them, and stay. So do those that
    were at one place from the start: somebody behind somebody else, or two boxes of one thing. And
    who was lost may answer to anything, so that it crowds out nobody who was seen until now.

    :param valid: (N,) which targets are found, by their templates or by sightings.
    :param sightings: of those that were looked for, by index.
    """
    reach = (sizes(records) - 1) / 2
    box = np.concatenate([matches.z - reach, matches.z + reach], axis=1)
    same = overlaps(box, box) > SAME_PLACE
    ids, company = records['track_id'], records['company']
    for i in [i for i, known in enumerate(company) if not known]:
        company[i] = frozenset(ids[same[i]].tolist())
    likeness = np.where(matches.similarity > 0, np.inf, 0.0)
    for i, seen in sightings.items():
        if not matches.similarity[i] > 0:
            likeness[i] = records['appearance'][i].likeness(seen)
    followed = records['looks'] == 0
    same &= (
        valid[:, None] & valid & (likeness[:, None] < likeness) & (followed | ~followed[:, None])
    )
    pairs = np.argwhere(same).tolist()
    return sorted({i for i, j in pairs if ids[j] not in company[i] and ids[i] not in company[j]})
