"""Templates: the picture of a target, and the exact position of a window that resembles it."""

from functools import cached_property

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.data import Frame
from colortrack_ros.windows.crop import Crop
from colortrack_ros.windows.crop import cut_window
from colortrack_ros.windows.crop import Gray

GAUSS_NEWTON_STEPS = 2
"""Gauss-Newton steps to align a window. With 1 the RMSE on the scene `texture` is 0.62 px, with 2
0.32, with 4 0.28 (``benchmark/windows.py --seeds 1 --constants template.GAUSS_NEWTON_STEPS``; the
figures below come from the same command)."""

MAX_STEP = 1.0
"""Largest step [px of the template]: the initial match is accurate to a pixel. Half and twice the
value change nothing."""

RENEWAL_MATCHES = 3
"""Consecutive matches for which a change in appearance has to last, unless it is a rotation or a
change of scale. With 1 templates adopt whatever covers the target (RMSE 0.58 instead of 0.15 px on
`hidden`), with 6 nothing changes."""

EXPLAINED_SHARE = 0.6
"""Largest loss of similarity of a rotation or a change of scale, as a share of the loss of
correlation. Half the value changes little (0.30 px on `texture`, not 0.32), twice the value takes
covers for rotations (0.58 px on `hidden`)."""

PROVEN_MATCHES = 12
"""Valid matches after which a template is known to show the target, and nothing that was about to
cover it. Half and twice the value change nothing on five scenes with three seeds each
(``benchmark/windows.py --constants template.PROVEN_MATCHES --seeds 3``)."""

COARSE_SIDE = 64
"""Least side of a template in pixels, in the mean of width and height. A window twice as large is
compared in a picture of half the size, and so on. Assumed: on 17 public sequences of large targets
half and twice the value change success by less than 1 %, and a frame takes 3.9 and 4.5 ms instead
of 4.2."""


class Template:
    """Picture of a target to match.

    :param picture: (h, w) gray levels, float32, both odd.
    :param last: the template before this one.
    :param times: side, in pixels of the frame, of the square that each pixel averages.
    :ivar matches: valid matches so far.
    :ivar former: the last proven template, a fallback if this one is not found.
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
        """Template of the window around a center (u, v) [px], of an odd width and height [px]."""
        times = max(int((width * height) ** 0.5 / COARSE_SIDE), 1)
        shape = (height // times - 1) | 1, (width // times - 1) | 1
        return cls(cut_window(frame, center, shape, times), times=times)

    def renewed(self, frame: Frame, center: Floats) -> 'Template':
        """The successor of this template, taken around a center (u, v) [px]."""
        window = cut_window(frame, center, self.picture.shape, self.times)
        return Template(window, self, self.times)

    def record_match(self, similarity: float, correlation: float, renewal: float) -> bool:
        """Record a valid match; return whether its window should be the next template.

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

    def share_kept(self, similarity: float) -> float:
        """The share of what was like the template at first that still is, 0 to 1.

        A similarity is a coefficient of multiple correlation, whose square is the explained share.
        """
        first = self._first_match[0] if self._first_match else 0.0  # a sighting has none
        return min(similarity / first, 1.0) ** 2 if first > 0 else similarity**2

    def correlation(self, window: Gray) -> float:
        """Zero-mean normalized correlation, -1..1; 0 without texture."""
        centered, norm = self._centered
        other = window.ravel() - window.mean()
        norm *= float(np.sqrt(np.dot(other, other)))
        return float(np.dot(centered, other)) / norm if norm > 0 else 0.0

    def align(self, crop: Crop, position: Floats) -> tuple[Floats, float, float]:
        """Align the template with a window, with rotation and scale separate from translation.

        Least squares fit of the template to the window under a small translation, rotation, and
        change of scale, brightness and contrast, all at once (Hager and Belhumeur 1998). Matching
        alone mistakes part of a rotation for a translation, and each new template found that way
        would let the target drift away.

        :param position: (u, v) of the window's center, within about a pixel [px].
        :return: the corrected position; the similarity there, which is the coefficient of multiple
            correlation: near 1 for a window that is the transformed template, less where something
            covers it; and the correlation.
        """
        jacobian, solver = self._jacobian
        for _ in range(GAUSS_NEWTON_STEPS):
            residual = self._residual(crop, position)
            step = np.clip(solver[:2] @ residual, -MAX_STEP, MAX_STEP)
            position = position + self.times * step
        residual = self._residual(crop, position)
        window = self.picture.ravel() + residual
        window -= window.mean()
        residual += (solver @ residual) @ jacobian
        unexplained, total = float(np.dot(residual, residual)), float(np.dot(window, window))
        correlation = self.correlation(window)
        if correlation <= 0 or total <= unexplained:
            return position, 0.0, correlation
        return position, float(np.sqrt(1 - unexplained / total)), correlation

    def _residual(self, crop: Crop, position: Floats) -> Gray:
        """The window at a position minus the template, (n,)."""
        return np.asarray((crop.window(position, self.picture.shape) - self.picture).ravel())

    @cached_property
    def _centered(self) -> tuple[Gray, float]:
        """The picture minus its mean, (n,), and its norm."""
        centered = self.picture.ravel() - self.picture.mean()
        return centered, float(np.sqrt(np.dot(centered, centered)))

    @cached_property
    def _jacobian(self) -> tuple[Gray, Gray]:
        """Jacobian of the window's n pixels, (6, n), and its negative pseudoinverse, (6, n).

        The rows are translation along u and v, scale, rotation, contrast and brightness.
        """
        dv, du = np.gradient(self.picture)
        h, w = self.picture.shape
        v, u = np.arange(h)[:, None] - h // 2, np.arange(w) - w // 2
        rows = [du, dv, u * du + v * dv, u * dv - v * du, self.picture, np.ones((h, w))]
        J = np.stack([row.ravel() for row in rows]).astype(float)
        solver = -np.linalg.pinv(J @ J.T, hermitian=True) @ J
        return J.astype(np.float32), solver.astype(np.float32)
