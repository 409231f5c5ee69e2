"""The window tracker: a frame in, tracks out."""

import numpy as np
from numpy.typing import ArrayLike
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import Tracks
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.clock import time_passed
from colortrack_ros.estimation.motion import MOTION_MODELS
from colortrack_ros.windows.config import WindowConfig
from colortrack_ros.windows.crop import Crop
from colortrack_ros.windows.life import births
from colortrack_ros.windows.life import RECORD
from colortrack_ros.windows.life import rows
from colortrack_ros.windows.matching import match_templates
from colortrack_ros.windows.matching import Matches
from colortrack_ros.windows.matching import SUBPIXEL_SIGMA
from colortrack_ros.windows.swarm import Swarm
from colortrack_ros.windows.template import Template

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

SIGMAS = 3.0
GREATEST = 3.0
"""The search region holds so many standard deviations, up to so many times its normal size."""

MEMORY = 20
"""Matches that the mean distance goes back."""

LEAST = 5
"""Pixels that a template is wide and high, at least."""


class WindowTracker:
    """Follows the pictures of a few dozen targets (Vidal 2009, chapters 3 to 5).

    :param config: see WindowConfig.
    :param targets: boxes to start with the first frame, and again after each restart; see start.
    """

    def __init__(self, config: WindowConfig | None = None, targets: ArrayLike = ()) -> None:
        self.config = config or WindowConfig()
        self.targets = _boxes(targets)
        self.refused = 0
        """Boxes refused so far: outside the picture, or one too many."""
        self._next_id = 1
        self._swarm = Swarm(self.config)
        self.reset()

    def reset(self, why: str = '') -> None:
        """Forget all targets, and start the first ones again. IDs go on: none is used twice.

        :param why: what the next Tracks tell as the reason.
        """
        self._why = why
        self._stamp: int | None = None
        self._bank = Bank(MOTION_MODELS['constant_velocity']())
        self._records = np.zeros(0, RECORD)
        self._templates: list[Template] = []
        self._velocity = np.zeros((0, self.config.swarm_frames, 2, 2))
        self._waiting, self._offered = self.targets, _boxes(())

    def configure(self, config: WindowConfig) -> None:
        """Change the configuration; the targets live on."""
        self.config, self._swarm = config, Swarm(config)
        self._velocity = np.full((len(self._records), config.swarm_frames, 2, 2), np.nan)

    def start(self, boxes: ArrayLike) -> None:
        """Follow what is inside the boxes in the next frame.

        :param boxes: (N, 4) u, v of the top left pixel, width and height [px].
        """
        self._waiting = np.concatenate([self._waiting, _boxes(boxes)])

    def offer(self, boxes: ArrayLike) -> None:
        """Follow what is inside the boxes in the next frame, where no target is yet; see start."""
        self._offered = np.concatenate([self._offered, _boxes(boxes)])

    def update(self, frame: Frame) -> Tracks:
        """Take the next frame.

        :return: the tracks at its stamp, with its header.
        """
        dt = self._advance(frame.stamp)
        matches = match_templates(
            frame, self._templates, self._expected, self._half(), self._records['usual'],
            self.config,
        )  # fmt: skip
        believed = self._supervise(matches)
        self._correct(matches, believed, dt)
        self._renew(matches, believed)
        self._settle(frame)
        self._begin(frame, self._waiting)
        self._begin(frame, self._unfollowed(self._offered))
        self._waiting = self._offered = _boxes(())
        why, self._why = self._why, ''
        patience = self.config.max_time_since_update
        tracks = rows(self._records, *self._bank.estimate(), self._now, patience)
        return Tracks(tracks, frame.stamp, frame.frame_id, why)

    def _advance(self, stamp: int) -> float:
        """Predict to the stamp, or start afresh; return dt [s]."""
        dt, why = time_passed(self._stamp, stamp, self.config.max_dt)
        if why:
            offered = self._offered
            self.reset(why)
            self._offered = offered  # it is of this frame
        self._stamp = stamp
        if self.config.method == 'WM':  # no memory of the motion: expected where it was last
            self._bank.forget_velocity(self.config.initial_speed)
        self._bank.predict(dt, self.config.process_noise**2)
        self._expected = self._bank.estimate()[0][:, :2].copy()
        return dt

    def _half(self) -> Floats:
        """Half the width and height of the search regions, (N, 2) [px]."""
        half = np.array([self.config.search_width, self.config.search_height]) / 2
        if self.config.method == 'WM':
            return np.tile(half, (len(self._records), 1))
        variance = np.diagonal(self._bank.estimate()[1], axis1=1, axis2=2)[:, :2]
        return np.clip(SIGMAS * np.sqrt(variance), half, GREATEST * half)

    def _supervise(self, matches: Matches) -> Bools:
        """Whose place is believed, (N,): True that of the match, False that of the prediction.

        The measure of confidence and tolerance of 4.3.1. They disagree when u and v differ by more
        than the tolerance on average. Then either the valid match is right and the filter has to
        learn another velocity, or whichever has moved farther since the last frame is wrong.
        """
        config = self.config
        z, expected, last = matches.z, self._expected, self._records['last']
        found = ~np.isnan(matches.similarity)
        believed: Bools = found
        if config.drift_compensation:
            believed = matches.are_valid(self._records['similarity'], config)
        if config.method == 'WM':
            return believed
        apart = np.abs(z - expected).mean(axis=1) > config.tolerance
        if config.supervision == 'discrepancy':
            moved = np.abs(z - last[:, 0]).mean(axis=1), np.abs(expected - last[:, 1]).mean(axis=1)
            believed &= ~apart | (moved[0] <= moved[1])
        self._turn(np.flatnonzero(believed & apart), z)
        return believed

    def _turn(self, track: NDArray[np.intp], z: Floats) -> None:
        """Let the filters doubt the velocity of targets that are not where it would lead them."""
        if not len(track):
            return
        T = (self._now - self._records['updated'][track]) / NANOSECONDS
        T = np.maximum(T, 1e-3)
        variance = (np.abs(z[track] - self._expected[track]).max(axis=1) / T) ** 2
        self._bank.add_turn(track, T, variance)
        self._velocity[track] = np.nan

    def _correct(self, matches: Matches, believed: Bools, dt: float) -> None:
        """Update filters and records with the places that are believed."""
        track = np.flatnonzero(believed)
        R = matches.R[track]
        R[np.isnan(R).any(axis=(1, 2))] = np.eye(2)
        self._bank.correct(track, matches.z[track], R)
        if self.config.method == 'WM+K+PSO' and dt > 0 and len(track):
            self._steer(track, matches.z, dt)
        records = self._records
        records['updated'][track] = self._now
        records['hits'][track] += 1
        records['similarity'][track] = matches.similarity[track]
        usual, far = records['usual'], matches.innovation_norm
        step = far - np.where(np.isinf(usual), 0.0, usual)
        learn = believed & (matches.alone | (far <= usual))
        share = 1 / np.clip(records['hits'] - 1, 1, MEMORY)
        usual[learn] = np.where(np.isinf(usual), far, usual + share * step)[learn]

    def _steer(self, track: NDArray[np.intp], z: Floats, dt: float) -> None:
        """Give the filters the velocity that the swarm has found, (5.5).

        After a gap matching tells no velocity: where it was in the last frame is a prediction. In
        the frame of a turn the filter tells none: it cannot know when it was.
        """
        step = z[track] - self._records['last'][track, 0]
        step[self._records['updated'][track] < self._now - round(dt * NANOSECONDS)] = np.nan
        past = np.roll(self._velocity[track], 1, axis=1)
        turned = np.isnan(past).all(axis=(1, 2, 3)) & ~np.isnan(step[:, 0])
        past[:, 0, 0] = step
        past[:, 0, 1] = np.where(turned[:, None], np.nan, self._bank.mean[0, track, 2:] * dt)
        self._velocity[track] = past
        best = self._swarm.search(past.reshape(len(track), -1, 2))
        self._bank.set_velocity(track, best / dt)

    def _renew(self, matches: Matches, believed: Bools) -> None:
        """Take new templates from this frame: all of them, or with drift compensation few.

        A template's error stays with the target as long as its successors are found by it, so each
        is kept until the target looks clearly less like it than in the beginning.
        """
        position = self._bank.estimate()[0][:, :2]
        place = np.where(believed[:, None], matches.z, position)
        self._records['last'] = np.stack([place, position], axis=1)
        for i, (part, template) in enumerate(zip(matches.crops, self._templates, strict=True)):
            if self.config.drift_compensation:
                alike = float(matches.similarity[i]), float(matches.correlation[i])
                worn = bool(believed[i]) and template.record_match(*alike, self.config.renewal)
            else:
                worn = part is not None
            if part is not None and worn:
                self._records['drift'][i] += np.nan_to_num(matches.R[i])
                self._templates[i] = Template(
                    part.window(place[i], template.picture.shape), template
                )
            elif self.config.drift_compensation and not believed[i] and template.former:
                # It may have taken on what covers the target: try the one before, by turns.
                former, template.former = template.former, None
                former.former = template
                self._templates[i] = former

    def _settle(self, frame: Frame) -> None:
        """Give up targets whose center has left the picture, or that were not seen for long."""
        place, (height, width) = self._bank.estimate()[0][:, :2], frame.image.shape[:2]
        inside = ((place >= -0.5) & (place < [width - 0.5, height - 0.5])).all(axis=1)
        limit = round(self.config.max_time_since_update * NANOSECONDS)
        keep = inside & (self._now - self._records['updated'] <= limit)
        self._bank.keep(keep)
        self._records, self._velocity = self._records[keep], self._velocity[keep]
        self._templates = [t for t, kept in zip(self._templates, keep, strict=True) if kept]

    def _unfollowed(self, boxes: Floats) -> Floats:
        """Those whose centers are in no target's box."""
        if not len(boxes):
            return boxes
        gap = np.abs(_centers(boxes)[:, None] - self._bank.estimate()[0][:, :2])
        inside = np.all(gap <= self._records['box'] / 2, axis=2)
        return boxes[~np.any(inside, axis=1)]

    def _begin(self, frame: Frame, boxes: Floats) -> None:
        """Cut the templates of new targets."""
        if not len(boxes):
            return
        center = _centers(boxes)
        size = np.array(frame.image.shape[1::-1])
        with np.errstate(invalid='ignore'):
            good = ((center >= 0) & (center <= size - 1) & (boxes[:, 2:] >= 1)).all(axis=1)
        boxes, center = boxes[good], center[good]
        room = max(self.config.max_targets - len(self._records), 0)
        boxes, center = boxes[:room], center[:room]
        self.refused += good.size - len(boxes)
        wanted = self.config.window or np.maximum(boxes[:, 2:], LEAST)
        odd = np.minimum(wanted, size).astype(int) - 1 | 1
        odd = np.broadcast_to(odd, boxes[:, 2:].shape)
        whole = Crop.of(frame, np.zeros(2, int), size - 1)
        for place, (w, h) in zip(center, odd.tolist(), strict=True):
            self._templates.append(Template(whole.window(place, (h, w))))
        self._append(center, boxes[:, 2:])

    def _append(self, center: Floats, box: Floats) -> None:
        """New filters and records."""
        R = np.broadcast_to(SUBPIXEL_SIGMA**2 * np.eye(2), (len(center), 2, 2))
        spread = np.repeat([0.0, self.config.initial_speed], 2)
        self._bank.extend(self._bank.at_rest(center, R, spread))
        new = births(center, box, self._now, self._next_id)
        self._next_id += len(new)
        self._records = np.concatenate([self._records, new])
        none = np.full((len(new), self.config.swarm_frames, 2, 2), np.nan)
        self._velocity = np.concatenate([self._velocity, none])

    @property
    def _now(self) -> int:
        return self._stamp or 0


def _centers(boxes: Floats) -> Floats:
    return boxes[:, :2] + (boxes[:, 2:] - 1) / 2


def _boxes(values: ArrayLike) -> Floats:
    """(N, 4) of any numbers of boxes."""
    return np.asarray(values, float).reshape(-1, 4)
