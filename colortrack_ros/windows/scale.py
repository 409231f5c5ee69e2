"""The size of a target, by a correlation filter over sizes (Danelljan et al. 2014, 4)."""

import cv2
import numpy as np
from scipy import fft

from colortrack_ros.data import Floats
from colortrack_ros.data import Frame
from colortrack_ros.windows.config import LEAST_SIDE
from colortrack_ros.windows.correlation import Spectrum
from colortrack_ros.windows.features import CELL
from colortrack_ros.windows.features import cut
from colortrack_ros.windows.features import Features
from colortrack_ros.windows.features import oriented_gradients
from colortrack_ros.windows.features import Pixels
from colortrack_ros.windows.features import to_gray
from colortrack_ros.windows.peaks import vertex

SCALE_RATE, SCALE_REGULARIZATION = 0.025, 1e-2
"""Learning rate, and regularization of the energy (Danelljan et al. 2014, 5.1)."""

COUNT, SCALE_STEP = 11, 1.06
"""Number of sizes compared, and ratio of neighbors. They reach 34 % up and down, as do the 33 steps
of 1.02 of that paper, which take three times as long. On 17 public sequences sizes are 14 % off;
with the 33 steps 15 %, and with 17 steps of 1.02, which reach 17 %, 20 %
(``benchmark/windows_sizes.py FOLDER``)."""

LABEL_SIGMA = 1.0
"""Width of the desired peak, in steps. Widths of 1 to 1.5 with 11, 13, or 17 steps do as well."""

UNCHANGED = 0.1
"""Changes below this many steps, 0.6 %, are noise. With 0, sizes are as far off on those
sequences."""

RESAMPLED = 0.5
"""From this many steps of change on, the filter learns from a patch of the new size. Doing so after
every change takes half as much time again, and sizes are as far off."""

PATCH_SIDE = 32
"""Pixels of the side of a patch, in the mean of width and height: 512 of an area (ibid.), doubled
for cells that are as large as the target's."""

FINER = 2
"""Resolution, relative to a patch, of the one picture that the patches of all sizes come from.
Derived: the next integer above the ratio of the outer sizes, 1.06^10 = 1.79, so that the smallest
size is not magnified."""

LEAST_GRADIENT = 1e-3
"""Greatest gradient, normalized, of a flat patch: rounding. Derived: a single pixel that differs by
one level has more."""

TAPER = np.hanning(COUNT + 2)[1:-1, None].astype(np.float32)
"""Weights of the sizes: those farthest from the present one count least."""


class ScaleFilter:
    """The size of one target.

    :param center: u, v [px].
    :param size: initial width and height [px].
    """

    def __init__(self, frame: Frame, center: Floats, size: Floats) -> None:
        self.scale, self._size = 1.0, size
        steps = np.arange(COUNT) - COUNT // 2
        self._factors = SCALE_STEP**steps
        wanted = np.exp(-0.5 * (steps / LABEL_SIGMA) ** 2).astype(np.float32)
        self._wanted = np.conj(fft.rfft(wanted))[:, None]
        cells = np.maximum(
            np.rint(size * (PATCH_SIDE / np.sqrt(size.prod()) / CELL)).astype(int), 2
        )
        self._patch = tuple(np.minimum(cells * CELL, 4 * PATCH_SIDE).tolist())
        self._places = self._grids()
        self._numerator, self._energy = self._lesson(_spectrum(self._gradients(frame, center)))

    def _grids(self) -> tuple[Features, Features]:
        """Return where the pixels of the patches of all sizes, one below the other, come from."""
        v, u = (
            (FINER * n - 1) / 2 + np.outer(self._factors / self._factors[-1], FINER * offset)
            for n, offset in ((n, np.arange(n) - (n - 1) / 2) for n in self._patch[::-1])
        )
        u, v = np.broadcast_arrays(u[:, None], v[:, :, None])
        columns = self._patch[0]
        return u.reshape(-1, columns).astype(np.float32), v.reshape(-1, columns).astype(np.float32)

    def update(self, frame: Frame, center: Floats) -> None:
        """Find the size of the target around a center, and learn its appearance."""
        gradients = self._gradients(frame, center)
        spectrum = _spectrum(gradients)
        answer = (np.conj(self._numerator) * spectrum).sum(axis=1) / (
            self._energy + SCALE_REGULARIZATION
        )
        answer = fft.irfft(answer, COUNT)
        step = vertex(answer, int(answer.argmax())) - COUNT // 2
        if step < 0 and gradients[COUNT // 2].max() < LEAST_GRADIENT:
            step = 0.0  # the outline of what has shrunk would be inside
        if abs(step) >= UNCHANGED:
            self.set(frame, self.scale * SCALE_STEP**step)
        if abs(step) >= RESAMPLED:
            spectrum = _spectrum(self._gradients(frame, center))
        numerator, energy = self._lesson(spectrum)
        self._numerator += SCALE_RATE * (numerator - self._numerator)
        self._energy += SCALE_RATE * (energy - self._energy)

    def set(self, frame: Frame, scale: float) -> None:
        """Set the scale, within limits.

        A target has at least the sides of a window that can be found, and is no larger than the
        picture, unless its first box was.
        """
        least, most = LEAST_SIDE / self._size.min(), (frame.image.shape[1::-1] / self._size).min()
        self.scale = float(np.clip(scale, min(least, 1.0), max(most, 1.0)))

    def _gradients(self, frame: Frame, center: Floats) -> Features:
        """Return the gradients of the patches of all sizes, (COUNT, n)."""
        greatest = self._size * (self.scale * self._factors[-1])
        rows, columns = FINER * self._patch[1], FINER * self._patch[0]
        whole = to_gray(_sample(frame, center, greatest, (columns, rows)), frame.encoding)
        patches = cv2.remap(whole, *self._places, cv2.INTER_LINEAR)
        gradients = oriented_gradients(np.asarray(patches))[0]
        return gradients.reshape(len(gradients), COUNT, -1).swapaxes(0, 1).reshape(COUNT, -1)

    def _lesson(self, spectrum: Spectrum) -> tuple[Spectrum, Features]:
        return self._wanted * spectrum, (spectrum.real**2 + spectrum.imag**2).sum(axis=1)


def _spectrum(gradients: Features) -> Spectrum:
    """Return the transform, over the sizes, of each gradient: (COUNT / 2 + 1, n)."""
    return np.asarray(fft.rfft(gradients * TAPER, axis=0))


def _sample(frame: Frame, center: Floats, size: Floats, out: tuple[int, int]) -> Pixels:
    """Return the part of a picture of that size [px] around a center, resampled."""
    step = size / out
    part = cut(frame, center, size + 2, float(step.min()))
    step = step / part.times
    middle = (np.array(part.pixels.shape[1::-1]) - 1) / 2 + (center - part.center) / part.times
    corner = middle - step * (np.array(out) - 1) / 2
    matrix = np.array([[step[0], 0, corner[0]], [0, step[1], corner[1]]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    warped = cv2.warpAffine(part.pixels, matrix, out, flags=flags, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(warped, np.uint8)
