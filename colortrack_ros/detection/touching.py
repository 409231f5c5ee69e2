"""Touching objects: separates merged blobs by the appearance of each object before."""

from dataclasses import dataclass
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.columns import Columns
from colortrack_ros.data import Bools
from colortrack_ros.data import DETECTION
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.claims import claim_blobs
from colortrack_ros.detection.claims import IN_NONE
from colortrack_ros.detection.parts import replaced
from colortrack_ros.detection.parts import rows_of
from colortrack_ros.detection.parts import seen_of
from colortrack_ros.detection.templates import BlobTemplate
from colortrack_ros.detection.templates import Fit
from colortrack_ros.detection.templates import fit_templates
from colortrack_ros.detection.templates import Look

LONGEST_GAP = 0.5
"""Longest time between two frames across which objects are associated with blobs [s]. Assumed."""

TRAIL_STEP, TRAIL = 0.2, 20
"""Interval between the stored places of an object [s], and their number. Assumed."""

WAIT_SECONDS = 0.05
"""Interval between processed frames while nothing appears, disappears, or touches [s]: every other
one at 30 Hz. With 0.1, two of three accelerating real cups were not separated for 25 frames."""

LONGEST_EXPOSURE = 1 / 30
"""Longest time of motion blur [s]: cameras that show motion do not expose longer."""

KEPT_LOOKS = 4
"""Number of recent places with which the objects' appearance is stored as well: longer than a hand
takes to move an object in front of another, shorter than an object takes to turn another way."""

APPROACH = 0.3
"""How much closer two blobs must have come to be two objects [side of a square with the smaller
one's area]: pieces of one object keep their distance. If a stripe of a third of the radius turns
between the two halves of a disc, they come closer by 0.24."""

PAST = 1.0
"""Relative displacement after a gap of APPROACH that tells two objects, too [the same side]. Pieces
may have such a gap, but keep their places. Assumed."""

HIDDEN_SECONDS = 0.5
"""How long to remember an object that cannot be told from the others in its blob [s]. Assumed."""

SIGMA, SIGMA_OF_SIDE, SIGMA_OF_WAY = 1.0, 1.2, 0.5
"""Standard deviation of an expected place: constant [px], per second [side of a square of its
area], and per displacement since the last frame. With half to twice the second, IDF1 of a real clip
of three cups is 0.98 with a PRIOR_COST of 1 or 2, and 0.87 to 0.98 with 0.5, which lets barely
visible objects drift."""

REGISTERED_WITHIN = 1 / 8
"""Standard deviation of the centroid of what is visible of an object about its own [side]: up to
half is covered. Assumed."""

MOST_THINGS, MOST_IN_BLOB, MOST_BLOBS = 100, 4, 8
"""Limits on the blobs to follow, the objects in one blob, and the number of such blobs to separate
per frame. They bound the time: following 300 blobs took as long as finding them."""

PIECE = -2
"""Replaces a blob's number: the object was a piece of another."""


@dataclass
class Things(Columns):
    """The N objects in the blobs of the last frame, one or several in each.

    :param number: (N,) unique, never reused.
    :param label: (N,) of the pixels.
    :param blob: (N,) that contained it, or IN_NONE.
    :param group: (N,) number of the first object in its blob; -1 for an object that was alone.
    :param mean: (N, 2) center [px].
    :param area: (N,) when it was last alone [px].
    :param velocity: (N, 2) [px/s].
    :param trail: (N, TRAIL, 2) previous places, latest first, NaN before it was seen [px].
    :param seen: (N,) stamp at which it was last told from the others in its blob [ns].
    """

    number: NDArray[np.int64]
    label: NDArray[np.uint8]
    blob: Indices
    group: NDArray[np.int64]
    mean: Floats
    area: Indices
    velocity: Floats
    trail: Floats
    seen: NDArray[np.int64]


class TouchingThings:
    """Follows blobs over time, to find those with several objects and locate these.

    Two blobs that come closer and merge are two objects. Their appearance while they were alone is
    fitted to the merged blob, which separates them as long as both are visible.
    things: the objects in the blobs of the last frame.
    """

    def __init__(self) -> None:
        self._next = 0
        self._waiting: tuple[NDArray[np.void], BlobTable, int] | None = None
        self._restart()

    def _restart(self) -> None:
        none = np.zeros(0, np.int64)
        self.things = self._new(none.astype(np.uint8), np.zeros((0, 2)), none, none, 0)
        self._templates: dict[int, BlobTemplate] = {}
        self._looks: list[Look] = []
        self._rows = np.zeros(0, DETECTION)
        self._stamp = self._trailed = 0

    def tell_apart(self, rows: NDArray[np.void], blobs: BlobTable, stamp: int) -> NDArray[np.void]:
        """Replace the row of a blob with several objects by one row per visible object.

        :param rows: (M,) of dtype DETECTION.
        :param blobs: M, of the frame.
        :param stamp: of the frame [ns].
        """
        if self._may_wait(rows, stamp):
            self._waiting = rows, blobs, stamp
            return rows
        if self._waiting:
            self._follow(*self._waiting)
            self._waiting = None
        return self._follow(rows, blobs, stamp)

    def _may_wait(self, rows: NDArray[np.void], stamp: int) -> bool:
        """Whether a frame soon after a processed one has the same number of blobs of each color."""
        return (
            not self._templates
            and 0 < stamp - self._stamp < WAIT_SECONDS * NANOSECONDS
            and len(rows) == len(self._rows) == len(self.things)
            and bool((rows['color'] == self._rows['color']).all())
        )

    def _follow(self, rows: NDArray[np.void], blobs: BlobTable, stamp: int) -> NDArray[np.void]:
        """Process a frame for tell_apart."""
        dt = (stamp - self._stamp) / NANOSECONDS
        if not 0 < dt <= LONGEST_GAP or max(len(rows), len(self.things)) > MOST_THINGS:
            self._restart()
        if len(rows) > MOST_THINGS:
            return rows
        things = self.things
        expected = things.mean + dt * things.velocity
        claim, single = claim_blobs(expected, things.mean, things.label, things.area, blobs)
        told = rows
        if single and len(claim) == len(rows) and not self._templates:
            things.blob, things.area = claim, blobs.area[claim]
            self._move(blobs.mean[claim], dt)
        else:
            told = self._sort_out(claim, expected, rows, blobs, stamp, dt)
        if stamp - self._trailed >= TRAIL_STEP * NANOSECONDS:
            trail = self.things.trail
            trail[:, 1:] = trail[:, :-1].copy()
            trail[:, 0] = self.things.mean
            self._trailed = stamp
            alone = self.things.take(self.things.group < 0)
            blob = dict(zip(alone.number.tolist(), alone.blob.tolist(), strict=True))
            self._looks = [Look(blobs, rows, blob), *self._looks[: KEPT_LOOKS - 1]]
        self._blobs, self._rows, self._stamp = blobs, rows, stamp
        return told

    def _move(self, mean: Floats, dt: float, trust: Floats | float = 1.0) -> None:
        """Update the places and velocities of objects.

        :param trust: in the measured motion, 0..1: the visible share of each.
        """
        things = self.things
        moved = (mean - things.mean) / dt - things.velocity
        gain = np.where((things.velocity == 0).all(axis=1), 1.0, 0.5) * trust
        things.velocity += gain[:, None] * moved
        things.mean = mean

    def _sort_out(
        self,
        claim: Indices,
        expected: Floats,
        rows: NDArray[np.void],
        blobs: BlobTable,
        stamp: int,
        dt: float,
    ) -> NDArray[np.void]:
        """Process a frame in which blobs have merged, split, appeared or disappeared."""
        things = self.things
        several = self._several(claim, expected)
        known = (claim == IN_NONE) & ~np.isnan(things.trail[:, 0, 0])
        known[[k for _, members in several for k in members]] = True
        alone = ~known & (claim >= 0)
        mean, seen, trust = expected.copy(), things.seen.copy(), np.ones(len(claim))
        mean[alone], things.area[alone] = blobs.mean[claim[alone]], blobs.area[claim[alone]]
        seen[alone] = stamp
        group = np.where(alone, -1, things.group)
        self._templates = {int(things.number[k]): self._template(k) for k in known.nonzero()[0]}
        parts: dict[int, NDArray[np.void]] = {}
        for place, (blob, members) in enumerate(several):
            group[members] = things.number[members].min()
            if place >= MOST_BLOBS or len(members) > MOST_IN_BLOB:
                continue
            templates = [self._template(k) for k in members.tolist()]
            fit = self._fit(blobs, blob, members, templates, expected[members], dt)
            trust[members], visible = seen_of(fit, templates, int(blobs.area[blob]))
            self._keep_placed(members, fit, visible)
            mean[members[visible]], seen[members[visible]] = fit.center[visible], stamp
            parts[blob] = rows_of(rows[blob : blob + 1], fit, templates, visible)
        self._move(mean, dt, trust)
        things.blob, things.group, things.seen = claim, group, seen
        things.keep((known | alone) & (stamp - seen <= HIDDEN_SECONDS * NANOSECONDS))
        fresh = np.setdiff1d(np.arange(len(rows)), things.blob)
        label, mean, area = blobs.label[fresh], blobs.mean[fresh], blobs.area[fresh]
        things.extend(self._new(label, mean, area, fresh, stamp))
        return replaced(rows, parts) if parts else rows

    def _keep_placed(self, members: Indices, fit: Fit, visible: Bools) -> None:
        """Keep the templates of what is visible, with what covers it now."""
        number = self.things.number[members].tolist()
        self._templates |= {number[i]: fit.placed[i] for i in visible.nonzero()[0].tolist()}

    def _new(
        self, label: NDArray[np.uint8], mean: Floats, area: Indices, blob: Indices, stamp: int
    ) -> Things:
        count = len(label)
        number = self._next + np.arange(count)
        self._next += count
        return Things(
            number, label, blob, np.full(count, -1), mean, area, np.zeros((count, 2)),
            np.full((count, TRAIL, 2), np.nan), np.full(count, stamp),
        )  # fmt: skip

    def _several(self, claim: Indices, expected: Floats) -> list[tuple[int, Indices]]:
        """Find blobs with several objects, and these; pieces lose their claim, in place."""
        found = []
        for blob in np.flatnonzero(np.bincount(claim[claim >= 0]) > 1):
            inside = np.flatnonzero(claim == blob)
            templates = [self._template(k) for k in inside.tolist()]
            met = self._have_met(inside, expected[inside], templates)
            if met.any():
                found.append((int(blob), inside[met]))
            else:
                met[np.argmax([template.side for template in templates])] = True
            claim[inside[~met]] = PIECE
        return found

    def _have_met(self, members: Indices, expected: Floats, looks: list[BlobTemplate]) -> Bools:
        """(K,) whether an object was together with another before, has come closer, or passes."""
        things = self.things
        trail, group = things.trail[members], things.group[members]
        before, now = trail[:, None] - trail, expected[:, None] - expected
        side = np.array([look.side for look in looks])
        size = np.array([look.box[2:] for look in looks])
        least = np.minimum(side, side[:, None])[..., None]
        nearer = np.hypot(*before.T).T - np.hypot(*now.T).T[..., None] >= APPROACH * least
        gap = (np.abs(before) - ((size[:, None] + size) / 2)[:, :, None]).max(axis=3)
        moved = np.hypot(*(before - now[:, :, None]).T).T
        nearer |= (gap >= APPROACH * least) & (moved >= PAST * least)
        met = nearer.any(axis=2) | ((group[:, None] == group) & (group >= 0))
        return np.asarray((met & ~np.eye(len(members), dtype=bool)).any(axis=1))

    def _template(self, k: int) -> BlobTemplate:
        """The appearance of an object when it was last alone, and hidden the least."""
        number = int(self.things.number[k])
        if number not in self._templates:
            last = Look(self._blobs, self._rows, {number: int(self.things.blob[k])})
            best = max((last, *self._looks), key=lambda look: look.area(number))
            found = best.template(number)
            self._templates[number] = found if best is last else self._as_last(found, k)
        return self._templates[number]

    def _as_last(self, template: BlobTemplate, k: int) -> BlobTemplate:
        """Register a template with the blob of its object in the last frame, in part covered."""
        things = self.things
        mean, blob = things.mean[k : k + 1], int(things.blob[k])
        sigma = np.array([REGISTERED_WITHIN * template.side])
        fit = fit_templates(self._blobs, blob, [template], mean, sigma, np.zeros((1, 2)))
        return replace(fit.placed[0], offset=fit.center[0] - mean[0])

    def _fit(
        self,
        blobs: BlobTable,
        blob: int,
        members: Indices,
        templates: list[BlobTemplate],
        expected: Floats,
        dt: float,
    ) -> Fit:
        """Fit the objects of a blob to it; expected: (K, 2) their centers [px]."""
        expected = expected + [template.offset for template in templates]
        velocity = self.things.velocity[members]
        side = np.array([template.side for template in templates])
        sigma = SIGMA + SIGMA_OF_SIDE * dt * side + SIGMA_OF_WAY * dt * np.hypot(*velocity.T)
        smear = velocity * min(dt, LONGEST_EXPOSURE)
        return fit_templates(blobs, blob, templates, expected, np.asarray(sigma), smear)
