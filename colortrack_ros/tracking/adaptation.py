"""What is learned of the scene: speed, process noise, maneuvers, clutter and new objects."""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from colortrack_ros.tracking.borders import Borders
from colortrack_ros.tracking.camera import Camera
from colortrack_ros.tracking.detection_rate import DetectionRate
from colortrack_ros.tracking.disappearances import Disappearances
from colortrack_ros.tracking.maneuvers import Maneuvers
from colortrack_ros.tracking.noise import MeasurementNoise
from colortrack_ros.tracking.overlaps import Overlaps
from colortrack_ros.tracking.process_noise import ProcessNoise
from colortrack_ros.tracking.recent import Recent
from colortrack_ros.tracking.resolution import Resolution
from colortrack_ros.tracking.sizes import Sizes

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

# Constants marked "assumed" were set by hand; benchmark/ablation.py --constants adaptation.NAME
# shows what IDF1 becomes with half and twice the value.

FIRST_SPEED = 700.0
"""Speed before any is learned [px/s]. Assumed."""

VGA = 640 * 480
"""Area of a picture [px^2] up to which what goes off all at once has FIRST_SPEED; in larger ones,
which show the same things larger, it is as much faster."""

FIRST_WATCHED, SPEED_MEMORY = 1.0, 0.33
"""Time of watching a track that this speed is worth, and memory for the speed of many [s].
Assumed."""

SPEED_FROM = 20
"""Objects whose displacements between their first two frames tell their speed: 20 give the 80 %
quantile of a Rayleigh distribution within 14 % (the asymptotic standard error)."""

QUANTILE = 0.8
"""Of those displacements. The largest fifth may lead to the nearest detection of another object."""

LEAST_SPEED = 100.0
"""An object at rest may start to move this fast at any time [px/s]. Assumed."""

FIRST_FALSE, LEAST_NEW = 0.003, 0.003
"""False detections a frame to start from, and new objects a frame, at least. Assumed: one in 11 s
at 30 frames/s."""

FIRST_AREA = 3e5
"""Least area of the picture while its size is not known [px^2]: about 640 x 480."""

BORDER, ENTERING, FEW_PLACES = 0.05, 0.9, 10.0
"""Width of the border, a share of the picture, share of the new objects that begin there, and how
many that have begun this is worth. Assumed."""

AT_START, LONG, WORTH = 15, 600, 90
"""Frames of the start, whose objects are not new, a memory for the others, and what the first rate
is worth in it [frames]. Assumed: half a second, 20 s, 3 s."""

SLOW = 0.03
"""Share of a frame in the rate of false detections: a memory of 33 frames. Assumed."""

HALF_GAIN_TRACKS = 4.0
"""Number of tracks whose frame has half the share: fewer say less about the scene. Assumed."""

NO_OUTLINE = 2.0
"""Boxes that jitter by so many times the tolerance of outlines are none. Assumed: blobs that merge
have up to 2.2. With 1 those lose 40 points of IDF1, with 4 pedestrians of a network 8."""


class Adaptation:
    """Learns from the tracks that have been measured."""

    def __init__(self) -> None:
        self.recent = Recent()
        self.unsteadiness = ProcessNoise()
        self._speed2 = np.full(2, FIRST_SPEED**2)
        self._watched = FIRST_WATCHED
        self.sizes = Sizes()
        self.has_met = False
        """Whether there have been objects."""
        self._places = FEW_PLACES * np.array([ENTERING, 1 - ENTERING])
        self._begun, self._watched_for = WORTH * LEAST_NEW, float(WORTH)
        self._false, self._frames, self._births = FIRST_FALSE, 3, LEAST_NEW
        self._low, self._high = np.full(2, np.inf), np.full(2, -np.inf)
        self.area = FIRST_AREA
        """Of the picture [px^2], as far as it is known."""
        self.disappearances = Disappearances()
        """What has become of objects that were lost."""
        self.image_size = (0, 0)
        """Width and height of the picture [px]; 0 while they are not known."""
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
        """Whether who detects looks for whole objects, as networks do: boxes overlap, or jitter."""
        return self.overlaps.are_resolved or self.sizes.looseness > NO_OUTLINE

    @property
    def noise(self) -> float:
        """sigma_s, standard deviation of the acceleration on each axis [px/s^2]."""
        return math.exp(self.unsteadiness.log_noise)

    @property
    def speed(self) -> Floats:
        """Root mean square of the velocity on each axis, (2,), at least LEAST_SPEED [px/s]."""
        return np.maximum(np.sqrt(self._speed2), LEAST_SPEED)

    @property
    def sudden_speed(self) -> float:
        """The same of what goes off all at once, however slow all was before [px/s]."""
        size = self.image_size
        return FIRST_SPEED * math.sqrt(max(size[0] * size[1] / VGA, 1.0))

    @property
    def density(self) -> float:
        """Detections a frame that belong to no track yet, false or new [1/px^2]."""
        return (self._false + self._births) / self.area

    @property
    def births(self) -> float:
        """New objects a frame, of the last second."""
        return self._births

    @property
    def lasting_births(self) -> float:
        """New objects a frame, of the last LONG frames; not those that were there at the start."""
        return self._begun / self._watched_for

    def birth_places(self, z: Floats) -> Floats:
        """Density at z, (K, 2), (K,), of where objects begin [1/px^2]: most at the border."""
        if not all(self.image_size):
            return np.full(len(z), 1 / self.area)
        inner = (1 - 2 * BORDER) ** 2
        entered, appeared = self._places / self._places.sum()
        share = np.where(self._is_at_border(z), entered / (1 - inner), appeared / inner)
        return np.asarray(share / self.area)

    def _is_at_border(self, z: Floats) -> Bools:
        """Which positions, (K, 2) [px], are at the border of the picture, (K,)."""
        from_border = np.minimum(z, np.array(self.image_size) - z) / self.image_size
        return np.asarray(from_border.min(axis=1) < BORDER)

    def know_size(self, image_size: tuple[int, int]) -> None:
        """Take the size of the picture [px], if it is known; once known it holds on."""
        if all(image_size):
            self.image_size = image_size
            self.area = float(image_size[0] * image_size[1])

    def learn_size(self, z: Floats) -> None:
        """Take the detections of a frame, (M, 2) [px]: the box around all so far is the picture."""
        if len(z) and not all(self.image_size):
            if np.count_nonzero((z >= self._low) & (z <= self._high)) == z.size:
                return
            self._low = np.minimum(self._low, z.min(axis=0))
            self._high = np.maximum(self._high, z.max(axis=0))
            width, height = self._high - self._low
            self.area = max(float(width * height), FIRST_AREA)

    def meet(self, before: Floats, after: Floats, dt: float) -> None:
        """Learn the speed from the first objects, (N, 2), and the next detections, (M, 2) [px].

        For most objects the nearest detection is their own, unless they are so dense and fast that
        they change places. The displacement has a Rayleigh distribution.

        :param dt: between the two [s].
        """
        self.has_met = True
        if min(len(before), len(after)) >= SPEED_FROM:
            way = float(np.quantile(cKDTree(after).query(before)[0], QUANTILE))
            sigma = way / math.sqrt(-2 * math.log(1 - QUANTILE))
            self._speed2 = np.minimum(self._speed2, (sigma / dt) ** 2)

    def learn_new(self, false: int, origin: Floats) -> None:
        """Take the tracks that in a frame ended unconfirmed, and those that were confirmed.

        :param false: how many ended.
        :param origin: (K, 2) where those confirmed began [px].
        """
        true = len(origin)
        if true and all(self.image_size):
            entered = np.count_nonzero(self._is_at_border(origin))
            self._places += entered, true - entered
        self._frames += 1
        self._false += max(SLOW, 1 / self._frames) * (false - self._false)
        self._births += SLOW * (max(true, LEAST_NEW) - self._births)
        if self._frames > AT_START:
            self._begun += true - self._begun / LONG
            self._watched_for += 1 - self._watched_for / LONG

    def learn_speed(self, steady: Bools, velocity: Floats, dt: float) -> None:
        """Take the velocities of tracks measured in a frame, (K, 2) [px/s].

        :param steady: (K,) which of them to learn from: measured in this frame and in the last.
        :param dt: since the last frame [s].
        """
        count = int(np.count_nonzero(steady))
        if count:
            self._watched += count * dt
            memory = SPEED_MEMORY * (1 + HALF_GAIN_TRACKS / count)
            share = max(-math.expm1(-dt / memory), count * dt / self._watched)
            self._speed2 += share * (steady / count @ velocity**2 - self._speed2)
