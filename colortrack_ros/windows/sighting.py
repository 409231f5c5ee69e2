"""Search by appearance for targets whose templates are not found."""

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Frame
from colortrack_ros.data import Indices
from colortrack_ros.estimation.records import Records
from colortrack_ros.estimation.track_table import is_inside
from colortrack_ros.windows.appearance import Appearance
from colortrack_ros.windows.appearance import LEARNED
from colortrack_ros.windows.appearance import NEARBY
from colortrack_ros.windows.appearance import RARER
from colortrack_ros.windows.appearance import Sighting
from colortrack_ros.windows.lasting import sizes
from colortrack_ros.windows.matching import Matches
from colortrack_ros.windows.one_place import crowded_out
from colortrack_ros.windows.past import Past

RINGS = 20
"""Rings of places to search around the last position of a lost target. In steps of the smallest
region, 12 px, they cover 300 px around it; for a target of 40 px, 2000 px. Assumed: about a
picture."""

DISAGREEMENT = 9.0
"""Gate on the squared Mahalanobis distance of a template match from the sighting: 3 sigma."""

UNFOUND = 10
"""Frames for which a template is searched for in each before it is only in every other one.
Assumed: a third of a second, as in USUAL_FRAMES."""

_GRID = np.stack(np.meshgrid(*2 * [np.arange(-RINGS, RINGS + 1)]), axis=-1).reshape(-1, 2)
SPIRAL = _GRID[np.hypot(*_GRID.T).argsort(kind='stable')].astype(float)
"""The places, (n, 2) by u and v, nearest first, in units of Appearance.reach."""


def left_out(records: Records) -> list[int]:
    """Return the templates that are not searched for in this frame.

    While a target is seen for sure and its template has not been found for some time, the template
    takes turns with what takes longest, to learn.
    """
    learned = ~_are_sized(records['turns'] + 1) & (records['looks'] == 0)
    indices: list[int] = np.flatnonzero(learned & (records['unfound'] >= UNFOUND)).tolist()
    return indices


def sight(
    frame: Frame, records: Records, matches: Matches, valid: Bools, predicted: Floats, past: Past
) -> dict[int, Sighting]:
    """Search for targets by their appearance; return sightings by index of the track.

    A target that was just seen for sure, and whose template is found, is skipped in every other
    frame, in which its size is estimated instead (see learn).

    Where the template is not found, or is found away from where the target is clearly seen, the
    sighting replaces the match. (A template that has learned some background stays there with it.)
    A target seen where another one is, and less clearly, is not seen at all: see crowded_out. Nor
    is one at a place that showed the same without it: see Past.

    :param records: of the N tracks.
    :param valid: (N,) whether the template is found; set where the target is seen.
    :param predicted: (N, 2) u, v [px].
    """
    sightings, looks, turns = {}, records['looks'], records['turns']
    records['unfound'] = np.where(valid, 0, records['unfound'] + 1)
    inside = is_inside(predicted, *frame.image.shape[:2])
    for i, appearance in enumerate(records['appearance']):
        left = valid[i] and _is_background(frame, records, i, matches.z[i], past)
        if left or not inside[i]:
            valid[i], looks[i] = False, max(looks[i], 1)
        just_sized = valid[i] and looks[i] == 0 and _are_sized(turns[i] + 1)
        if just_sized or not appearance:  # it was off until now: see learn
            continue
        found = matches.z[i] if valid[i] else None
        seen = _seek(frame, records, i, found, predicted[i], past)
        if seen and _is_taken(frame, records, i, seen, matches, valid, past):
            sightings[i] = seen
    out = crowded_out(records, matches, valid, sightings)
    valid[out] = False
    return {i: seen for i, seen in sightings.items() if i not in out}


def _seek(
    frame: Frame, records: Records, i: int, found: Floats | None, predicted: Floats, past: Past
) -> Sighting | None:
    """Look for the i-th target; found: where its template is found, if it is.

    If it has left the picture, it has to be clearer: what comes in there may be something else.
    """
    appearance, looks = records['appearance'][i], int(records['looks'][i])
    inside = np.clip(predicted, 0, np.array(frame.image.shape[1::-1]) - 1)
    near = NEARBY if (inside == predicted).all() else LEARNED
    seen: Sighting = appearance.look(frame, inside if found is None else found)
    is_like = appearance.likeness(seen) >= near
    if found is not None:
        return seen if is_like else None
    if is_like and not _is_background(frame, records, i, seen.z, past):
        return seen
    place, nearer = _elsewhere(frame, appearance, records['seen'][i], looks)
    seen = appearance.look(frame, place)
    # The more places are as near, the likelier one of them resembles the target by chance.
    if appearance.likeness(seen) < near + RARER * np.log(nearer + 1):
        return None
    if _is_background(frame, records, i, seen.z, past):
        return None
    records['looks'][i] = max(looks, 1)  # lost, even if it was just seen
    return seen


def _is_taken(
    frame: Frame, records: Records, i: int, seen: Sighting, matches: Matches, valid: Bools,
    past: Past,
) -> bool:  # fmt: skip
    """Let a sighting replace the match where they disagree; return whether it counts.

    Where they agree, the past has been asked about that place already.
    """
    appearance = records['appearance'][i]
    place = seen if appearance.is_sure(seen) else appearance.partly(seen)
    error = matches.z[i] - place.z
    if valid[i] and error @ np.linalg.solve(place.R, error) <= DISAGREEMENT:
        return True
    if valid[i] and _is_background(frame, records, i, place.z, past):
        return False
    matches.z[i], matches.R[i], matches.similarity[i], valid[i] = place.z, place.R, 0, True
    return True


def _is_background(frame: Frame, records: Records, i: int, place: Floats, past: Past) -> bool:
    """Return whether a place (u, v) [px] is known to show what is there without the target."""
    box = np.concatenate([place, sizes(records)[i]])
    return past.showed(frame, int(records['track_id'][i]), box)


def are_doubtful(
    records: Records, matches: Matches, sightings: dict[int, Sighting], overdue: Bools
) -> Bools:
    """Return which targets, (N,), were lost and are seen again, but not for sure.

    They are followed, but not reported as seen: many other things look as similar. Once they are
    overdue, one of those has been found sooner or later, and only the template tells.

    :param overdue: (N,) which were last seen for sure too long ago.
    """
    unsure = np.zeros(len(records), bool)
    for i, seen in sightings.items():
        unsure[i] = overdue[i] or not records['appearance'][i].is_sure(seen)
    return np.asarray(unsure & (records['looks'] > 0) & ~(matches.similarity > 0))


def are_faint(
    records: Records, matches: Matches, sightings: dict[int, Sighting], accepted: Bools
) -> Bools:
    """Return which targets, (N,), are seen only by an appearance that hardly answers to them.

    Their filter has found nothing that stays, and follows whatever is there. They are followed and
    learned, but not reported as seen. If it answers in the end, it has learned what is there, so
    that only the template, which does not learn meanwhile, tells that it is the target.

    :param accepted: (N,) which targets are measured.
    """
    faint = np.array(records['faint'])
    for i in sightings:
        faint[i] |= not records['appearance'][i].is_distinct
    return np.asarray(faint & ~(accepted & (matches.similarity > 0)))


def record_scores(
    records: Records, matches: Matches, sightings: dict[int, Sighting], accepted: Bools
) -> None:
    """Record how much what was found resembles each target, 0 to 1: by its template, or else by its
    appearance.

    :param accepted: (N,) which targets are measured.
    """
    score = np.clip(matches.similarity, 0.0, 1.0)
    for i, seen in sightings.items():
        if not score[i] > 0:
            score[i] = records['appearance'][i].likeness(seen)
    records['score'][accepted] = score[accepted]


def learn(
    frame: Frame, records: Records, accepted: Bools, matches: Matches,
    sightings: dict[int, Sighting],
) -> None:  # fmt: skip
    """Learn the targets' appearance and size.

    A sighting that resembles the target less than usual is learned only where the template is found
    as well: two witnesses that agree on the place are hardly wrong. (By its likeness alone, a
    target that deforms would no longer be learned from some frame on, and resemble itself less and
    less.) A target that has none, since appearances were just switched on, gets its first one.

    :param accepted: (N,) which targets are measured and not doubtful.
    """
    found = matches.similarity > 0
    records['looks'] = np.where(accepted, 0, records['looks'] + 1)
    records['turns'] += accepted
    for i in np.flatnonzero(accepted).tolist():
        appearance, seen = records['appearance'][i], sightings.get(i)
        if not appearance:
            size = sizes(records)[i].astype(float)
            records['appearance'][i] = Appearance(frame, matches.z[i], size)
            continue
        if _are_sized(records['turns'][i]):
            appearance.resize(frame, matches.z[i])
        elif found[i] or seen is None or appearance.is_sure(seen):
            appearance.learn(frame, matches.z[i], seen)
        records['box_w'][i], records['box_h'][i] = appearance.size
        records['area'][i] = appearance.size.prod()


def _are_sized(turns: Indices) -> Bools:
    """Return of which targets to estimate the size in this turn, not to learn the appearance.

    Size and appearance take turns, and each costs half of the time.
    """
    return np.asarray(turns % 2 == 0)


def _elsewhere(
    frame: Frame, appearance: Appearance, last: Floats, looks: int
) -> tuple[Floats, int]:
    """Return where to search for a lost target: around its last place, in cycles that double.

    :return: the place (u, v) [px], and how many are nearer to the last one.
    """
    size = np.array(frame.image.shape[1::-1])
    place = np.clip(last, 0, size - 1) + SPIRAL * appearance.reach
    place = place[((place >= 0) & (place < size)).all(axis=1)]
    turn = looks + 1
    nearer = (turn - (1 << turn.bit_length() - 1)) % len(place)
    return np.asarray(place[nearer]), nearer
