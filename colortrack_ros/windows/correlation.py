"""A correlation filter that tells a target from its surroundings."""

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.windows.features import Features

Spectrum = NDArray[np.complex64]

PEAK_SIGMA, FILTER_RATE = 0.1, 0.02
"""Width of the desired peak as a share of the target's size, and learning rate, both of KCF with
histograms of gradients (Henriques et al. 2015, table 2)."""

FILTER_REGULARIZATION = 1e-3
"""Added to the energy of each frequency (lambda of Staple, Bertinetto et al. 2016, table 1)."""

DISTRACTOR_SHARE, DISTRACTOR_RATE = 0.5, 0.25
"""Weight of the distractors, and their learning rate. Assumed: a distractor is beside the target
for a few looks. On nothing is 14.2 % on 30 public sequences with a weight of 0, 6.9 % with 0.5
(benchmark/notes/windows.md)."""


class CorrelationFilter:
    """A filter that responds with a peak where the target is, and less where distractors are.

    It has many channels and one denominator, in the frequency domain: H = sum A_l / (B + lambda)
    (Danelljan et al. 2014, (3)). It is cut off at the target's box: most of the patch is
    background, which moves differently and would drag the target along. This is the first step of
    the alternation by which Lukezic et al. 2017, 3.2, constrain a filter; two more steps gained
    nothing on ten public sequences.

    What distractors have in common with the target tells nothing about which is which. So a share
    of their mean numerator is subtracted, which leaves in what distinguishes the target (cf. Zhu et
    al. 2018, "Distractor-aware Siamese networks", (4)).

    :param features: (channels, rows, columns) with the target near the middle.
    :param target: its width and height [cells].
    :param place: (u, v) of the target relative to the middle [cells].
    :ivar window: (rows, columns) weights of the cells, 1 in the middle, falling to 0 past the rim.
    :ivar sigma: width of the peak [cells].
    """

    def __init__(self, features: Features, target: Floats, place: Floats) -> None:
        rows, columns = features.shape[1:]
        self.window = np.outer(_taper(rows), _taper(columns))
        self.sigma = PEAK_SIGMA * float(np.sqrt(target.prod()))
        self._shape = height, width = fft.next_fast_len(rows), fft.next_fast_len(columns)
        v, u = (np.arange(n) for n in self._shape)
        square = (u - columns // 2) ** 2 + (v[:, None] - rows // 2) ** 2
        wanted = np.exp(square / (-2 * self.sigma**2)).astype(np.float32)
        self._wanted = np.conj(fft.rfft2(wanted))
        near = (np.minimum(x, n - x) for x, n in ((v, height), (u, width)))  # the filter's origin
        self._inside = np.outer(*map(_share, near, target[::-1]))
        self._frequencies = fft.rfftfreq(width), fft.fftfreq(height)[:, None]
        self._numerator, self._energy = self._lesson(self.transform(features), place)
        self._distractors = np.zeros_like(self._numerator)
        self._filter = self._cut_off()

    def transform(self, features: Features) -> Spectrum:
        """Return the spectrum, (channels, height, width / 2 + 1), for learn and respond.

        Zeros are added up to sizes that are fast to transform.
        """
        return np.asarray(fft.rfft2(features * self.window, self._shape))

    def learn(self, spectrum: Spectrum, place: Floats) -> None:
        """Update the filter with the target's current appearance.

        :param place: (u, v) of the target relative to the middle of the features [cells].
        """
        numerator, energy = self._lesson(spectrum, place)
        numerator -= self._numerator
        numerator *= FILTER_RATE
        self._numerator += numerator
        self._energy += FILTER_RATE * (energy - self._energy)
        self._filter = self._cut_off()

    def unlearn(self, spectrum: Spectrum, place: Floats) -> None:
        """Update the filter with a distractor.

        It takes effect with the next learn, and lasts until others have come: what covers the
        target has been beside it before.

        :param place: (u, v) of the distractor relative to the middle of the features [cells].
        """
        numerator, _ = self._lesson(spectrum, place)
        numerator -= self._distractors
        numerator *= DISTRACTOR_RATE
        self._distractors += numerator

    def respond(self, spectrum: Spectrum) -> Features:
        """Return the response, (rows, columns), below 1: how well the target fits at each cell."""
        answer = fft.irfft2((self._filter * spectrum).sum(axis=0), self._shape)
        rows, columns = self.window.shape
        return np.asarray(answer[:rows, :columns])

    def _cut_off(self) -> Spectrum:
        """Return the conjugate of the filter, restricted to the target's box."""
        share = 1 / (self._energy + FILTER_REGULARIZATION)
        numerator = self._numerator - DISTRACTOR_SHARE * self._distractors
        whole = fft.irfft2(numerator * share, self._shape)
        whole *= self._inside
        spectrum = np.asarray(fft.rfft2(whole))
        return np.asarray(np.conj(spectrum, out=spectrum))

    def _lesson(self, spectrum: Spectrum, place: Floats) -> tuple[Spectrum, Features]:
        turns = sum(f * x for f, x in zip(self._frequencies, place, strict=True))
        moved = np.exp(2j * np.pi * turns).astype(np.complex64)  # puts the peak at the place
        energy = (spectrum.real**2 + spectrum.imag**2).sum(axis=0)
        return self._wanted * moved * spectrum, energy


def _taper(count: int) -> Features:
    """Return a Hann window without its zeros, since the transform wraps around the borders."""
    return np.hanning(count + 2)[1:-1].astype(np.float32)


def _share(place: Indices, side: float) -> Features:
    """Return the share of each cell, counted from the middle, inside a box of that side."""
    return np.clip((side + 1) / 2 - place, 0, 1).astype(np.float32)
