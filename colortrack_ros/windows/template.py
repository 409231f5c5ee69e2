"""What a target looks like, and where exactly a window looks like it."""

from functools import cached_property

import numpy as np

from colortrack_ros.data import Frame
from colortrack_ros.windows.crop import Crop
from colortrack_ros.windows.crop import cut_window
from colortrack_ros.windows.crop import Floats
from colortrack_ros.windows.crop import Gray

GAUSS_NEWTON_STEPS = 2
"""Steps towards the position of a window: with 1 the RMSE on the scene `texture` is 0.62 px, with 2
0.32, with 4 0.28 (``benchmark/windows.py --seeds 1 --constants template.GAUSS_NEWTON_STEPS``, which
tells of the constants below as well)."""

MAX_STEP = 1.0
"""The longest of them [px of the template]: the match that they begin with is right to a pixel.
Half and twice as much change nothing."""

RENEWAL_MATCHES = 3
"""Matches in a row that a change of look has to last, unless it is a rotation or a change of scale.
With 1 templates take on what covers the target (RMSE 0.58 instead of 0.15 px on `hidden`), with 6
nothing changes."""

EXPLAINED_SHARE = 0.6
"""It is one if the similarity falls by at most this share of what the correlation falls by. Half as
much changes little (0.30 px on `texture`, not 0.32), twice as much takes covers for rotations (0.58
px on `hidden`)."""

PROVEN_MATCHES = 12
"""Valid matches after which a template shows the target and nothing that was about to cover it.
Half and twice as many change nothing on five scenes with three seeds each (``benchmark/windows.py
--constants template.PROVEN_MATCHES --seeds 3``)."""

COARSE_SIDE = 64
"""Pixels of a template on a side, in the mean of width and height, at least. A window that has
twice as many is compared on a picture half as large, and so on. Assumed: on 17 public sequences of
large targets half and twice the value change success by less than 1 %, and a frame takes 3.9 and
4.5 ms instead of 4.2."""


class Template:
    """The look of a target.

    :param picture: (h, w) gray levels, float32, both odd.
    :param last: the template before this one.
    :param times: pixels of a frame, on either axis, of which each of them is the mean.
    :ivar matches: valid matches so far.
    :ivar former: the last template that had proven itself, for when this one is not found.
    """

    def __init__(self, picture: Gray, last: 'Template | None' = None, times: int = 1) -> None:
        self.picture, self.times = picture, times
        self.matches = 0
        self.former: Template | None = last
        if last is not None and last.matches < PROVEN_MATCHES:
            self.former = last.former
        if self.former is not None:
            self.former.former = None
        self._first_match: tuple[float, float] | None = None
        self._worn_matches = 0

    @classmethod
    def of(cls, frame: Frame, center: Floats, width: int, height: int) -> 'Template':
        """What is around a center (u, v) [px], of an odd width and height [px]."""
        times = max(int((width * height) ** 0.5 / COARSE_SIDE), 1)
        shape = (height // times - 1) | 1, (width // times - 1) | 1
        return cls(cut_window(frame, center, shape, times), times=times)

    def renewed(self, frame: Frame, center: Floats) -> 'Template':
        """The next one, of what is around a center (u, v) [px]."""
        window = cut_window(frame, center, self.picture.shape, self.times)
        return Template(window, self, self.times)

    def record_match(self, similarity: float, correlation: float, renewal: float) -> bool:
        """Take note of a valid match; return whether its window should be the next template.

        :param renewal: see WindowConfig.
        """
        if self._first_match is None:
            self._first_match = similarity, correlation
        first_similarity, first_correlation = self._first_match
        self.matches += 1
        loss = first_correlation - correlation
        self._worn_matches = self._worn_matches + 1 if loss > renewal else 0
        explained = first_similarity - similarity <= EXPLAINED_SHARE * loss
        return self._worn_matches > 0 and (explained or self._worn_matches >= RENEWAL_MATCHES)

    def correlation(self, window: Gray) -> float:
        """Zero-mean normalized correlation, -1..1; 0 where there is no texture."""
        centered, norm = self._centered
        other = window.ravel() - window.mean()
        norm *= float(np.sqrt(np.dot(other, other)))
        return float(np.dot(centered, other)) / norm if norm > 0 else 0.0

    def align(self, crop: Crop, position: Floats) -> tuple[Floats, float, float]:
        """Tell rotation and scale from translation.

        Least squares of the window by the template that is translated, rotated, scaled, and changed
        in brightness and contrast a little, all at a time (Hager and Belhumeur 1998). Matching
        alone takes part of a rotation for a translation, and with each new template so found the
        target would drift away.

        :param position: (u, v) of the window's center, within about a pixel [px].
        :return: the position corrected; the similarity there, which is the coefficient of multiple
            correlation, near 1 for a window that is the template so changed, and less where
            something covers it; and the correlation.
        """
        jacobian, solver = self._jacobian
        for _ in range(GAUSS_NEWTON_STEPS):
            residual = self._residual(crop, position)
            step = np.clip(solver[:2] @ residual, -MAX_STEP, MAX_STEP)
            position = position + self.times * step
        residual = self._residual(crop, position)
        window = self.picture.ravel() + residual
        residual = residual + (solver @ residual) @ jacobian
        unexplained, total = float(np.dot(residual, residual)), float(window.var() * window.size)
        correlation = self.correlation(window)
        if correlation <= 0 or total <= unexplained:
            return position, 0.0, correlation
        return position, float(np.sqrt(1 - unexplained / total)), correlation

    def _residual(self, crop: Crop, position: Floats) -> Gray:
        """The window at a position less the template, (n,)."""
        return np.asarray((crop.window(position, self.picture.shape) - self.picture).ravel())

    @cached_property
    def _centered(self) -> tuple[Gray, float]:
        """The picture less its mean, (n,), and its norm."""
        centered = self.picture.ravel() - self.picture.mean()
        return centered, float(np.sqrt(np.dot(centered, centered)))

    @cached_property
    def _jacobian(self) -> tuple[Gray, Gray]:
        """How the n pixels of a moving window change, (6, n), and what solves for it, (6, n).

        By translation along u and v, scale, rotation, contrast and brightness.
        """
        dv, du = np.gradient(self.picture)
        h, w = self.picture.shape
        v, u = np.arange(h)[:, None] - h // 2, np.arange(w) - w // 2
        rows = [du, dv, u * du + v * dv, u * dv - v * du, self.picture, np.ones((h, w))]
        J = np.stack([row.ravel() for row in rows]).astype(float)
        solver = -np.linalg.pinv(J @ J.T, hermitian=True) @ J
        return J.astype(np.float32), solver.astype(np.float32)
