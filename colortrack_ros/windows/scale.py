"""How large a target is, found by a correlation filter over sizes (Danelljan et al. 2014, 4)."""

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import fft

from colortrack_ros.data import Frame
from colortrack_ros.windows.features import CELL
from colortrack_ros.windows.features import Floats
from colortrack_ros.windows.features import ORIENTATIONS
from colortrack_ros.windows.features import oriented_gradients
from colortrack_ros.windows.features import sample
from colortrack_ros.windows.features import to_gray
from colortrack_ros.windows.peaks import vertex

SCALE_RATE, SCALE_REGULARIZATION = 0.025, 1e-2
"""Rate of learning, and what is added to the energy (Danelljan et al. 2014, 5.1)."""

COUNT, SCALE_STEP = 11, 1.06
"""Sizes that are compared, and the ratio of neighbors. They reach 34 % up and down, as the 33 steps
of 1.02 there do in three times the time. On 17 public sequences sizes are 14 % off, with those 33
15 %, with 17 of them, which reach 17 %, 20 % (``benchmark/windows_sizes.py FOLDER``)."""

LABEL_SIGMA = 1.0
"""Width of the wanted peak, in steps; 11, 13, or 17 steps, with widths of 1 to 1.5, do as well."""

UNCHANGED = 0.1
"""Steps that are no change but noise: 0.6 %. With none, sizes are as far off on those sequences."""

RESAMPLED = 0.5
"""Steps of change from which what is learned is taken at the new size. To take it so after every
change costs half as much time again, for sizes as far off."""

PATCH_SIDE = 32
"""Pixels of the side of a patch, in the mean of width and height: 512 of an area (ibid.), doubled
for cells that are as large as the target's."""

FINER = 2
"""Pixels for each of a patch in the one picture that those of all sizes are taken from."""

LEAST_SCALE, GREATEST_SCALE = 0.2, 5.0
"""Of the size that a target began with; what grows or shrinks more has been lost."""


class ScaleFilter:
    """The size of one target.

    :param center: u, v [px].
    :param size: width and height that it begins with [px].
    """

    def __init__(self, frame: Frame, center: Floats, size: Floats) -> None:
        self.scale, self._size = 1.0, size
        steps = np.arange(COUNT) - COUNT // 2
        self._factors = SCALE_STEP**steps
        self._wanted = np.conj(fft.fft(np.exp(-0.5 * (steps / LABEL_SIGMA) ** 2)))[:, None]
        self._taper = np.hanning(COUNT + 2)[1:-1, None]
        cells = np.maximum(
            np.rint(size * (PATCH_SIDE / np.sqrt(size.prod()) / CELL)).astype(int), 2
        )
        self._patch = tuple(np.minimum(cells * CELL, 4 * PATCH_SIDE).tolist())
        self._numerator, self._energy = self._lesson(self._spectrum(frame, center))

    def update(self, frame: Frame, center: Floats) -> None:
        """Find the size of the target around a center, and learn what it looks like."""
        spectrum = self._spectrum(frame, center)
        answer = (np.conj(self._numerator) * spectrum).sum(axis=1) / (
            self._energy + SCALE_REGULARIZATION
        )
        answer = fft.ifft(answer).real
        step = vertex(answer, int(answer.argmax())) - COUNT // 2
        if abs(step) >= UNCHANGED:
            self.scale = float(np.clip(self.scale * SCALE_STEP**step, LEAST_SCALE, GREATEST_SCALE))
        if abs(step) >= RESAMPLED:
            spectrum = self._spectrum(frame, center)
        numerator, energy = self._lesson(spectrum)
        self._numerator += SCALE_RATE * (numerator - self._numerator)
        self._energy += SCALE_RATE * (energy - self._energy)

    def _spectrum(self, frame: Frame, center: Floats) -> NDArray[np.complex128]:
        """Transform over the sizes of each gradient, (COUNT, n)."""
        greatest = self._size * (self.scale * self._factors[-1])
        rows, columns = FINER * self._patch[1], FINER * self._patch[0]
        whole = to_gray(sample(frame, center, greatest, (columns, rows)), frame.encoding)
        middle = np.array([columns - 1, rows - 1]) / 2
        patches = []
        for step in FINER * self._factors / self._factors[-1]:
            corner = middle - step * (np.array(self._patch) - 1) / 2
            matrix = np.array([[step, 0, corner[0]], [0, step, corner[1]]])
            flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
            patches.append(cv2.warpAffine(whole, matrix, self._patch, flags=flags))
        gradients = oriented_gradients(np.concatenate(patches))[..., 2 * ORIENTATIONS :]
        return np.asarray(fft.fft(gradients.reshape(COUNT, -1) * self._taper, axis=0))

    def _lesson(self, spectrum: NDArray[np.complex128]) -> tuple[NDArray[np.complex128], Floats]:
        return self._wanted * spectrum, (spectrum.real**2 + spectrum.imag**2).sum(axis=1)
