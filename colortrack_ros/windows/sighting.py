"""Targets whose templates are not found are looked for by their appearance."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.estimation.records import Records
from colortrack_ros.windows.appearance import Appearance
from colortrack_ros.windows.appearance import NEARBY
from colortrack_ros.windows.appearance import RARER
from colortrack_ros.windows.appearance import Sighting
from colortrack_ros.windows.features import Floats
from colortrack_ros.windows.matching import Matches

RINGS = 20
"""Of places around the last one that a lost target was seen at: with the least region of 12 px that
is looked at, they fill the 300 px around it; a target of 40 px is looked for in 2000 px."""

DISAGREEMENT = 9.0
"""Square of the standard deviations of what is seen that a template may be found beside it: 3."""

_GRID = np.stack(np.meshgrid(*2 * [np.arange(-RINGS, RINGS + 1)]), axis=-1).reshape(-1, 2)
SPIRAL = _GRID[np.hypot(*_GRID.T).argsort(kind='stable')].astype(float)
"""The places, the nearest first, (n, 2) by u and v, in units of Appearance.reach."""


def sight(
    frame: Frame, records: Records, matches: Matches, valid: NDArray[np.bool_],
    predicted: Floats,
) -> dict[int, Sighting]:  # fmt: skip
    """Look for all targets by their appearance, save those that the next look can wait for.

    A target that was just seen for sure, and whose template is found, is looked at in every other
    frame: in those between, its size is looked for (see learn).

    Where the template is not found, or is found at another place than the target is clearly seen
    at, what is seen takes the place of the match. (A template that has taken on a part of what is
    behind the target stays there with it.)

    :param records: of the N tracks.
    :param valid: (N,) whether the template is found; True from now on where the target is seen.
    :param predicted: (N, 2) u, v [px].
    :return: by track, those that are seen for sure.
    """
    sightings, looks, hits = {}, records['looks'], records['hits']
    for i, appearance in enumerate(records['appearance']):
        if valid[i] and looks[i] == 0 and _is_sized(hits[i] + 1):
            continue
        seen = appearance.look(frame, matches.z[i] if valid[i] else predicted[i])
        if appearance.likeness(seen) < NEARBY:
            if valid[i]:
                continue
            elsewhere = _elsewhere(frame, appearance, records['seen'][i], int(looks[i]))
            seen = appearance.look(frame, elsewhere)
            # The more places were looked at, the rarer has to be one as like.
            if appearance.likeness(seen) < NEARBY + RARER * np.log(looks[i] + 1):
                continue
            looks[i] = max(looks[i], 1)  # it is lost even if it was just seen
        sightings[i] = seen
        if not appearance.is_sure(seen):
            seen = appearance.partly(seen)
        error = matches.z[i] - seen.z
        if not valid[i] or error @ np.linalg.solve(seen.R, error) > DISAGREEMENT:
            matches.z[i], matches.R[i], matches.similarity[i], valid[i] = seen.z, seen.R, 0, True
    return sightings


def are_doubtful(
    records: Records, matches: Matches, sightings: dict[int, Sighting]
) -> NDArray[np.bool_]:
    """Which targets had been lost, and are seen again by their appearance, but not for sure, (N,).

    They are followed, but not said to be there: of what is as like as they are there is much.
    """
    unsure = np.zeros(len(records), bool)
    for i, seen in sightings.items():
        unsure[i] = not records['appearance'][i].is_sure(seen)
    return np.asarray(unsure & (records['looks'] > 0) & ~(matches.similarity > 0))


def learn(
    frame: Frame, records: Records, accepted: NDArray[np.bool_], matches: Matches,
    sightings: dict[int, Sighting],
) -> None:  # fmt: skip
    """Learn what the targets look like where they are, and how large they are.

    What is less like a target than it has been is learned where its template is found as well: two
    witnesses that agree on the place are hardly wrong. (By its likeness alone a target that deforms
    is learned no more from some frame on, and from there on is less and less like.)

    :param accepted: (N,) which are measured, and not doubtful.
    """
    found = matches.similarity > 0
    records['looks'] = np.where(accepted, 0, records['looks'] + 1)
    for i in np.flatnonzero(accepted).tolist():
        appearance: Appearance = records['appearance'][i]
        seen = sightings.get(i)
        if _is_sized(records['hits'][i]):
            appearance.resize(frame, matches.z[i])
        elif found[i] or seen is None or appearance.is_sure(seen):
            appearance.learn(frame, matches.z[i], seen)
        records['box_w'][i], records['box_h'][i] = appearance.size
        records['area'][i] = appearance.size.prod()


def _is_sized(hits: int) -> bool:
    """Whether the size of a target is looked for when it has been seen so many times.

    By turns with what it looks like: each is half of the time.
    """
    return hits % 2 == 1


def _elsewhere(frame: Frame, appearance: Appearance, last: Floats, looks: int) -> Floats:
    """Where to look for a lost target: around its last place, in cycles twice as long each time."""
    size = np.array(frame.image.shape[1::-1])
    place = np.clip(last, 0, size - 1) + SPIRAL * appearance.reach
    place = place[((place >= 0) & (place < size)).all(axis=1)]
    turn = looks + 1
    return np.asarray(place[(turn - (1 << turn.bit_length() - 1)) % len(place)])
