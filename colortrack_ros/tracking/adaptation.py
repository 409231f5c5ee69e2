"""Adaptation: speed, process noise, maneuvers, clutter and new objects, learned from the scene."""

from collections import deque
import math

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.estimation.existence import CALM_PERIOD
from colortrack_ros.estimation.time_limits import MOST_SECONDS
from colortrack_ros.tracking.borders import Borders
from colortrack_ros.tracking.camera import Camera
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.detection_rate import DetectionRate
from colortrack_ros.tracking.disappearances import Disappearances
from colortrack_ros.tracking.first_speed import share_enough
from colortrack_ros.tracking.first_speed import share_of_speed
from colortrack_ros.tracking.first_speed import two_nearest
from colortrack_ros.tracking.maneuvers import Maneuvers
from colortrack_ros.tracking.maneuvers import WINDOW
from colortrack_ros.tracking.noise import MeasurementNoise
from colortrack_ros.tracking.overlaps import Overlaps
from colortrack_ros.tracking.process_noise import ProcessNoise
from colortrack_ros.tracking.recent import Recent
from colortrack_ros.tracking.resolution import Resolution
from colortrack_ros.tracking.sizes import Sizes
from colortrack_ros.tracking.traffic import Entrances

# Constants marked "assumed" were set by hand; benchmark/ablation.py --constants adaptation.NAME
# shows what IDF1 becomes with half and twice the value.

FIRST_SPEED = 700.0
"""Speed before any is learned [px/s]. Assumed."""

VGA = 640 * 480
"""Area of a picture [px^2] up to which objects that start all at once have FIRST_SPEED; in larger
pictures, which show the same things larger, the speed scales with the side."""

FIRST_WATCHED, SPEED_MEMORY = 1.0, 0.33
"""Weight of FIRST_SPEED as a time of observing a track, and memory for the speed of many [s].
Assumed."""

SPEED_FROM, SURELY_FROM = 5, 20
"""Least number of objects of which the first two frames give the speed, and of which it is believed
to be less than tells neighbors apart: what rests may be hit in a moment. Assumed: of fewer than
five, one that is faster is too many; 20 have the root mean square speed with an error of 16 %."""

LEAST_SPEED = 100.0
"""Least speed: an object at rest may start to move this fast at any time [px/s]. Assumed."""

SLOW_PERIOD = 0.125
"""Frame period above which all is assumed to be slower in proportion [s]. Assumed: whoever takes
fewer than eight pictures a second watches what moves little from one to the next."""

FEWEST_PERIODS, PERIODS = 2, 8
"""Least number of such periods in a row, since one is a pause unless it is the very first, and how
many of the last ones the shortest is taken of. Assumed."""

FEWEST_MISSED = 4.5
"""Frames that a track outlives at least unmeasured, where frames are slow: four, and halfway to the
next, as stamps are rounded and jitter. The shortest period counts: stamps may be off by 5 % of one,
with 10 % three or four are outlived. Where one detection in ten is missing, four on end are for one
in 10,000."""

FIRST_FALSE, LEAST_NEW = 0.003, 0.003
"""Initial rate of false detections, and least rate of new objects, per frame. Assumed: one in 11 s
at 30 frames/s."""

FIRST_NEW = 0.01
"""Initial rate of new objects over a long time, per frame. Assumed: one in 3 s at 30 frames/s."""

FIRST_AREA = 3e5
"""Least area of the picture while its size is not known [px^2]: about 640 x 480."""

AREA_SHRINKING = 0.6
"""Factor on that area for each new object inside a smaller one. If the logarithm of the area is
normal with variance 1/2, n objects move its mode by -n/2, until it meets the area seen. Assumed."""

AT_START, LONG, WORTH = 15, 600, 90
"""Initial frames, whose objects are not new; memory for the rate of new ones; weight of its initial
value [frames]. Assumed: half a second, 20 s, 3 s."""

SLOW = 0.03
"""Weight of a frame in the rate of false detections: a memory of 33 frames. Assumed."""

HALF_GAIN_TRACKS = 4.0
"""Number of tracks at which a frame has half its weight: fewer say less of the scene. Assumed."""

NO_OUTLINE = 2.0
"""Jitter of boxes, over the tolerance of outlines, above which they are no outlines. Assumed: blobs
that merge have up to 2.2. With 1 those lose 40 points of IDF1, with 4 pedestrians lose 8."""


NO_ORIGINS = np.zeros((0, 2))
"""Where nothing started."""


class Adaptation:
    """Learns from measured tracks.

    :param longest: see Disappearances.
    """

    def __init__(self, longest: float) -> None:
        self.recent = Recent()
        self.unsteadiness = ProcessNoise()
        self.slow_periods = deque[float](maxlen=PERIODS)
        """The last periods above SLOW_PERIOD, in a row [s]."""
        self.slowness = self.calm = 1.0
        """Frame period over SLOW_PERIOD, and over CALM_PERIOD, at least 1."""
        self._least_speed = LEAST_SPEED
        self._speed2, self._share = np.full(2, FIRST_SPEED**2), 1.0
        self._watched = FIRST_WATCHED
        self._is_slow_unseen = False
        """Whether the speed is that of few objects of a source that seems slow."""
        self.sizes = Sizes()
        self.has_met = False
        """Whether there have been objects yet."""
        self._entrances = Entrances()
        self._begun, self._watched_for = WORTH * FIRST_NEW, float(WORTH)
        self._false, self._frames, self._births = FIRST_FALSE, 3, LEAST_NEW
        self._late, self._late_at = 0.0, 0
        self._met, self._seen_area = 0, 0.0
        self._low, self._high = np.full(2, np.inf), np.full(2, -np.inf)
        self.area = FIRST_AREA
        """Area of the picture [px^2], as far as known."""
        self.disappearances = Disappearances(longest)
        """What became of lost objects."""
        self.image_size = (0, 0)
        """Width and height of the picture [px]; 0 while unknown."""
        self.sudden_speed = FIRST_SPEED
        """As speed, for objects that start all at once, however slow all was before [px/s]."""
        self.noisiness = MeasurementNoise()
        self.maneuvers = Maneuvers()
        self.camera = Camera()
        self.resolution = Resolution()
        self.overlaps = Overlaps()
        self.detection_rate = DetectionRate()
        self.borders = Borders()
        """Where boxes end, while the size of the picture is not known."""

    @property
    def finds_whole(self) -> bool:
        """Whether the detector finds complete objects, as networks do: boxes overlap, or jitter."""
        return self.overlaps.are_resolved or self.sizes.looseness > NO_OUTLINE

    @property
    def noise(self) -> float:
        """sigma_s, standard deviation of the acceleration on each axis [px/s^2]."""
        return math.exp(self.unsteadiness.log_noise)

    @property
    def speed(self) -> Floats:
        """Root mean square of the velocity on each axis, (2,), at least LEAST_SPEED [px/s]."""
        return np.maximum(np.sqrt(self._speed2), self._least_speed)

    @property
    def density(self) -> float:
        """Density of unassociated detections in a frame, false alarms and new objects [1/px^2]."""
        return (self._false + self._births) / self.area

    @property
    def births(self) -> float:
        """New objects per frame in the last second."""
        return self._births

    @property
    def lasting_births(self) -> float:
        """New objects per frame in the last LONG frames, without those present at the start."""
        return self._begun / self._watched_for

    @property
    def expected_births(self) -> float:
        """New objects in a frame now: as in the last LONG frames, or as many as lately.

        One alone is no crowd, and does not count as lately.
        """
        return max(self.lasting_births, self._lately() - SLOW)

    def _lately(self) -> float:
        """Mean number of new objects per frame with the memory of SLOW, without those at the start.

        It is updated only in frames with new objects: most have none.
        """
        return self._late * (1 - SLOW) ** (self._frames - self._late_at)

    @property
    def birth_area(self) -> float:
        """Area in which new objects appear [px^2], as far as known."""
        if all(self.image_size):
            return self.area
        return max(self._seen_area, FIRST_AREA * AREA_SHRINKING**self._met)

    def birth_places(self, z: Floats) -> Floats:
        """Density of new objects at z, (K, 2): (K,) [1/px^2]; most appear near the border."""
        return self._entrances.density(z, *self._bounds) / self.birth_area

    @property
    def _bounds(self) -> tuple[Floats, Floats]:
        """Corners of the picture, (2,) each [px], or of the box around all detections so far."""
        if all(self.image_size):
            return np.zeros(2), np.array(self.image_size, float)
        return self._low, self._high

    def learn_period(self, period: float) -> None:
        """Learn how slow all is from the time since the last frame [s]."""
        if period <= SLOW_PERIOD:
            if len(self.slow_periods) == 1 and self._is_slow_unseen:
                self._speed2 = np.full(2, FIRST_SPEED**2)  # it was a pause after the first frame
            self.slow_periods.clear()
        else:
            self.slow_periods.append(period)
        slow = len(self.slow_periods) >= (FEWEST_PERIODS if self.has_met else 1)
        self.slowness = min(self.slow_periods) / SLOW_PERIOD if slow else 1.0
        self.calm = max(SLOW_PERIOD * self.slowness / CALM_PERIOD, 1.0)
        self.maneuvers.stretch = max(SLOW_PERIOD * self.slowness / WINDOW, 1.0)
        self._least_speed = LEAST_SPEED / self.slowness
        self.unsteadiness.assume(self.slowness, self._share)

    def patient(self, config: TrackerConfig) -> TrackerConfig:
        """Return a configuration with which tracks outlive FEWEST_MISSED slow frames at least."""
        if self.slowness == 1:
            return config
        least = FEWEST_MISSED * SLOW_PERIOD * self.slowness
        return config.outliving(min(least, MOST_SECONDS))

    def know_size(self, image_size: tuple[int, int]) -> None:
        """Set the size of the picture [px]; zeros, for unknown, are ignored."""
        if image_size != self.image_size and all(image_size):
            self.image_size = image_size
            self.area = float(image_size[0] * image_size[1])
            self.sudden_speed = FIRST_SPEED * math.sqrt(max(self.area / VGA, 1.0))

    def learn_size(self, z: Floats) -> None:
        """Estimate the picture as the box around all detections so far, z (M, 2) [px]."""
        if len(z) and not all(self.image_size):
            if np.count_nonzero((z >= self._low) & (z <= self._high)) == z.size:
                return
            self._low = np.minimum(self._low, z.min(axis=0))
            self._high = np.maximum(self._high, z.max(axis=0))
            width, height = self._high - self._low
            self._seen_area = float(width * height)
            self.area = max(self._seen_area, FIRST_AREA)

    def meet(self, before: Floats, after: Floats, dt: float) -> None:
        """Learn the speed from the first objects, (N, 2), and the next detections, (M, 2) [px].

        Fewer than SPEED_FROM are assumed to be as slow as their source is.

        :param dt: between the two [s].
        """
        self.has_met = True
        if min(len(before), len(after)) >= SPEED_FROM:
            way = FIRST_SPEED * min(dt, SLOW_PERIOD)
            near = two_nearest(before, after) / way
            share = share_of_speed(near)
            if len(before) < SURELY_FROM:
                share = max(share, share_enough(near))
            self._speed2 = np.full(2, (share * way / dt) ** 2)
            self._share = max(share, LEAST_SPEED / FIRST_SPEED)
            self.unsteadiness.assume(self.slowness, self._share)
        elif dt > SLOW_PERIOD:
            self._is_slow_unseen = True
            self._speed2 = np.full(2, (FIRST_SPEED * SLOW_PERIOD / dt) ** 2)

    def learn_new(self, false: int = 0, origin: Floats = NO_ORIGINS) -> None:
        """Learn from the tracks deleted unconfirmed in a frame, and from those confirmed.

        :param false: number of tracks deleted unconfirmed.
        :param origin: (K, 2) where the confirmed ones started [px].
        """
        true = len(origin)
        self._frames += 1
        if true:
            self._entrances.learn(origin, *self._bounds)
            if not all(self.image_size):
                self._met += true
            if self._frames > AT_START:
                self._late, self._late_at = self._lately() + SLOW * true, self._frames
        self._false += max(SLOW, 1 / self._frames) * (false - self._false)
        self._births += SLOW * (max(true, LEAST_NEW) - self._births)
        if self._frames > AT_START:
            self._begun += true - self._begun / LONG
            self._watched_for += 1 - self._watched_for / LONG

    def learn_speed(self, steady: Bools, velocity: Floats, dt: float) -> None:
        """Learn from the velocities of tracks measured in a frame, (K, 2) [px/s].

        :param steady: (K,) which to learn from: measured in this frame and in the last.
        :param dt: since the last frame [s].
        """
        count = np.count_nonzero(steady)
        if count:
            self._watched += count * dt
            memory = SPEED_MEMORY * (1 + HALF_GAIN_TRACKS / count)
            share = max(-math.expm1(-dt / memory), count * dt / self._watched)
            self._speed2 += share * (steady / count @ velocity**2 - self._speed2)
